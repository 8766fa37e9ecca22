"""Wire messages about the inside of a machine to the console's own values."""

from __future__ import annotations

from backend_clients.edge import machine as wire
from backend_clients.edge.messages_up import Factsheet
from hmi.domain import machine as domain
from hmi.domain import state_chart
from hmi.domain.camera import CameraInfo, CameraPtz
from hmi.domain.stamp import Stamp


def functions(m: Factsheet) -> tuple[domain.FunctionInfo, ...]:
    """What the robot can do."""
    return tuple(domain.FunctionInfo(f.name, f.label, tuple(f.depends_on), tuple(f.better_with)) for f in m.functions)


def nodes(m: Factsheet) -> tuple[domain.NodeInfo, ...]:
    """Its software nodes."""
    return tuple(
        domain.NodeInfo(
            n.name,
            n.label,
            n.subsystem,
            n.rate_hz,
            tuple(n.starts_after),
            None if n.period_ms is None else n.period_ms / 1000,
        )
        for n in m.nodes
    )


def joints(m: Factsheet) -> tuple[domain.JointInfo, ...]:
    """Its moving joints; one without a label is called by its name."""
    return tuple(
        domain.JointInfo(j.name, j.label or j.name, j.unit, j.lower, j.upper, j.max_rate, j.soft_lower, j.soft_upper)
        for j in m.joints
    )


def gauges(m: Factsheet) -> tuple[domain.GaugeInfo, ...]:
    """What it measures."""
    return tuple(
        domain.GaugeInfo(g.key, g.label, g.unit, g.lower, g.upper, g.ok_lower, g.ok_upper, g.limit_text)
        for g in m.gauges
    )


def cameras(m: Factsheet) -> tuple[CameraInfo, ...]:
    """Its cameras; where their pictures come from is not the robot's to say."""
    return tuple(
        CameraInfo(
            id=c.id,
            label=c.label,
            width_px=c.width_px,
            height_px=c.height_px,
            kind=c.kind,
            fps=c.fps,
            view=c.view,
            fov_deg=c.fov_deg,
            ptz=None if c.ptz is None else CameraPtz(c.ptz.pan, c.ptz.tilt, c.ptz.zoom),
            has_lamp=c.has_lamp,
            has_trigger=c.has_trigger,
        )
        for c in m.cameras
    )


def chart(m: wire.Chart) -> state_chart.Chart:
    """Its supervisor."""
    states = tuple(
        state_chart.ChartState(
            s.id, s.label, s.parent, s.kind, s.is_initial, s.subsystem, s.normal_s, tuple(s.entry), tuple(s.exit)
        )
        for s in m.states
    )
    moves = tuple(state_chart.ChartTransition(t.source, t.target, t.event, t.guard) for t in m.transitions)
    return state_chart.Chart(states, moves)


def body(m: wire.Body, stamp: Stamp) -> domain.Body:
    """Joints, gauges and who is near."""
    return domain.Body(
        joints=m.joints,
        planned=m.planned,
        gauges=m.gauges,
        tool=m.tool,
        is_loaded=m.is_loaded,
        stock=m.stock,
        seen=tuple(domain.Sighting(s.id, s.kind, s.x_m, s.y_m, s.distance_m) for s in m.seen),
        stamp=stamp,
    )


def sight(m: wire.Detections, stamp: Stamp) -> domain.Sight:
    """What was found in a picture."""
    boxes = tuple(domain.SeenBox(b.kind, b.x, b.y, b.w, b.h, b.score, b.hit) for b in m.boxes)
    return domain.Sight(m.camera, m.captured_ms, boxes, stamp)


def worksite(m: wire.Worksite, stamp: Stamp) -> domain.Worksite:
    """Where it works now."""
    return domain.Worksite(
        stop=m.stop,
        area=tuple(m.area),
        obstacles=tuple(domain.Obstacle(o.id, o.kind, o.x_m, o.y_m, o.radius_m, o.height_m) for o in m.obstacles),
        targets=tuple(domain.Target(t.id, t.x_m, t.y_m, t.status, t.text) for t in m.targets),
        stamp=stamp,
    )
