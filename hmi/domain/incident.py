"""What happened to a robot that is worth a clip: STOPs and alarms that come together make one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import datetime

from hmi.domain.picture import Moment

BEFORE_S = 60.0  # how it came to it
AFTER_S = 15.0  # what it led to
MOST_S = 45.0  # an incident that goes on is cut here, for the camera process keeps little more than a minute
MOST_CAUSES = 8  # a node that fails in pieces says no more by the ninth; what is grave is always named


@dataclass(slots=True)
class Cause:
    """One of what happened: for finding it again, in words, and whether it is worth opening a camera."""

    name: str
    text: str
    is_grave: bool


@dataclass(slots=True)
class Incident:
    """One incident at one robot; times on the console's monotonic clock, ``began_at`` aware UTC."""

    robot_id: str
    began_s: float
    began_at: datetime
    moment: Moment
    ends_s: float
    is_grave: bool = False
    named: list[Cause] = field(default_factory=list)

    @property
    def causes(self) -> list[str]:
        """What it is found by, in the order of happening."""
        return [one.name for one in self.named]

    @property
    def texts(self) -> list[str]:
        """What happened, in words, the same ones once."""
        return list(dict.fromkeys(one.text for one in self.named if one.text))

    def add(self, cause: Cause) -> None:
        """Name one more; a grave one takes the place of the last that is not, and comes in anyway."""
        for one in self.named:
            if one.name == cause.name:
                one.is_grave = one.is_grave or cause.is_grave
                return
        if len(self.named) >= MOST_CAUSES:
            if not cause.is_grave:
                return
            lesser = [one for one in self.named if not one.is_grave]
            if lesser:
                self.named.remove(lesser[-1])
        self.named.append(cause)

    @property
    def from_s(self) -> float:
        """Where its clip begins."""
        return self.began_s - BEFORE_S


class IncidentBook:
    """The incidents that are not over yet; one for each robot at most."""

    def __init__(self) -> None:
        self._open: dict[str, Incident] = {}

    def note(
        self, robot_id: str, cause: str, text: str, now_s: float, at: datetime, moment: Callable[[], Moment],
        *, is_grave: bool,
    ) -> Incident:  # fmt: skip
        """Begin an incident or add to the one that is open.

        Args:
            cause: what it is, for finding it again; the same one counts once.
            moment: where the robot is; asked when an incident begins.
            is_grave: whether it is worth opening a camera that nobody looks at.
        """
        found = self._open.get(robot_id)
        if found is None:
            found = self._open[robot_id] = Incident(robot_id, now_s, at, moment(), now_s + AFTER_S)
        found.is_grave = found.is_grave or is_grave
        found.add(Cause(cause, text, is_grave))
        found.ends_s = min(now_s + AFTER_S, found.began_s + MOST_S)
        return found

    def over(self, now_s: float) -> list[Incident]:
        """Return and forget those that are over."""
        ended = [one for one in self._open.values() if one.ends_s <= now_s]
        for one in ended:
            del self._open[one.robot_id]
        return ended

    def grave(self) -> list[str]:
        """Return the robots with a grave incident, the oldest first."""
        return [one.robot_id for one in sorted(self._open.values(), key=lambda one: one.began_s) if one.is_grave]

    def __len__(self) -> int:
        """Return how many are open."""
        return len(self._open)
