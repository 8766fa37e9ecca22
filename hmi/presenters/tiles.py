"""The tiles of the operate screen: value, normal band, limits and one line of meaning."""

from __future__ import annotations

from hmi.domain.robot import Family, Mode, Robot, Telemetry
from hmi.presenters import machine_tiles
from hmi.presenters.tile import NOT_HEARD, RTT_MS, Tile, bar, tile
from hmi.presenters.units import number, on_scale, percent, short_length, span_text
from hmi.presenters.words import TOOL_STATES, mode_of, tool_label

SPEED_LIMIT_AT = 0.9  # where on the bar the machine's own limit stands
SPEED_BAND = 0.2  # a row's speed within a fifth of what is set is normal
SOC_LOW, SOC_VERY_LOW = 0.25, 0.15
NEED_MARGIN = 1.0  # charge must last at least as long as the mission
GNSS_SCALE_M = 0.10
DELAY_SCALE_S = 0.5
DRIVE_CUT_S = 0.3  # driving by hand is cut above this round trip
OFF_LINE_LIMIT_M, OFF_LINE_BAND_M = 0.03, 0.014  # crop rows are hit within 3 cm
TOOL_RATE_SCALE, TOOL_RATE_LIMIT = 400.0, 368.0  # shots a minute at full load of the laser head
FIXES = {"fixed": ("Fix", None), "float": ("Float", 3), "single": ("Single", 2), "none": ("None", 2)}


def tiles(robot: Robot) -> list[Tile]:
    """Return the tiles in display order; a machine that measures more shows that instead of its plain tool."""
    fast = robot.telemetry
    own = machine_tiles.tiles(robot)
    where = [_gnss(fast), _delay(robot)]
    if own:  # a small screen shows six without scrolling: what only this machine has comes first
        tool = [] if own[0]["key"] == "tool" else [_tool(robot, fast)]
        return [_speed(robot, fast), _battery(robot, fast), *own, *tool, *where, _cross_track(robot, fast)]
    return [_speed(robot, fast), _battery(robot, fast), *where, _tool(robot, fast), _cross_track(robot, fast)]


def layout(robot: Robot) -> list[tuple[str, str]]:
    """Return key and label of each tile, for a page that is laid out before values come."""
    return [(one["key"], one["label"]) for one in tiles(robot)]


def _speed(robot: Robot, fast: Telemetry | None) -> Tile:
    if fast is None:
        return tile("speed", "Speed", "speed", None, missing=NOT_HEARD)
    speed = fast.pose.speed_mps
    top = robot.factsheet.max_speed_mps if robot.factsheet and robot.factsheet.max_speed_mps > 0 else None
    target = robot.state.set_speed_mps if robot.state else None
    band_bar, level = None, None
    if top is not None:
        scale = top / SPEED_LIMIT_AT
        band = (
            (on_scale(target * (1 - SPEED_BAND), 0, scale), on_scale(target * (1 + SPEED_BAND), 0, scale))
            if target
            else (0.0, on_scale(top, 0, scale))
        )
        band_bar = bar(*band, on_scale(abs(speed), 0, scale), [SPEED_LIMIT_AT * 100])
        level = 2 if abs(speed) > top * 1.05 else None
    return tile(
        "speed",
        "Speed",
        "speed",
        fast.pose.stamp.source_s,
        value=speed,
        text=number(speed, 2),
        unit="m/s",
        sub=_speed_meaning(robot, target),
        bar=band_bar,
        level=level,
    )


def _speed_meaning(robot: Robot, target: float | None) -> str:
    mode = mode_of(robot)
    if mode is Mode.STOPPED:
        still = robot.safety is not None and robot.safety.standstill
        return "standstill confirmed" if still else "stopping"
    if mode is Mode.MANUAL:
        return f"limit {number(target, 2)} m/s" if target else "hold to drive"
    if mode is Mode.PAUSED:
        return "paused"
    return f"set {number(target, 2)} m/s" if target else "no speed set"


def _battery(robot: Robot, fast: Telemetry | None) -> Tile:
    if fast is None or fast.battery is None:
        return tile("battery", "Battery", "share", None, missing=NOT_HEARD if fast is None else "it has no gauge")
    battery = fast.battery
    need_s = robot.state.order.remaining_s if robot.state and robot.state.order else None
    lasts_s = battery.remaining_s
    is_short = need_s is not None and lasts_s is not None and lasts_s < need_s * NEED_MARGIN
    level = 2 if battery.soc < SOC_VERY_LOW else 3 if battery.soc < SOC_LOW or is_short else None
    if battery.is_charging:
        sub, level = "charging", None
    elif lasts_s is None:
        sub = "time left not known"
    elif need_s:
        sub = f"{span_text(lasts_s)}, need {span_text(need_s)}"
    else:
        sub = f"{span_text(lasts_s)} left"
    return tile(
        "battery",
        "Battery",
        "share",
        fast.pose.stamp.source_s,
        value=battery.soc,
        text=percent(battery.soc),
        unit="%",
        sub=sub,
        bar=bar(SOC_LOW * 100, 100, round(battery.soc * 100, 1), [SOC_VERY_LOW * 100]),
        level=level,
    )


