"""All STOP presses that are not reset, as the gateway and the console's second path each keep them.

Pure: the caller gives the time, sends what ``due`` names and tells what came back.
Every method that can change something returns the attempts that changed, newest state.
"""

from __future__ import annotations

import contextlib
from collections import OrderedDict, deque
from collections.abc import Callable, Container, Iterable
from dataclasses import replace
from datetime import datetime
from typing import Any

from hmi.domain.freshness import LOST_S
from hmi.domain.stop import SafetyReport, StopAnswer, StopAttempt, StopState, StopTarget

MAX_OPEN_PER_ROBOT = 64  # as many as a robot lists; beyond, the oldest press is covered by 64 newer ones
MAX_STRANGERS = 64  # robots that nobody registered or heard; more than that is not a farm
STRANGER_S = 600.0  # a robot nobody ever heard of cannot be waited for without end: its alarm could never end
BOOTS_REMEMBERED = 16  # earlier lives of a robot of which something may still arrive
MAX_FINISHED = 256  # so that somebody who asks late still reads "reset"

Key = tuple[str, str]


class ReportOrder:
    """Tells reports that arrive late, by whichever path, from new ones.

    Where nothing newer came for ``LOST_S`` the newest was wrong: forged, of a clock that jumped, or of a robot that
    names each of its boots alike. Refusing on for ever would leave STOP without a word of that robot.
    """

    def __init__(self) -> None:
        self._newest: dict[str, tuple[str, float]] = {}
        self._taken_s: dict[str, float] = {}
        self._gone: dict[str, deque[str]] = {}

    def is_new(self, robot_id: str, report: SafetyReport, now_s: float) -> bool:
        """Say whether ``report`` is as new as any before it, and remember it if so."""
        boot, at_s = self._newest.get(robot_id, ("", float("-inf")))
        gone = self._gone.setdefault(robot_id, deque(maxlen=BOOTS_REMEMBERED))
        is_older = report.at_s < at_s if report.boot == boot else report.boot in gone
        if is_older and now_s - self._taken_s[robot_id] < LOST_S:
            return False
        if report.boot != boot:
            with contextlib.suppress(ValueError):
                gone.remove(report.boot)
            gone.extend([boot] if boot else ())
        self._newest[robot_id], self._taken_s[robot_id] = (report.boot, report.at_s), now_s
        return True


