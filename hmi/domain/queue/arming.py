"""Arming: one slide lets exactly this queue of these robots start missions by itself, until a time.

Everything ends it: the time, a change of the queue, a stop, another person in control, a start that failed, a
console that restarts or was held up. Nothing but another slide begins it again. Pure; two clocks are handed in
because neither alone can be trusted: the wall clock jumps, and the monotonic one may stand while a machine sleeps.
"""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime, timedelta

MIN_S, MAX_S = 300, 12 * 3600  # nobody remembers in the evening what was armed the day before
HELD_UP_S = 10.0  # the runner looks each second; after a hole like this nobody knows what happened meanwhile


@dataclass(frozen=True, slots=True)
class Arming:
    """One robot's queue, armed.

    Args:
        id: shared by the robots of one slide.
        revision: of the queue that was shown; another one is another queue.
        by, user_id: the person who slid.
        until, until_s: when it ends, by wall clock and by monotonic clock.
    """

    id: str
    robot_id: str
    revision: int
    by: str
    user_id: str
    armed_at: datetime
    until: datetime
    until_s: float

    def is_over(self, now: datetime, now_s: float) -> bool:
        """Say whether its time has run out on either clock, or the wall clock went back before it began."""
        return now >= self.until or now_s >= self.until_s or now < self.armed_at - timedelta(minutes=1)


class ArmingBook:
    """Who armed which queue. All of it is forgotten when the console ends: nothing is armed after a restart."""

    def __init__(self) -> None:
        self._live: dict[str, Arming] = {}
        self._ended: dict[str, tuple[str, datetime]] = {}
        self._looked: tuple[datetime, float] | None = None

    def of(self, robot_id: str) -> Arming | None:
        """Return the arming in force."""
        return self._live.get(robot_id)

    def live(self) -> tuple[Arming, ...]:
        """Return every arming in force."""
        return tuple(self._live.values())

    def ended(self, robot_id: str) -> tuple[str, datetime] | None:
        """Return why the last one ended and when; ``None`` while armed or never armed."""
        return self._ended.get(robot_id)

    def put(self, arming: Arming) -> None:
        """Arm one robot's queue; replaces what was armed."""
        self._live[arming.robot_id] = arming
        self._ended.pop(arming.robot_id, None)

    def end(self, robot_id: str, why: str, now: datetime) -> Arming | None:
        """End one; return it, ``None`` if the robot was not armed. The first reason stays."""
        arming = self._live.pop(robot_id, None)
        if arming is not None:
            self._ended[robot_id] = (why, now)
        return arming

    def note_ended(self, robot_id: str, why: str, at: datetime) -> None:
        """Remember why the queue of a robot is not armed, from a run of the console before this one."""
        self._ended.setdefault(robot_id, (why, at))

    def due(self, now: datetime, now_s: float) -> tuple[Arming, ...]:
        """Return those whose time has run out; the caller ends them."""
        return tuple(one for one in self._live.values() if one.is_over(now, now_s))

    def was_held_up(self, now: datetime, now_s: float) -> bool:
        """Say whether there was a hole since the last look, on either clock, or the two went apart."""
        before, self._looked = self._looked, (now, now_s)
        if before is None:
            return False
        wall_s, mono_s = (now - before[0]).total_seconds(), now_s - before[1]
        return not (mono_s <= HELD_UP_S and -HELD_UP_S <= wall_s <= HELD_UP_S)
