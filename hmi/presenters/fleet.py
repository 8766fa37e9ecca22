"""One robot as the fleet list and the maps show it: an entry of lane topic ``fleet``."""

from __future__ import annotations

from typing import Any

from hmi.domain.robot import Robot
from hmi.presenters.actions import why
from hmi.presenters.units import heading_deg, milliseconds
from hmi.presenters.words import FAULT_LEVELS, mode_of, mode_text

LINK_LOST_LEVEL, STOPPED_LEVEL = 2, 3


def entry(robot: Robot) -> dict[str, Any]:
    """Return the entry; ``level`` is the worst of its faults, link and stop, ``None`` when all is normal."""
    pose = robot.telemetry.pose if robot.telemetry else None
    battery = robot.telemetry.battery if robot.telemetry else None
    reason = why(robot)
    return {
        "name": robot.name,
        "family": robot.factsheet.family.value if robot.factsheet else "other",
        "mode": mode_of(robot).value,
        "text": mode_text(robot),
        "t": milliseconds(robot.link.heard_s),
        "lat": round(pose.lat_deg, 7) if pose else None,
        "lon": round(pose.lon_deg, 7) if pose else None,
        "heading_deg": heading_deg(pose.theta_rad) if pose else None,
        "level": level(robot),
        "why": reason["text"] if reason else "",
        "is_registered": robot.is_registered,
        "is_online": robot.link.is_online,
        "soc": round(battery.soc, 3) if battery else None,
        "rtt_ms": milliseconds(robot.link.rtt_s),
    }


def level(robot: Robot) -> int | None:
    """Return 1 (critical) to 4 (low), or ``None`` when there is nothing to look at."""
    levels = [FAULT_LEVELS[f.level] for f in robot.state.faults] if robot.state else []
    if robot.is_registered and not robot.link.is_online:
        levels.append(LINK_LOST_LEVEL)
    if robot.safety is not None and (robot.safety.latched or robot.safety.hardware_stop):
        levels.append(STOPPED_LEVEL)
    return min(levels, default=None)
