"""The robot's computer: does its clock run right, was it restarted?"""

from __future__ import annotations

from collections.abc import Callable

from hmi.domain.alarm.catalogue import AlarmType
from hmi.domain.alarm.finding import NOTHING, Finding, Findings
from hmi.ingest.supervision.view import View, is_under_way

SHOWN_S = 3.0  # a restart is a moment; the condition holds long enough to be noticed once
OFF_S = 600.0  # after a longer silence, without a mission, it was switched off and on again by somebody


class Computer:
    """Wall clock against the console's, and changes of boot.

    Args:
        clock_wrong_of: the type as it is set now; its limit is in seconds.
    """

    codes = frozenset({"clock-wrong", "restarted"})

    def __init__(self, clock_wrong_of: Callable[[], AlarmType]) -> None:
        self._clock_wrong_of, self._was_wrong = clock_wrong_of, False
        self._boot: str | None = None
        self._heard_s, self._was_under_way = float("-inf"), False
        self._restarted_s = float("-inf")

    def look(self, view: View) -> Findings | None:
        """See ``Rule``."""
        link = view.robot.link
        if link.boot is None:
            return None
        if link.boot != self._boot:
            if self._boot is not None and (view.now_s - self._heard_s < OFF_S or self._was_under_way):
                self._restarted_s = view.now_s
            self._boot = link.boot
        if link.is_online:
            self._heard_s, self._was_under_way = view.now_s, is_under_way(view.robot)
        offset_s, limit = link.wall_offset_s, self._clock_wrong_of().limit
        assert limit is not None
        if self._was_wrong or (offset_s is not None and not -limit.at < offset_s < limit.at):
            off = None if offset_s is None else abs(offset_s)
            self._was_wrong = limit.is_passed(off, was_passed=self._was_wrong)
        is_new = view.now_s - self._restarted_s < SHOWN_S
        if not is_new and not self._was_wrong:
            return NOTHING
        found = []
        if is_new:
            found.append(Finding("restarted", "It was switched off or started anew.", since_s=self._restarted_s))
        if self._was_wrong and offset_s is not None:
            way = "ahead of" if offset_s > 0 else "behind"
            found.append(Finding("clock-wrong", f"{abs(offset_s):.0f} s {way} the console."))
        return tuple(found)
