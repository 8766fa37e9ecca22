"""What hangs on the planter's base: crane, planting head, seedling arm, and the ground it works on.

All of it is the machine itself: it outlives a reboot of the software.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass, field

from backend_clients.simulator.crane import PILLAR_X_M, TELESCOPE_M, Crane
from backend_clients.simulator.enu import Point
from backend_clients.simulator.kinematics import Base
from backend_clients.simulator.planting_site import Site, to_machine

REACH_M = 9.8
INSIDE_M = REACH_M + 1.0  # nobody may be so near to a crane that moves
NEAR_M = 20.0
COLD_OIL_C, WARM_OIL_C, OIL_TIME_S = 24.0, 52.0, 900.0


@dataclass(frozen=True, slots=True)
class Tuning:
    """What may be different about a planter in a what-if run. Chances are per action.

    Args:
        crane_speed: times the usual speed of the crane's joints.
        seedlings_per_head: that the head takes at one docking.
        docks_while_driving: takes the next seedling while the machine drives to the next site.
        most_points: of one site; ``None`` takes the usual density.
    """

    crane_speed: float = 1.0
    seedlings_per_head: int = 1
    docks_while_driving: bool = False
    most_points: int | None = None
    fail_dock: float = 0.02
    fail_crane: float = 0.01
    fail_ground: float = 0.03
    fail_scar: float = 0.04


FAILS_NEVER = Tuning(fail_dock=0.0, fail_crane=0.0, fail_ground=0.0, fail_scar=0.0)


@dataclass(slots=True)
class PlanterRig:
    """Crane, seedlings on their way, and the site; ``seed`` makes obstacles and failures repeatable."""

    seed: str
    tuning: Tuning = field(default_factory=Tuning)
    crane: Crane = field(default_factory=Crane)
    in_arm: bool = False
    in_head: int = 0
    site: Site | None = None
    stops: int = 0
    trees: int = 0
    worked: set[tuple[int, int]] = field(default_factory=set)
    oil_c: float = COLD_OIL_C
    pressure_bar: float = 25.0
    chance: random.Random = field(init=False)

    def __post_init__(self) -> None:
        self.chance = random.Random(f"planting/{self.seed}")  # noqa: S311
        self.crane.speed = self.tuning.crane_speed

    def step(self, dt_s: float) -> None:
        """Let the hydraulics follow what the crane does."""
        moving = self.crane.is_moving
        load = 0.0
        if moving:
            load = 110.0 + 55.0 * self.crane.pose["telescope"] / TELESCOPE_M + 20.0 * math.sin(self.crane.pose["boom"])
        self.pressure_bar += ((load or 25.0) - self.pressure_bar) * min(dt_s / 0.4, 1.0)
        goal = WARM_OIL_C if moving else COLD_OIL_C + 12.0
        self.oil_c += (goal - self.oil_c) * min(dt_s / OIL_TIME_S, 1.0)

    def person_m(self, base: Base, person: Point | None) -> float | None:
        """Return how far somebody is from the crane's pillar, ``None`` if nobody is there."""
        if person is None:
            return None
        x, y = to_machine(base, person)
        return math.hypot(x - PILLAR_X_M, y)

    def guard(self, base: Base, person: Point | None) -> str:
        """Return the guard's state: ``area-clear``, ``person-near`` or ``person-inside``."""
        away_m = self.person_m(base, person)
        if away_m is None or away_m >= NEAR_M:
            return "area-clear"
        return "person-inside" if away_m < INSIDE_M else "person-near"
