"""Does the mission move on?"""

from __future__ import annotations

from collections.abc import Callable

from hmi.domain.alarm.catalogue import AlarmType
from hmi.domain.alarm.finding import NOTHING, Finding, Findings
from hmi.domain.robot import Order, RobotState
from hmi.domain.state_chart import LastTransition
from hmi.ingest.supervision.heard_work import HeardWork, running
from hmi.ingest.supervision.view import View

STEP_S = 1.0


class Progress:
    """No step along the path for a while.

    Args:
        stalled_of: the type as it is set now; its limit is in seconds.
    """

    codes = frozenset({"stalled"})

    def __init__(self, stalled_of: Callable[[], AlarmType]) -> None:
        self._stalled_of = stalled_of
        self._work = HeardWork()
        self._place: tuple[object, ...] = ()
        self._since_s = 0.0
        self._found: Findings | None = None
        self._step: LastTransition | None = None
        self._steps = 0

    @property
    def is_stalled(self) -> bool:
        """Whether it stood still for the limit."""
        return bool(self._found)

    def look(self, view: View) -> Findings | None:
        """See ``Rule``; not known before it moved, or did not for the limit."""
        state = self._work.state_of(view)
        if state is None:
            return None
        order = running(state)
        if order is None:
            self._place, self._found = (), None
            return NOTHING
        if self._work.is_news:
            self._found = self._judge(state, order)
        return self._found

    def _judge(self, state: RobotState, order: Order) -> Findings | None:
        limit, now_s = self._stalled_of().limit, self._work.time_s
        assert limit is not None
        place = (order.mission_id, order.row, order.segment, round(order.segment_s_m, 1), self._steps_of(state))
        if place != self._place:
            is_first = not self._place
            self._place, self._since_s = place, now_s
            return None if is_first else NOTHING
        if now_s - self._since_s < limit.at:
            return None if self._found is None else NOTHING
        why = f" {state.hold.text}" if state.hold is not None else ""
        return (Finding("stalled", f"Not moved on along its path for {limit.at / 60:.0f} min.{why}"),)

    def _steps_of(self, state: RobotState) -> int:
        """Count the supervisor's steps: a planter stands for minutes at a site and goes from state to state."""
        last, before = state.last_transition, self._step
        if last is not None and state.hold is None:
            # the robot's clock is mapped anew with each message: the same moment may move by milliseconds
            is_same = before is not None and (before.source, before.target) == (last.source, last.target)
            if before is None or not is_same or abs(last.at_s - before.at_s) > STEP_S:
                self._step, self._steps = last, self._steps + 1
        return self._steps
