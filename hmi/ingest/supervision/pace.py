"""Is the mission as fast as it was planned?"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

from hmi.domain.alarm.finding import NOTHING, Finding, Findings
from hmi.domain.robot import Order
from hmi.ingest.supervision.heard_work import HeardWork, running
from hmi.ingest.supervision.view import Mission, View

SAMPLE_S, WINDOW_S = 60.0, 900.0
SLOW_SHARE = 0.5  # half as fast as planned over a quarter of an hour is no turn and no short wait


class Pace:
    """Much less of the field than planned.

    Args:
        is_stalled: whether it does not move at all, which is told apart.
    """

    codes = frozenset({"behind-plan"})

    def __init__(self, is_stalled: Callable[[], bool]) -> None:
        self._is_stalled = is_stalled
        self._work = HeardWork()
        self._shares: deque[tuple[float, float]] = deque()
        self._found: Findings | None = None

    def look(self, view: View) -> Findings | None:
        """See ``Rule``; not known before a quarter of an hour was seen."""
        state = self._work.state_of(view)
        if state is None:
            return None
        order = running(state)
        if order is None:
            self._shares.clear()
            self._found = None
            return NOTHING
        if self._work.is_news:
            self._found = NOTHING if self._is_stalled() else self._judge(order, view.mission)
        return self._found

    def _judge(self, order: Order, mission: Mission | None) -> Findings | None:
        if order.area_m2 <= 0 or mission is None or not mission.duration_s:
            return NOTHING
        share, shares, now_s = order.area_done_m2 / order.area_m2, self._shares, self._work.time_s
        if not shares or now_s - shares[-1][0] >= SAMPLE_S:
            shares.append((now_s, share))
        while len(shares) > 1 and now_s - shares[1][0] >= WINDOW_S:
            shares.popleft()
        span_s = now_s - shares[0][0]
        if span_s < WINDOW_S:
            return None
        planned, done = span_s / mission.duration_s, share - shares[0][1]
        if done >= SLOW_SHARE * planned or share + planned > 1:
            return NOTHING
        text = f"{100 * done:.1f} % of the field in the last {span_s / 60:.0f} min; planned {100 * planned:.1f} %."
        return (Finding("behind-plan", text),)
