"""Tiles of what only some machines have: a planter's crane, trays and tilt, a drone's height, wind and time to return.

A tile is shown only for what the robot declares; nothing is reckoned from elsewhere.
"""

from __future__ import annotations

from hmi.domain.machine import Body, GaugeInfo
from hmi.domain.robot import Family, Robot
from hmi.presenters.tile import NOT_HEARD, Tile, bar, tile
from hmi.presenters.units import number, on_scale
from hmi.presenters.words import TOOL_STATES, tool_label

BODY_MS = 500  # at rest a machine tells its joints and gauges twice a second
GAUGES = {Family.PLANTER: ("tilt",), Family.UAV: ("height", "wind", "return-time")}
MOST_OF_OTHERS = 4  # gauges of a machine that nobody here knows: the first it declares
PLAIN = frozenset({"speed", "battery", "gnss", "delay", "tool", "cross-track"})  # tiles that every machine has


def tiles(robot: Robot) -> list[Tile]:
    """Return the machine's own tiles, none for one that has nothing of the kind."""
    sheet = robot.factsheet
    if sheet is None:
        return []
    shown = GAUGES.get(sheet.family, ())
    if sheet.family is Family.OTHER:
        shown = tuple(one.key for one in sheet.gauges if one.key not in PLAIN)[:MOST_OF_OTHERS]
    gauges = [_gauge(one, robot.body) for key in shown for one in sheet.gauges if one.key == key]
    return [_crane(robot), *gauges, _stock(robot.body)] if sheet.family is Family.PLANTER else gauges


def _crane(robot: Robot) -> Tile:
    label, fast, body = tool_label(robot), robot.telemetry, robot.body
    if fast is None or fast.tool is None:
        return tile("tool", label, "text", None, missing=NOT_HEARD if fast is None else "no tool reported")
    past = _past_soft_limit(robot)
    load = "" if body is None or body.is_loaded is None else "seedling in hand" if body.is_loaded else "hand empty"
    state = (
        load if fast.tool.is_interlock_ok and load else "guard closed" if fast.tool.is_interlock_ok else "guard open"
    )
    return tile(
        "tool",
        label,
        "text",
        fast.pose.stamp.source_s,
        value=fast.tool.state,
        text=TOOL_STATES[fast.tool.state],
        sub=f"{past} at its soft limit" if past else state,
        level=2 if past or fast.tool.state == "fault" else None if fast.tool.is_interlock_ok else 3,
    )


def _past_soft_limit(robot: Robot) -> str:
    """Return the label of a joint beyond its soft limit, empty if none is."""
    measured = robot.body.joints if robot.body is not None else {}
    for one in robot.factsheet.joints if robot.factsheet is not None else ():
        value = measured.get(one.name)
        if value is None:
            continue
        if (one.soft_lower is not None and value < one.soft_lower) or (
            one.soft_upper is not None and value > one.soft_upper
        ):
            return one.label
    return ""


def _stock(body: Body | None) -> Tile:
    if body is None or body.stock is None:
        return tile(
            "stock", "Trays", "count", None, period_ms=BODY_MS, missing=NOT_HEARD if body is None else "not told"
        )
    return tile(
        "stock",
        "Trays",
        "count",
        body.stamp.source_s,
        value=body.stock,
        text=str(body.stock),
        unit="left",
        sub="empty: refill the trays" if body.stock == 0 else "seedlings",
        level=3 if body.stock == 0 else None,
        period_ms=BODY_MS,
    )


def _gauge(gauge: GaugeInfo, body: Body | None) -> Tile:
    value = body.gauges.get(gauge.key) if body is not None else None
    if body is None or value is None:
        missing = NOT_HEARD if body is None else "not told"
        return tile(gauge.key, gauge.label, "gauge", None, period_ms=BODY_MS, missing=missing)
    low, high = gauge.ok_lower, gauge.ok_upper
    is_outside = (low is not None and value < low) or (high is not None and value > high)
    ends = (gauge.lower, gauge.upper)
    limits = [on_scale(one, *ends) for one in (low, high) if one is not None]
    band = (
        on_scale(gauge.lower if low is None else low, *ends),
        on_scale(gauge.upper if high is None else high, *ends),
    )
    return tile(
        gauge.key,
        gauge.label,
        "gauge",
        body.stamp.source_s,
        value=value,
        text=number(value, 0 if abs(value) >= 100 else 1),
        unit=gauge.unit,
        sub=gauge.limit_text,
        bar=bar(*band, on_scale(value, *ends), limits) if gauge.upper > gauge.lower else None,
        level=2 if is_outside else None,
        period_ms=BODY_MS,
    )
