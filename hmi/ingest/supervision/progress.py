"""Does the mission move on, and as fast as it was planned?"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

from hmi.domain.alarm.catalogue import AlarmType
from hmi.domain.alarm.finding import NOTHING, Finding, Findings
from hmi.domain.robot import Mode, Order, OrderStatus, RobotState
from hmi.domain.state_chart import LastTransition
from hmi.ingest.supervision.view import View

SAMPLE_S, WINDOW_S = 60.0, 900.0
STEP_S = 1.0
SLOW_SHARE = 0.5  # half as fast as planned over a quarter of an hour is no turn and no short wait


class Progress:
    """No step along the path for a while, or much less of the field than planned.

    Args:
        stalled_of: the type as it is set now; its limit is in seconds.
    """

    codes = frozenset({"stalled", "behind-plan"})

    def __init__(self, stalled_of: Callable[[], AlarmType]) -> None:
        self._stalled_of = stalled_of
        self._place: tuple[object, ...] = ()
        self._since_s = 0.0
        self._shares: deque[tuple[float, float]] = deque()
        self._state: RobotState | None = None
        self._found: Findings = NOTHING
        self._step: LastTransition | None = None
        self._steps = 0

    @property
    def _limit_s(self) -> float:
        limit = self._stalled_of().limit
        assert limit is not None
        return limit.at

    def look(self, view: View) -> Findings | None:
        """See ``Rule``."""
        state = view.robot.state
        if state is None:
            return None
        order = state.order
        if order is None or state.mode is not Mode.AUTO or order.status is not OrderStatus.RUNNING:
            self._place, self._state = (), None
            self._shares.clear()
            return NOTHING
        if state is self._state and view.now_s - self._since_s < self._limit_s:
            return self._found  # nothing new was said
        self._state = state
        self._found = self._judge(view, state, order)
        return self._found

    def _judge(self, view: View, state: RobotState, order: Order) -> Findings:
        place = (order.mission_id, order.row, order.segment, round(order.segment_s_m, 1), self._steps_of(state))
        if place != self._place:
            self._place, self._since_s = place, view.now_s
        if view.now_s - self._since_s < self._limit_s:
            return self._pace(view, order)
        why = f" {state.hold.text}" if state.hold is not None else ""
        return (Finding("stalled", f"Not moved on along its path for {self._limit_s / 60:.0f} min.{why}"),)

    def _steps_of(self, state: RobotState) -> int:
        """Count the supervisor's steps: a planter stands for minutes at a site and goes from state to state."""
        last, before = state.last_transition, self._step
        if last is not None and state.hold is None:
            # the robot's clock is mapped anew with each message: the same moment may move by milliseconds
            is_same = before is not None and (before.source, before.target) == (last.source, last.target)
            if before is None or not is_same or abs(last.at_s - before.at_s) > STEP_S:
                self._step, self._steps = last, self._steps + 1
        return self._steps

    def _pace(self, view: View, order: Order) -> Findings:
        if order.area_m2 <= 0 or view.mission is None or not view.mission.duration_s:
            return NOTHING
        share, shares = order.area_done_m2 / order.area_m2, self._shares
        if not shares or view.now_s - shares[-1][0] >= SAMPLE_S:
            shares.append((view.now_s, share))
        while len(shares) > 1 and view.now_s - shares[1][0] >= WINDOW_S:
            shares.popleft()
        span_s = view.now_s - shares[0][0]
        planned, done = span_s / view.mission.duration_s, share - shares[0][1]
        if span_s < WINDOW_S or done >= SLOW_SHARE * planned or share + planned > 1:
            return NOTHING
        text = f"{100 * done:.1f} % of the field in the last {span_s / 60:.0f} min; planned {100 * planned:.1f} %."
        return (Finding("behind-plan", text),)
