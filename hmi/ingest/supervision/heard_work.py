"""A robot in its mission, and the time in which it was heard: what passes in silence proves nothing."""

from __future__ import annotations

from hmi.domain.freshness import STALE_S
from hmi.domain.robot import Mode, Order, OrderStatus, RobotState
from hmi.ingest.supervision.view import View


class HeardWork:
    """Follows the state of one robot; ``time_s`` goes on by what lies between two states that follow each other."""

    def __init__(self) -> None:
        self._state: RobotState | None = None
        self.time_s = 0.0
        self.is_news = False

    def state_of(self, view: View) -> RobotState | None:
        """Take in the newest state and return it; ``None`` if it is not heard or tells of the past."""
        state, before = view.robot.state, self._state
        if state is None or not view.robot.link.is_online or view.now_s - state.stamp.source_s >= STALE_S:
            return None
        self._state, self.is_news = state, state is not before
        if before is not None and 0 < (gap_s := state.stamp.source_s - before.stamp.source_s) < STALE_S:
            self.time_s += gap_s
        return state


def running(state: RobotState) -> Order | None:
    """Return the mission that runs by itself now."""
    order = state.order
    return order if order is not None and state.mode is Mode.AUTO and order.status is OrderStatus.RUNNING else None
