"""What the fleet did today: area, plants, utilisation, interventions. Pure; fed with what robots report.

A figure that a robot reports anew after a restart, or for another mission, counts from there: only growth counts.
What a robot did of the same mission while it was not heard counts when it is heard again, on the same day.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import date
from typing import Any

from hmi.domain.event import RobotEvent
from hmi.domain.robot import Mode, OrderStatus, Robot

MOST_GAP_S = 10.0  # time that nobody saw does not count as worked, nor as idle
_SUMS = ("area_m2", "plants", "working_s", "heard_s", "interventions")
MAX_STEP_M2 = 2_000.0  # in 10 s, of the widest machine at full speed; a larger step is another mission


@dataclass(slots=True)
class _Seen:
    at_s: float
    mission: str
    area_m2: float
    day: date
    is_heard: bool = True


@dataclass(frozen=True, slots=True)
class DayFigures:
    """Today's sums. ``utilisation`` is the share of heard time in which a mission ran, ``None`` before any."""

    area_m2: float
    plants: int
    working_s: float
    heard_s: float
    interventions: int

    @property
    def utilisation(self) -> float | None:
        """Share of heard time in which robots worked."""
        return self.working_s / self.heard_s if self.heard_s > 0 else None

    @property
    def interventions_per_hour(self) -> float | None:
        """Interventions per hour of work, ``None`` before a quarter of an hour of it."""
        return self.interventions / (self.working_s / 3600) if self.working_s >= 900 else None


@dataclass(slots=True)
class FleetDay:
    """Adds up one day; another day begins at zero."""

    day: date | None = None
    area_m2: float = 0.0
    plants: int = 0
    working_s: float = 0.0
    heard_s: float = 0.0
    interventions: int = 0
    _seen: dict[str, _Seen] = field(default_factory=dict)

    def see(self, robot: Robot, now_s: float, day: date) -> None:
        """Take what a robot says now; robots that are not heard add nothing."""
        self.turn(day)
        before = self._seen.get(robot.id)
        if not robot.is_registered:
            self._seen.pop(robot.id, None)
            return
        if not robot.link.is_online or robot.state is None:
            if before is not None:
                before.is_heard = False
            return
        order = robot.state.order
        now = _Seen(now_s, order.mission_id if order else "", order.area_done_m2 if order else 0.0, day)
        self._seen[robot.id] = now
        if before is None:
            return
        gap_s = max(0.0, now_s - before.at_s)
        if before.is_heard:
            self.heard_s += min(MOST_GAP_S, gap_s)
            self.working_s += min(MOST_GAP_S, gap_s) if is_working(robot) else 0.0
        if before.mission == now.mission and (before.day == day or gap_s <= MOST_GAP_S):
            self.area_m2 += _growth(before.area_m2, now.area_m2, gap_s)

    def see_event(self, event: RobotEvent, day: date) -> None:
        """Count a tree that was planted; ``day`` is today, and that of the event."""
        self.turn(day)
        if event.kind == "treatment" and event.data.get("target") and event.data.get("outcome") == "done":
            self.plants += 1

    def intervened(self, day: date) -> None:
        """Count one act of a person in the work of a robot."""
        self.turn(day)
        self.interventions += 1

    def turn(self, day: date) -> None:
        """Begin anew if it is another day."""
        if day != self.day:
            self.day, self.area_m2, self.plants = day, 0.0, 0
            self.working_s = self.heard_s = 0.0
            self.interventions = 0

    def kept(self) -> dict[str, Any]:
        """Return the sums as plain values, for ``restore`` after a restart."""
        return {"day": self.day.isoformat() if self.day else None, **{name: getattr(self, name) for name in _SUMS}}

    def restore(self, kept: Mapping[str, Any], today: date) -> None:
        """Go on from sums of the same day; what is of another day, or no sum, is left out."""
        values = {name: kept.get(name) for name in _SUMS}
        is_good = all(isinstance(one, (int, float)) and math.isfinite(one) and one >= 0 for one in values.values())
        if kept.get("day") != today.isoformat() or not is_good:
            return
        self.turn(today)
        for name, value in values.items():
            setattr(self, name, value)

    def figures(self) -> DayFigures:
        """Return the sums so far."""
        return DayFigures(self.area_m2, self.plants, self.working_s, self.heard_s, self.interventions)


def is_working(robot: Robot) -> bool:
    """Say whether its mission runs: it drives by itself and treats or is on its way."""
    state = robot.state
    return (
        state is not None
        and state.mode is Mode.AUTO
        and state.order is not None
        and state.order.status is OrderStatus.RUNNING
    )


def _growth(before_m2: float, now_m2: float, gap_s: float) -> float:
    step = now_m2 - before_m2
    return step if 0 < step <= MAX_STEP_M2 * max(1.0, gap_s / MOST_GAP_S) else 0.0