class StopBook:
    """The presses, keyed by stop id and robot."""

    def __init__(self) -> None:
        self._open: dict[Key, StopAttempt] = {}
        self._by_robot: dict[str, list[Key]] = {}
        self._finished: OrderedDict[Key, StopAttempt] = OrderedDict()
        self._order = ReportOrder()

    def __len__(self) -> int:
        return len(self._open)

    def press(
        self,
        stop_id: str,
        target: StopTarget,
        by: str,
        device: str,
        *,
        now_s: float,
        utc: datetime,
        speed_mps: float | None = None,
        user_id: str | None = None,
    ) -> StopAttempt:
        """Note a press, or one more copy of it; what is open afterwards is due at once."""
        key = (stop_id, target.id)
        known = self._open.get(key) or self._finished.get(key)
        if known is not None and known.state is not StopState.WITHDRAWN:
            return self._keep(key, known.at(now_s).pressed_again(now_s))
        attempt = StopAttempt.press(
            stop_id, target, by, device, now_s=now_s, utc=utc, speed_mps=speed_mps, user_id=user_id
        )
        self._add(attempt)
        return attempt

    def restore(self, attempts: Iterable[StopAttempt]) -> None:
        """Take over presses from before a restart."""
        for attempt in attempts:
            self._add(attempt)

    def has(self, stop_id: str, robot_id: str) -> bool:
        """Say whether this press at this robot is known, open or finished."""
        return (stop_id, robot_id) in self._open or (stop_id, robot_id) in self._finished

    def attempts(self) -> list[StopAttempt]:
        """Return every press that is not reset, oldest first."""
        return list(self._open.values())

    def attempts_at(self, robot_id: str) -> list[StopAttempt]:
        """Return the open presses at one robot, oldest first."""
        return [self._open[key] for key in self._by_robot.get(robot_id, ())]

    def steps(self, now_s: float, stop_id: str | None = None) -> list[dict[str, Any]]:
        """Return the step of every open press, or of every robot of one press, finished or not."""
        if stop_id is None:
            return [attempt.step(now_s) for attempt in self._open.values()]
        both = [*self._open.values(), *self._finished.values()]
        return [attempt.step(now_s) for attempt in both if attempt.stop_id == stop_id]

    def due(self, now_s: float) -> list[StopAttempt]:
        """Return what must be sent now, newest press first."""
        return [attempt for attempt in reversed(self._open.values()) if attempt.is_due(now_s)]

    def next_due_s(self) -> float | None:
        """Return when ``due`` or ``tick`` has something to do next, ``None`` if never by time alone."""
        times = [a.next_send_s for a in self._open.values()]
        times += [change for a in self._open.values() if (change := a.next_change_s) is not None]
        return min(times, default=None)

    def tick(self, now_s: float) -> list[StopAttempt]:
        """Let limits run out."""
        return self._each(list(self._open), lambda attempt: attempt.at(now_s))

    def sent(self, attempt: StopAttempt, now_s: float, *, by_mqtt: bool) -> None:
        """Note that copies of ``attempt`` went out."""
        key = (attempt.stop_id, attempt.robot_id)
        if key in self._open:
            self._keep(key, self._open[key].sent(now_s, by_mqtt=by_mqtt))

    def carried_by_http(self, stop_id: str, robot_id: str, sent_s: float) -> None:
        """Note that the robot's HTTP endpoint took the copy that left at ``sent_s``."""
        key = (stop_id, robot_id)
        if key in self._open:
            self._keep(key, self._open[key].carried_by_http(sent_s))

    def answered(self, stop_id: str, robot_id: str, answer: StopAnswer, now_s: float) -> list[StopAttempt]:
        """Apply the robot's answer to one press."""
        return self._each([(stop_id, robot_id)], lambda attempt: attempt.answered(now_s, answer))

    def reported(self, robot_id: str, report: SafetyReport, now_s: float) -> list[StopAttempt]:
        """Apply a safety report; one that is older than another already seen changes nothing."""
        if not self._order.is_new(robot_id, report, now_s):
            return []
        return self._each(self._keys_at(robot_id), lambda attempt: attempt.reported(now_s, report))

    def returned(self, robot_id: str, now_s: float) -> None:
        """The robot is back: what it has not confirmed is due at once."""
        self._each(self._keys_at(robot_id), lambda attempt: attempt.returned(now_s))

    def path_returned(self, now_s: float) -> None:
        """A path to all robots is back: what is not confirmed is due at once."""
        self._each(list(self._open), lambda attempt: attempt.returned(now_s))

    def forget_strangers(self, known: Container[str], now_s: float) -> list[StopAttempt]:
        """End old presses at mistyped ids; never those at a robot that was registered or heard, however long ago."""
        changed: list[StopAttempt] = []
        for robot_id in list(self._by_robot):
            attempts = self.attempts_at(robot_id)
            if not any(attempt.target.is_stranger for attempt in attempts):
                continue
            if robot_id in known:
                changed += self._each(self._keys_at(robot_id), _no_stranger)
            elif all(a.target.is_stranger and now_s - a.pressed_s > STRANGER_S for a in attempts):
                changed += self._each(self._keys_at(robot_id), _withdrawn)
        return changed

    def admits(self, robot_id: str, known: Container[str]) -> bool:
        """Say whether a press at this robot can be kept: always for a ``known`` one, for strangers up to a limit."""
        if robot_id in known or self._by_robot.get(robot_id):
            return True
        return sum(1 for r, keys in self._by_robot.items() if keys and r not in known) < MAX_STRANGERS

    def _keys_at(self, robot_id: str) -> list[Key]:
        return list(self._by_robot.get(robot_id, ()))

    def _each(self, keys: list[Key], change: Callable[[StopAttempt], StopAttempt]) -> list[StopAttempt]:
        changed = []
        for key in keys:
            before = self._open.get(key)
            if before is None:
                continue
            after = change(before)
            if after is not before and after != before:
                self._keep(key, after)
                changed.append(after)
        return changed

    def _add(self, attempt: StopAttempt) -> None:
        keys = self._by_robot.setdefault(attempt.robot_id, [])
        if len(keys) >= MAX_OPEN_PER_ROBOT:
            self._open.pop(keys.pop(0), None)
        key = (attempt.stop_id, attempt.robot_id)
        if key not in self._open:
            keys.append(key)
        self._open[key] = attempt

    def _keep(self, key: Key, attempt: StopAttempt) -> StopAttempt:
        if attempt.is_open:
            self._open[key] = attempt
            return attempt
        if self._open.pop(key, None) is not None:
            keys = self._by_robot[attempt.robot_id]
            keys.remove(key)
            if not keys:
                del self._by_robot[attempt.robot_id]
        self._finished[key] = attempt
        while len(self._finished) > MAX_FINISHED:
            self._finished.popitem(last=False)
        return attempt


def _no_stranger(attempt: StopAttempt) -> StopAttempt:
    return replace(attempt, target=replace(attempt.target, is_stranger=False))


def _withdrawn(attempt: StopAttempt) -> StopAttempt:
    return replace(attempt, state=StopState.WITHDRAWN, text="Nobody registered this robot and nobody ever heard it.")
