"""Wire messages of a robot to the console's own values. The only place that knows both.

Every function takes the message and its ``Stamp``; ``to_console_s`` maps a robot time in ms to the console's
monotonic clock.
"""

from __future__ import annotations

from collections.abc import Callable
from datetime import datetime

from backend_clients.edge import messages_up as up
from backend_clients.edge.machine import LastTransition as LastTransitionSaid
from hmi.domain import robot as domain
from hmi.domain.command import Acknowledgement
from hmi.domain.event import RobotEvent
from hmi.domain.state_chart import ActiveState, LastTransition
from hmi.ingest import translate_machine

ToConsole = Callable[[int], float]


def telemetry(m: up.Telemetry, stamp: domain.Stamp) -> domain.Telemetry:
    """Fast values."""
    return domain.Telemetry(
        pose=domain.Pose(m.lat_deg, m.lon_deg, m.x_m, m.y_m, m.theta_rad, m.speed_mps, m.yaw_rate_radps, stamp),
        gnss=domain.Gnss(m.gnss.fix, m.gnss.accuracy_m, m.gnss.satellites, m.gnss.correction_age_s) if m.gnss else None,
        battery=domain.Battery(m.battery.soc, m.battery.remaining_s, m.battery.charging) if m.battery else None,
        tool=domain.ToolState(m.tool.state, m.tool.interlock_ok, m.tool.rate_per_min, m.tool.temperature_c)
        if m.tool
        else None,
        cross_track_m=m.cross_track_m,
        obstacle_m=m.obstacle_m,
    )


def state(m: up.State, stamp: domain.Stamp, to_console_s: ToConsole) -> domain.RobotState:
    """Operating state, mission progress and what is wrong."""
    return domain.RobotState(
        mode=domain.Mode(m.mode),
        path=tuple(m.path),
        path_since_s=to_console_s(m.path_since_ms),
        lease_token=m.lease_token,
        set_speed_mps=m.set_speed_mps,
        order=_order(m.order) if m.order else None,
        faults=tuple(domain.Fault(f.code, f.level, f.text, f.hint) for f in m.faults),
        hold=domain.Hold(m.hold.code, m.hold.text, m.hold.clears, m.hold.who) if m.hold else None,
        stamp=stamp,
        active=tuple(ActiveState(a.id, to_console_s(a.since_ms)) for a in m.active),
        last_transition=_last(m.last_transition, to_console_s) if m.last_transition else None,
    )


def _last(m: LastTransitionSaid, to_console_s: ToConsole) -> LastTransition:
    return LastTransition(m.source, m.target, m.event, m.result, to_console_s(m.at_ms))


def _order(m: up.OrderState) -> domain.Order:
    return domain.Order(
        mission_id=m.mission_id,
        revision=m.revision,
        sha256=m.sha256,
        status=domain.OrderStatus(m.status),
        row=m.row,
        rows=m.rows,
        segment=m.segment,
        segment_s_m=m.segment_s_m,
        area_m2=m.area_m2,
        area_done_m2=m.area_done_m2,
        distance_m=m.distance_m,
        remaining_s=m.remaining_s,
        is_supervised=m.is_supervised,
    )


def safety(m: up.Safety, stamp: domain.Stamp, to_console_s: ToConsole) -> domain.SafetyState:
    """What the safety controller says."""
    return domain.SafetyState(
        hardware_stop=m.hardware_stop,
        latched=m.latched,
        standstill=m.standstill,
        speed_mps=m.speed_mps,
        tool_off=m.tool_off,
        presses=tuple(domain.Press(p.stop_id, p.by, p.device, to_console_s(p.mono_ms), p.is_reset) for p in m.presses),
        stopping_distance_m=m.stopping_distance_m,
        stamp=stamp,
    )


def factsheet(m: up.Factsheet) -> domain.Factsheet:
    """What the robot says it is; what it does not say of its own behaviour is not made up."""
    told = m.behaviour
    return domain.Factsheet(
        family=domain.Family(m.family),
        name=m.name,
        model=m.model,
        software=m.software,
        datum_lat_deg=m.datum.lat_deg,
        datum_lon_deg=m.datum.lon_deg,
        length_m=m.dimensions.length_m,
        width_m=m.dimensions.width_m,
        height_m=m.dimensions.height_m,
        base_to_front_m=m.dimensions.base_to_front_m,
        track_m=m.dimensions.track_m,
        max_speed_mps=m.limits.max_speed_mps,
        max_accel_mps2=m.limits.max_accel_mps2,
        decel_mps2=m.limits.decel_mps2,
        max_yaw_rate_radps=m.limits.max_yaw_rate_radps,
        turning_radius_m=m.limits.turning_radius_m,
        can_reverse=m.limits.can_reverse,
        can_pivot=m.limits.can_pivot,
        path_reverse_mps=m.limits.path_reverse_mps,
        path_height_m=m.limits.path_height_m,
        tool_kind=m.tool.kind if m.tool else "",
        tool_label=m.tool.label if m.tool else "",
        tool_width_m=m.tool.width_m if m.tool else 0.0,
        drive_deadman_s=told.drive_deadman_s if told else None,
        operator_lost_pause_s=told.operator_lost_pause_s if told else None,
        link_lost_pause_s=told.link_lost_pause_s if told else None,
        start_horn_s=told.start_horn_s if told else None,
        keep_out_m=(told or up.Behaviour()).keep_out_m,  # people stay away as from any other machine
        stop_effect=told.stop_effect if told else "",
        functions=translate_machine.functions(m),
        nodes=translate_machine.nodes(m),
        joints=translate_machine.joints(m),
        gauges=translate_machine.gauges(m),
        chart=translate_machine.chart(m.chart) if m.chart else None,
        cameras=translate_machine.cameras(m),
        battery_wh=m.battery.capacity_wh if m.battery else None,
        charge_w=m.battery.charge_w if m.battery else None,
        skips_by_name=m.skips_by_name,
    )


def node(m: up.Node, stamp: domain.Stamp, to_console_s: ToConsole) -> domain.Node:
    """Life cycle of one software node."""
    return domain.Node(
        name=m.name,
        state=m.state,
        rate_hz=m.rate_hz,
        cpu_pct=m.cpu_pct,
        restarts=m.restarts,
        text=m.text,
        stamp=stamp,
        host=m.host,
        since_s=None if m.since_ms is None else to_console_s(m.since_ms),
        clock_offset_s=None if m.clock_offset_ms is None else m.clock_offset_ms / 1000,
        period_s=m.period_ms / 1000,
    )


def event(m: up.Event, stamp: domain.Stamp, at: datetime) -> RobotEvent:
    """Something that happened once."""
    return RobotEvent(m.robot, m.event_id, m.kind, m.name, m.text, m.data, at_utc=at, stamp=stamp)


def acknowledgement(m: up.Ack, stamp: domain.Stamp | None) -> Acknowledgement:
    """The robot's answer; ``stamp`` is ``None`` when it came by HTTP."""
    return Acknowledgement(
        robot_id=m.robot,
        kind=m.kind,
        ref=m.ref,
        is_accepted=m.outcome == "accepted",
        code=m.code,
        text=m.text,
        speed_mps=m.speed_mps,
        sha256=m.sha256,
        stamp=stamp,
    )
