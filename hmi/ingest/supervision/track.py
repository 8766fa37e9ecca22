"""Is it on its line?"""

from __future__ import annotations

from collections.abc import Callable

from hmi.domain.alarm.catalogue import AlarmType
from hmi.domain.alarm.finding import NOTHING, Finding, Findings
from hmi.domain.alarm.steady import Limit
from hmi.domain.robot import Family, Mode, OrderStatus
from hmi.ingest.supervision.view import View


class Track:
    """Cross-track error while a mission runs. A drone flies in the wind and has a limit of its own.

    Args:
        kind_of: the type as it is set now.
    """

    codes = frozenset({"off-track"})

    def __init__(self, kind_of: Callable[[], AlarmType]) -> None:
        self._kind_of, self._flying = kind_of, Limit(3.0, 1.0)
        self._was_passed = False

    def look(self, view: View) -> Findings | None:
        """See ``Rule``; an error that is not known leaves what was."""
        robot = view.robot
        state, telemetry = robot.state, robot.telemetry
        if state is None or telemetry is None:
            return None
        order = state.order
        if state.mode is not Mode.AUTO or order is None or order.status is not OrderStatus.RUNNING:
            self._was_passed = False
            return NOTHING
        error_m = telemetry.cross_track_m
        is_flying = robot.factsheet is not None and robot.factsheet.family is Family.UAV
        limit = self._kind_of().limit
        assert limit is not None
        limit = self._flying if is_flying else limit
        was_passed = self._was_passed
        if not was_passed and error_m is not None and -limit.at < error_m < limit.at:
            return NOTHING
        self._was_passed = limit.is_passed(None if error_m is None else abs(error_m), was_passed=was_passed)
        if not self._was_passed:
            return NOTHING
        if error_m is None:
            return None
        side = "left" if error_m > 0 else "right"
        return (Finding("off-track", f"{abs(error_m):.2f} m to the {side}, limit {limit.at:.2f} m."),)
