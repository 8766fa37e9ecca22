"""What a guided check may look at, and what one look finds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from hmi.domain.robot import Robot, Telemetry
from hmi.domain.sensors.condition import StationCondition


@dataclass(frozen=True, slots=True)
class Scene:
    """What the checks may look at.

    Args:
        robot: the robot the alarm is of, ``None`` for the console.
        others: every other registered robot.
        parts: states of the console's processes, empty where no keeper runs.
        disk: bytes free and their share, ``None`` unknown.
        writers: what is wrong with keeping records, by name.
        station: the field station the alarm is of, ``None`` for everything else.
    """

    now_s: float
    robot: Robot | None
    others: Sequence[Robot] = ()
    is_broker_up: bool = True
    parts: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    disk: tuple[int, float] | None = None
    is_database_up: bool = True
    writers: Mapping[str, str] = field(default_factory=dict)
    station: StationCondition | None = None

    @property
    def telemetry(self) -> Telemetry | None:
        """Fast values of the robot."""
        return None if self.robot is None else self.robot.telemetry


class Look(NamedTuple):
    """One check: what was asked, what was found, whether that is good (``None`` cannot tell), what a bad one means."""

    text: str
    found: str
    is_ok: bool | None
    means: str = ""


def unknown(text: str) -> Look:
    """Return the look of a check that cannot tell."""
    return Look(text, "Not known.", None)
