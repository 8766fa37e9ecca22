"""What the gateway hears of each robot, and the heartbeat it tells the browsers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hmi.domain.stop import SafetyReport
from hmi.domain.stop_book import ReportOrder

RETURN_S = 1.0  # silence after which the next sign of life is a return; five heartbeats
FRESH_SPEED_S = 1.0  # an older speed proves nothing about how fast it is now


@dataclass(slots=True)
class Heard:
    """The newest of one robot; times on the monotonic clock, ``None`` if never."""

    heard_s: float | None = None
    via: str = "mqtt"
    report: SafetyReport | None = None
    report_s: float | None = None
    latched_since_s: float | None = None
    rtt_s: float | None = None
    rtt_at_s: float | None = None


class RobotWatch:
    """Everything heard, by robot id."""

    def __init__(self) -> None:
        self._heard: dict[str, Heard] = {}
        self._order = ReportOrder()  # as of the presses: no report is fresh here that does not count there

    def of(self, robot_id: str) -> Heard:
        """Return what is known of a robot, empty if nothing."""
        return self._heard.get(robot_id) or Heard()

    def known(self) -> list[str]:
        """Return every robot heard since the start."""
        return [robot_id for robot_id, heard in self._heard.items() if heard.heard_s is not None]

    def lately(self, now_s: float, within_s: float) -> list[str]:
        """Return every robot heard within ``within_s``."""
        return [
            r for r, heard in self._heard.items() if heard.heard_s is not None and now_s - heard.heard_s <= within_s
        ]

    def heard(self, robot_id: str, now_s: float, via: str = "mqtt") -> bool:
        """Note a sign of life; return whether the robot was away before it."""
        heard = self._heard.setdefault(robot_id, Heard())
        was_away = heard.heard_s is None or now_s - heard.heard_s > RETURN_S
        heard.heard_s, heard.via = now_s, via
        return was_away

    def reported(self, robot_id: str, report: SafetyReport, now_s: float) -> None:
        """Note the newest safety report."""
        heard = self._heard.setdefault(robot_id, Heard())
        if not self._order.is_new(robot_id, report, now_s):
            return
        if not report.latched:
            heard.latched_since_s = None
        elif heard.latched_since_s is None:
            heard.latched_since_s = now_s
        heard.report, heard.report_s = report, now_s

    def measured(self, robot_id: str, rtt_s: float, now_s: float) -> None:
        """Note the round trip from here to the robot."""
        heard = self._heard.setdefault(robot_id, Heard())
        heard.rtt_s, heard.rtt_at_s = rtt_s, now_s

    def speed_mps(self, robot_id: str, now_s: float) -> float | None:
        """Return its speed if that is fresh, else ``None``."""
        heard = self.of(robot_id)
        if heard.report is None or heard.report_s is None or now_s - heard.report_s > FRESH_SPEED_S:
            return None
        return heard.report.speed_mps

    def line(self, robot_id: str, name: str, now_s: float) -> dict[str, Any]:
        """Return one robot of the ``hb`` frame."""
        heard = self.of(robot_id)
        report = heard.report
        return {
            "name": name,
            "heard_ms": _ms(now_s, heard.heard_s),
            "via": heard.via,
            "rtt_ms": None if heard.rtt_s is None else round(heard.rtt_s * 1000),
            "latched": report.latched if report else None,
            "latched_ms": _ms(now_s, heard.latched_since_s),
            "standstill": report.is_standing if report else None,
            "speed_mps": report.speed_mps if report else None,
            "hardware_stop": report.hardware_stop if report else None,
            "safety_ms": _ms(now_s, heard.report_s),
        }


def _ms(now_s: float, then_s: float | None) -> int | None:
    return None if then_s is None else max(0, round((now_s - then_s) * 1000))
