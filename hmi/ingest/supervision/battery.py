"""Does the battery last: for anything at all, and for what is left of the mission?"""

from __future__ import annotations

from hmi.domain.alarm.finding import NOTHING, Finding, Findings
from hmi.domain.alarm.steady import Limit
from hmi.domain.robot import Battery as Charge
from hmi.ingest.supervision.view import UNDER_WAY, View

SURELY_ENOUGH = 0.3
ACT_WITHIN_S = 3600.0  # an alarm is for now: what is hours away stands on the mission card
RESERVE = 0.1  # what should be left at the end, to get home; the start check asks for the same
LOW, VERY_LOW, EMPTY = Limit(0.2, 0.02, True), Limit(0.1, 0.02, True), Limit(0.005, 0.01, True)
_LEVELS = (("battery-empty", EMPTY), ("battery-very-low", VERY_LOW), ("battery-low", LOW))


class Battery:
    """Charge against limits, and against what the rest of the mission needs; silent while it charges."""

    codes = frozenset({"battery-empty", "battery-very-low", "battery-low", "battery-short"})

    def __init__(self) -> None:
        self._passed: set[str] = set()

    def look(self, view: View) -> Findings | None:
        """See ``Rule``."""
        telemetry = view.robot.telemetry
        battery = telemetry.battery if telemetry is not None else None
        if battery is None:
            return None
        if battery.is_charging:
            self._passed.clear()
            return NOTHING
        soc = battery.soc
        if soc > 0.5 and not self._passed and view.mission is None:
            return NOTHING
        level = self._level(soc) if soc < SURELY_ENOUGH or self._passed else None
        short = self._short(view, battery)
        if level is None:
            return NOTHING if short is None else (short,)
        found = Finding(level, f"{100 * soc:.0f} % left.")
        return (found,) if short is None else (found, short)

    def _level(self, soc: float) -> str | None:
        for code, limit in _LEVELS:
            if limit.is_passed(soc, was_passed=code in self._passed):
                self._passed = {code}
                return code
        self._passed.clear()
        return None

    def _short(self, view: View, battery: Charge) -> Finding | None:
        soc = battery.soc
        order = view.robot.state.order if view.robot.state is not None else None
        needed = view.mission.battery_share if view.mission is not None else None
        if order is None or needed is None or order.status not in UNDER_WAY or order.area_m2 <= 0:
            return None
        if soc - needed >= RESERVE:
            return None
        rest = needed * max(0.0, 1 - order.area_done_m2 / order.area_m2)
        if soc - rest >= RESERVE:
            return None
        left_s = _to_reserve_s(battery)
        if left_s is not None and left_s > ACT_WITHIN_S:
            return None
        text = f"{100 * soc:.0f} % now; the rest needs {100 * rest:.0f} % and {100 * RESERVE:.0f} % stay in reserve."
        return Finding("battery-short", text)


def _to_reserve_s(battery: Charge) -> float | None:
    """Return how long it lasts at the present load until the reserve; ``None`` if the robot does not say."""
    if battery.remaining_s is None or battery.soc <= 0:
        return None
    return battery.remaining_s * max(0.0, battery.soc - RESERVE) / battery.soc
