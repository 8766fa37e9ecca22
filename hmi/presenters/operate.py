"""One robot as the operate screen shows it: the groups of lane topic ``robot/{id}``, see docs/protocols/lane.md."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

from hmi.domain.family import Family
from hmi.domain.keep_out import keep_out_m
from hmi.domain.robot import Mode, Order, Robot
from hmi.presenters.actions import actions, why
from hmi.presenters.start_checks import MissionFacts, start_checks
from hmi.presenters.tiles import tiles
from hmi.presenters.units import heading_deg, milliseconds
from hmi.presenters.words import FAULT_LEVELS, kind_label, mode_of, mode_text, tool_label

Groups = dict[str, Any]
IsSupervised = Callable[[Robot, Order], bool]
"""Whether somebody has to look on once a robot carries out what it says it has; answers from memory."""


class MissionTitle(NamedTuple):
    """What people call a mission and its field; the robot knows only the id."""

    name: str
    field: str


class Context(NamedTuple):
    """What is known of a robot besides what it says itself; ``keep_out_m`` as an admin set it."""

    contact_name: str = ""
    contact_phone: str = ""
    title_of: Callable[[str], MissionTitle | None] = lambda _mission_id: None
    facts_of: Callable[[str], MissionFacts | None] = lambda _mission_id: None
    is_supervised: IsSupervised = lambda _robot, _order: True
    keep_out_m: float | None = None


def present(robot: Robot, context: Context, groups: Iterable[str] | None = None) -> Groups:
    """Return the named groups, or all of them."""
    wanted = PRESENTERS if groups is None else groups
    return {name: PRESENTERS[name](robot, context) for name in wanted}


def _id(robot: Robot, _context: Context) -> Any:
    sheet = robot.factsheet
    return {
        "id": robot.id,
        "name": robot.name,
        "family": sheet.family.value if sheet else "other",
        "kind_label": kind_label(robot),
        "model": sheet.model if sheet else "",
        "farm": robot.farm_id,
        "is_registered": robot.is_registered,
    }


def _link(robot: Robot, _context: Context) -> Any:
    link = robot.link
    return {
        "t": milliseconds(link.heard_s),
        "is_online": link.is_online,
        "rtt_ms": milliseconds(link.rtt_s),
        "rtt_max_ms": milliseconds(link.rtt_max_s),
        "broker": "up" if link.is_broker_up else "down",
        "is_off": link.said_goodbye and not link.is_online,
    }


def _mode(robot: Robot, _context: Context) -> Any:
    times = [part.stamp.source_s for part in (robot.state, robot.safety) if part is not None]
    if not times:
        return None
    return {"t": milliseconds(max(times)), "mode": mode_of(robot).value, "text": mode_text(robot)}


def _pose(robot: Robot, _context: Context) -> Any:
    if robot.telemetry is None:
        return None
    pose, gnss = robot.telemetry.pose, robot.telemetry.gnss
    return {
        "t": milliseconds(pose.stamp.source_s),
        "lat": round(pose.lat_deg, 9),  # 0.1 mm
        "lon": round(pose.lon_deg, 9),
        "heading_deg": heading_deg(pose.theta_rad),
        "speed_mps": round(pose.speed_mps, 3),
        "accuracy_m": round(gnss.accuracy_m, 4) if gnss else None,
    }


def _mission(robot: Robot, context: Context) -> Any:
    if robot.state is None or robot.state.order is None:
        return None
    order = robot.state.order
    facts = context.facts_of(order.mission_id)
    title = context.title_of(order.mission_id) or MissionTitle(order.mission_id, "")
    return {
        "t": milliseconds(robot.state.stamp.source_s),
        "id": order.mission_id,
        "name": title.name,
        "field": title.field,
        "status": order.status.value,
        "row": order.row,
        "rows": order.rows,
        "share": round(min(1.0, order.area_done_m2 / order.area_m2), 4) if order.area_m2 > 0 else 0.0,
        "area_m2": round(order.area_m2, 1),
        "area_done_m2": round(order.area_done_m2, 1),
        "remaining_s": None if order.remaining_s is None else round(order.remaining_s),
        "sha256": order.sha256,
        "is_supervised": _is_supervised(robot, order, context),
        "segment": order.segment,
        "segment_s_m": round(order.segment_s_m, 2),
        "is_pending": facts is not None and facts.is_pending,
    }


def _is_supervised(robot: Robot, order: Order, context: Context) -> bool:
    """Say how it runs, or how it will when somebody starts it: a robot that stands knows only how it ran before."""
    is_at_work = robot.state is not None and robot.state.mode is Mode.AUTO
    return order.is_supervised if is_at_work else context.is_supervised(robot, order)


def _supervisor(robot: Robot, _context: Context) -> Any:
    if robot.state is None:
        return None
    return {
        "t": milliseconds(robot.state.stamp.source_s),
        "path": list(robot.state.path),
        "since": milliseconds(robot.state.path_since_s),
    }


def _tiles(robot: Robot, _context: Context) -> Any:
    return tiles(robot)


def _why(robot: Robot, _context: Context) -> Any:
    return why(robot)


def _actions(robot: Robot, _context: Context) -> Any:
    return actions(robot)


def _checks(robot: Robot, context: Context) -> Any:
    order = robot.state.order if robot.state is not None else None
    return start_checks(robot, context.facts_of(order.mission_id) if order is not None else None)


def _safety(robot: Robot, _context: Context) -> Any:
    safety = robot.safety
    if safety is None:
        return None
    return {
        "t": milliseconds(safety.stamp.source_s),
        "latched": safety.latched,
        "hardware_stop": safety.hardware_stop,
        "standstill": safety.standstill,
        "tool_off": safety.tool_off,
        "speed_mps": round(safety.speed_mps, 3),
        "stopping_distance_m": safety.stopping_distance_m,
        "presses": [
            {
                "stop_id": p.stop_id,
                "by": p.by,
                "device": p.device,
                "t": milliseconds(p.pressed_s),
                "is_reset": p.is_reset,
            }
            for p in safety.presses
        ],
    }


def _body(robot: Robot, context: Context) -> Any:
    sheet = robot.factsheet
    if sheet is None:
        return None
    return {
        "length_m": sheet.length_m,
        "width_m": sheet.width_m,
        "base_to_front_m": sheet.base_to_front_m,
        "keep_out_m": keep_out_m(context.keep_out_m, sheet.keep_out_m),
        "decel_mps2": sheet.decel_mps2,
        "max_speed_mps": sheet.max_speed_mps,
        "deadman_s": sheet.drive_deadman_s,
        "operator_lost_s": sheet.operator_lost_pause_s,
        "link_lost_s": None if sheet.family is Family.UAV else sheet.link_lost_pause_s,  # it flies home
        "stop_effect": sheet.stop_effect,
        "horn_s": sheet.start_horn_s,
        "tool_label": tool_label(robot),
        "contact": {"name": context.contact_name, "phone": context.contact_phone},
    }


def _faults(robot: Robot, _context: Context) -> Any:
    if robot.state is None:
        return None
    return [
        {"code": f.code, "level": FAULT_LEVELS[f.level], "text": f.text, "hint": f.hint} for f in robot.state.faults
    ]


PRESENTERS: dict[str, Callable[[Robot, Context], Any]] = {
    "id": _id,
    "link": _link,
    "mode": _mode,
    "pose": _pose,
    "mission": _mission,
    "supervisor": _supervisor,
    "tiles": _tiles,
    "why": _why,
    "actions": _actions,
    "checks": _checks,
    "safety": _safety,
    "body": _body,
    "faults": _faults,
}
"""Group name to what makes it. ``lease`` is missing: it is not the robot's and comes from the lease service."""
