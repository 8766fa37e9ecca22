"""One robot as the fleet list and the maps show it: an entry of lane topic ``fleet``.

The entry holds what changes slowly. When it was heard, its round trip and its place travel in binary frames.
"""

from __future__ import annotations

from typing import Any

from hmi.domain.robot import Family, Mode, OrderStatus, Robot
from hmi.presenters.help_needed import help_s, waits_for_person
from hmi.presenters.operate import Context
from hmi.presenters.sentence import sentence
from hmi.presenters.units import heading_deg, milliseconds
from hmi.presenters.words import FAULT_LEVELS, has_mission, mode_of, mode_text

LINK_LOST_LEVEL, STOPPED_LEVEL = 2, 3
_NO_CONTEXT = Context()


def entry(robot: Robot, context: Context = _NO_CONTEXT) -> dict[str, Any]:
    """Return the whole entry, place and times included, as REST shows it."""
    pose = robot.telemetry.pose if robot.telemetry else None
    return {
        **slow(robot, context),
        "t": milliseconds(robot.link.heard_s),
        "rtt_ms": milliseconds(robot.link.rtt_s),
        "lat": round(pose.lat_deg, 7) if pose else None,
        "lon": round(pose.lon_deg, 7) if pose else None,
        "heading_deg": heading_deg(pose.theta_rad) if pose else None,
    }


def slow(robot: Robot, context: Context = _NO_CONTEXT) -> dict[str, Any]:
    """Return what changes slowly; ``level`` is the worst of its faults, link and stop, ``None`` when all is normal."""
    battery = robot.telemetry.battery if robot.telemetry else None
    gnss = robot.telemetry.gnss if robot.telemetry else None
    reason = sentence(robot) or {}
    mission = _mission(robot, context)
    return {
        "name": robot.name,
        "family": robot.factsheet.family.value if robot.factsheet else "other",
        "mode": mode_of(robot).value,
        "text": mode_text(robot),
        "task": task(robot),
        "field": mission["field"] if mission else "",
        "mission": mission,
        "level": level(robot),
        "fault": _worst_fault(robot),
        "why": reason.get("text", ""),
        "code": reason.get("code", ""),
        "clears": reason.get("clears", ""),
        "who": reason.get("who", ""),
        "since": reason.get("since"),
        "takes_s": reason.get("takes_s"),
        "waits": waits_for_person(robot),
        "help_s": help_s(robot),
        "fix": gnss.fix if gnss else None,
        "accuracy_m": _centimetres(gnss.accuracy_m) if gnss else None,
        "is_registered": robot.is_registered,
        "is_online": robot.link.is_online,
        "has_place": robot.telemetry is not None,
        "soc": round(battery.soc, 2) if battery else None,
        "charging": bool(battery and battery.is_charging),
    }


def level(robot: Robot) -> int | None:
    """Return 1 (critical) to 4 (low), or ``None`` when there is nothing to look at."""
    levels = [FAULT_LEVELS[f.level] for f in robot.state.faults] if robot.state else []
    if robot.is_registered and not robot.link.is_online:
        levels.append(LINK_LOST_LEVEL)
    if robot.safety is not None and (robot.safety.latched or robot.safety.hardware_stop):
        levels.append(STOPPED_LEVEL)
    return min(levels, default=None)


def _worst_fault(robot: Robot) -> str:
    """Return what its worst fault says, for screens to which the alarms do not come."""
    faults = robot.state.faults if robot.state else ()
    return min(faults, key=lambda one: FAULT_LEVELS[one.level]).text if faults else ""


def task(robot: Robot) -> str:
    """Return in one or two words what it does now: ``Row 12/60``, ``Transit``, ``Charging``."""
    if robot.state is None:
        return ""
    battery = robot.telemetry.battery if robot.telemetry else None
    order, mode = robot.state.order, mode_of(robot)
    if mode is Mode.AUTO and order is not None and order.status is OrderStatus.RUNNING:
        return _work(robot)
    if battery is not None and battery.is_charging:
        return "Charging"
    if mode is Mode.AUTO and robot.state.path:
        return robot.state.path[-1]
    if mode is Mode.IDLE and not has_mission(robot, OrderStatus.LOADED):
        return "Docked" if "Docked" in robot.state.path else mode_text(robot)
    return mode_text(robot)


def _work(robot: Robot) -> str:
    assert robot.state is not None
    order, path = robot.state.order, robot.state.path
    family = robot.factsheet.family if robot.factsheet else Family.OTHER
    is_between = any(word.lower().startswith(("transit", "drive to", "turn")) for word in path)
    if order is not None and order.row > 0 and not is_between and family is not Family.UAV:
        return f"Row {order.row}/{order.rows}"
    return path[-1] if path else "Running"


def _mission(robot: Robot, context: Context) -> dict[str, Any] | None:
    order = robot.state.order if robot.state is not None else None
    if order is None or order.status is OrderStatus.NONE:
        return None
    title = context.title_of(order.mission_id)
    return {
        "id": order.mission_id,
        "name": title.name if title else order.mission_id,
        "field": title.field if title else "",
        "status": order.status.value,
        "row": order.row,
        "rows": order.rows,
        "segment": order.segment,
        "sha256": order.sha256[:12],
        "share": round(min(1.0, order.area_done_m2 / order.area_m2), 2) if order.area_m2 > 0 else 0.0,
        "remaining_s": None if order.remaining_s is None else round(order.remaining_s / 60) * 60,
    }


def _centimetres(accuracy_m: float) -> float:
    """Coarse on purpose: noise of millimetres must not make every entry a changed one."""
    return round(accuracy_m, 2) if accuracy_m < 1 else float(round(accuracy_m))