def _gnss(fast: Telemetry | None) -> Tile:
    if fast is None or fast.gnss is None:
        return tile("gnss", "RTK", "length", None, missing=NOT_HEARD if fast is None else "no receiver reported")
    gnss = fast.gnss
    text, level = FIXES[gnss.fix]
    accuracy, unit = short_length(gnss.accuracy_m)
    correction = f", corr. {number(gnss.correction_age_s, 1)} s" if gnss.correction_age_s is not None else ""
    return tile(
        "gnss",
        "RTK",
        "length",
        fast.pose.stamp.source_s,
        value=gnss.accuracy_m,
        text=text,
        unit="" if gnss.fix == "none" else f"±{accuracy} {unit}",
        sub=f"{gnss.satellites} sats{correction}",
        bar=bar(0, 40, on_scale(gnss.accuracy_m, 0, GNSS_SCALE_M), [50]),
        level=level,
    )


def _delay(robot: Robot) -> Tile:
    link = robot.link
    if link.rtt_s is None:
        why = "measured for registered robots only" if not robot.is_registered else "not measured yet"
        return tile("delay", "Link delay", "delay", None, period_ms=RTT_MS, missing=why)
    most = link.rtt_max_s if link.rtt_max_s is not None else link.rtt_s
    is_manual = mode_of(robot) is Mode.MANUAL
    return tile(
        "delay",
        "Link delay",
        "delay",
        link.rtt_at_s,
        value=link.rtt_s,
        text=number(link.rtt_s * 1000),
        unit="ms",
        sub=f"drive cuts at {number(DRIVE_CUT_S * 1000)} ms" if is_manual else f"max {number(most * 1000)} ms, 1 min",
        bar=bar(0, 50, on_scale(link.rtt_s, 0, DELAY_SCALE_S), [on_scale(DRIVE_CUT_S, 0, DELAY_SCALE_S)]),
        level=3 if link.rtt_s > DRIVE_CUT_S else None,
        period_ms=RTT_MS,
    )


def _tool(robot: Robot, fast: Telemetry | None) -> Tile:
    label = tool_label(robot)
    if fast is None or fast.tool is None:
        return tile("tool", label, "text", None, missing=NOT_HEARD if fast is None else "no tool reported")
    tool = fast.tool
    is_on = tool.state == "on"
    rate = tool.rate_per_min if is_on else None
    has_interlock = robot.factsheet is None or robot.factsheet.family is not Family.UAV  # a camera has none
    interlock = "interlock open" if not tool.is_interlock_ok else "interlock ok" if has_interlock else ""
    warmth = f"{number(tool.temperature_c)} °C" if tool.temperature_c is not None else ""
    is_open_at_work = not tool.is_interlock_ok and mode_of(robot) is Mode.AUTO
    return tile(
        "tool",
        label,
        "text",
        fast.pose.stamp.source_s,
        value=tool.state,
        text=TOOL_STATES[tool.state],
        unit=f"{number(rate)} /min" if rate is not None else "",
        sub=", ".join(filter(None, (interlock, warmth))),
        bar=None
        if rate is None
        else bar(20, 80, on_scale(rate, 0, TOOL_RATE_SCALE), [on_scale(TOOL_RATE_LIMIT, 0, TOOL_RATE_SCALE)]),
        level=2 if tool.state == "fault" else 3 if is_open_at_work else None,
    )


def _cross_track(robot: Robot, fast: Telemetry | None) -> Tile:
    if fast is None or fast.cross_track_m is None:
        why = NOT_HEARD if fast is None else "not on a path"
        return tile("cross-track", "Off line", "length", None, missing=why)
    off = fast.cross_track_m
    text, unit = short_length(abs(off))
    half = OFF_LINE_LIMIT_M / 0.6  # the limits stand at 20 and 80 of the bar
    band = [on_scale(-OFF_LINE_BAND_M, -half, half), on_scale(OFF_LINE_BAND_M, -half, half)]
    is_at_work = mode_of(robot) is Mode.AUTO and fast.tool is not None and fast.tool.state == "on"
    return tile(
        "cross-track",
        "Off line",
        "length",
        fast.pose.stamp.source_s,
        value=off,
        text=text,
        unit=unit,
        sub=f"limit ±{number(OFF_LINE_LIMIT_M * 100, 1)} cm",
        bar=bar(band[0], band[1], on_scale(off, -half, half), [20, 80]),
        level=3 if abs(off) > OFF_LINE_LIMIT_M and is_at_work else None,
    )
