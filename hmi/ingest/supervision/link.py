"""Is it heard, and are its values as new as its voice?"""

from __future__ import annotations

from hmi.domain.alarm.finding import NOTHING, Finding, Findings
from hmi.domain.freshness import LOST_S, STALE_S
from hmi.ingest.supervision.view import View, is_under_way


class Link:
    """Data link and age of the values.

    A robot that was never heard since the console started has lost nothing: it may be switched off. One that was
    shut down in order, without a mission under way, is not lost either.
    """

    codes = frozenset({"link-lost", "values-old"})

    def look(self, view: View) -> Findings | None:
        """See ``Rule``."""
        robot = view.robot
        heard_s = robot.link.heard_s
        if heard_s is None:
            return None
        if not robot.link.is_online:
            if robot.link.said_goodbye and not is_under_way(robot):
                return NOTHING
            return (Finding("link-lost", "Nothing heard for 3.5 s or more.", since_s=heard_s + LOST_S),)
        telemetry = robot.telemetry
        if telemetry is None or view.now_s - telemetry.pose.stamp.source_s < STALE_S:
            return NOTHING
        return (Finding("values-old", "It is heard, but its position is older than 2 s."),)
