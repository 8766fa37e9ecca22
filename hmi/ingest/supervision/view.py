"""What a rule is shown of one robot, and what it may remember of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol

from hmi.domain.alarm.finding import Findings
from hmi.domain.robot import OrderStatus, Robot


class Mission(Protocol):
    """What the console knows of a stored mission."""

    @property
    def sha256(self) -> str:
        """Fingerprint of its document."""
        ...

    @property
    def battery_share(self) -> float | None:
        """What all of it needs, 0..1."""
        ...

    @property
    def duration_s(self) -> float | None:
        """How long all of it takes."""
        ...


class View(NamedTuple):
    """One robot at one moment.

    Args:
        now_s: the console's monotonic clock.
        mission: what is stored of the mission it has, ``None`` if that is not known.
    """

    robot: Robot
    now_s: float
    mission: Mission | None = None


UNDER_WAY = (OrderStatus.RUNNING, OrderStatus.PAUSED)


def is_under_way(robot: Robot) -> bool:
    """Say whether the robot has a mission that was begun and not ended."""
    order = robot.state.order if robot.state is not None else None
    return order is not None and order.status in UNDER_WAY


MissionOf = Callable[[str], Mission | None]


class Rule(Protocol):
    """Watches one robot; a fresh one is made for each, so that it may remember.

    ``codes`` are the types it can find.
    """

    codes: frozenset[str]

    def look(self, view: View) -> Findings | None:
        """Return what holds now; ``None`` if that cannot be told, and then what held goes on."""
        ...


MakeRules = Callable[[], Sequence[Rule]]
