"""Joints, gauges, the site and who is near, as the live lane carries them; pure."""

from __future__ import annotations

from typing import Any

from hmi.domain.machine import GaugeInfo, JointInfo, Sight, Worksite
from hmi.domain.robot import Robot
from hmi.presenters.units import milliseconds

WARNS = 2
"""Priority shown for a joint beyond its soft limit and a gauge outside its normal range."""
_DIGITS = 5  # hundredths of a millimetre


def joints(robot: Robot) -> dict[str, Any] | None:
    """Return every declared joint with its place, its planned place and its limits; ``None`` without joints."""
    declared = robot.factsheet.joints if robot.factsheet else ()
    if not declared:
        return None
    body = robot.body
    return {
        "t": None if body is None else milliseconds(body.stamp.source_s),
        "joints": [
            _joint(one, body.joints.get(one.name) if body else None, body.planned.get(one.name) if body else None)
            for one in declared
        ],
    }


def gauges(robot: Robot) -> dict[str, Any] | None:
    """Return every declared gauge with its value and normal range; ``None`` without gauges."""
    declared = robot.factsheet.gauges if robot.factsheet else ()
    if not declared:
        return None
    body = robot.body
    return {
        "t": None if body is None else milliseconds(body.stamp.source_s),
        "gauges": [_gauge(one, body.gauges.get(one.key) if body else None) for one in declared],
    }


def site(robot: Robot) -> dict[str, Any] | None:
    """Return where it works now: area, obstacles, targets, and what it carries; metres of the factsheet's datum."""
    place = robot.worksite
    if place is None:
        return None
    return {
        "t": milliseconds(place.stamp.source_s),
        "stop": place.stop,
        "area": [list(corner) for corner in place.area],
        "obstacles": _obstacles(place),
        "targets": [
            {"id": one.id, "x_m": one.x_m, "y_m": one.y_m, "status": one.status, "text": one.text}
            for one in place.targets
        ],
        "stock": robot.body.stock if robot.body else None,
        "is_loaded": robot.body.is_loaded if robot.body else None,
    }


def seen(robot: Robot) -> dict[str, Any] | None:
    """Return who and what the robot sees near itself."""
    body = robot.body
    if body is None:
        return None
    return {
        "t": milliseconds(body.stamp.source_s),
        "seen": [
            {"id": one.id, "kind": one.kind, "distance_m": one.distance_m, "x_m": one.x_m, "y_m": one.y_m}
            for one in body.seen
        ],
    }


def detections(robot: Robot) -> dict[str, Any] | None:
    """Return what was found in pictures: of the newest one, and of the other cameras that are watched."""
    newest = sorted((_sight(one) for one in robot.sights.values()), key=lambda one: -one["t"])
    return {**newest[0], "others": newest[1:]} if newest else None


def _sight(one: Sight) -> dict[str, Any]:
    return {
        "t": milliseconds(one.stamp.source_s),
        "camera": one.camera,
        "boxes": [
            {"kind": b.kind, "x": b.x, "y": b.y, "w": b.w, "h": b.h, "score": b.score, "hit": b.hit} for b in one.boxes
        ],
    }


def _obstacles(place: Worksite) -> list[dict[str, Any]]:
    return [
        {"id": o.id, "kind": o.kind, "x_m": o.x_m, "y_m": o.y_m, "radius_m": o.radius_m, "height_m": o.height_m}
        for o in place.obstacles
    ]


def _joint(one: JointInfo, value: float | None, planned: float | None) -> dict[str, Any]:
    return {
        "name": one.name,
        "label": one.label,
        "unit": one.unit,
        "value": _short(value),
        "planned": _short(planned),
        "lower": one.lower,
        "upper": one.upper,
        "soft_lower": one.soft_lower,
        "soft_upper": one.soft_upper,
        "max_rate": one.max_rate,
        "level": WARNS if _is_outside(value, one.soft_lower, one.soft_upper) else None,
    }


def _gauge(one: GaugeInfo, value: float | None) -> dict[str, Any]:
    return {
        "key": one.key,
        "label": one.label,
        "unit": one.unit,
        "value": _short(value),
        "lower": one.lower,
        "upper": one.upper,
        "ok_lower": one.ok_lower,
        "ok_upper": one.ok_upper,
        "limit_text": one.limit_text,
        "level": WARNS if _is_outside(value, one.ok_lower, one.ok_upper) else None,
    }


def _is_outside(value: float | None, lower: float | None, upper: float | None) -> bool:
    if value is None:
        return False
    return (lower is not None and value < lower) or (upper is not None and value > upper)


def _short(value: float | None) -> float | None:
    return None if value is None else round(value, _DIGITS)
