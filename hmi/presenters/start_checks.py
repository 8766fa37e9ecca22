"""What must be true before a mission starts, each with one sentence and what mends it: lane group ``checks``.

A check that blocks is one the robot, or the console, would refuse the start for; the others warn.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

from hmi.domain.command import Action
from hmi.domain.family import Family
from hmi.domain.function_use import Uses
from hmi.domain.robot import OrderStatus, Robot
from hmi.presenters.units import number, percent
from hmi.presenters.words import has_mission

Check = dict[str, Any]
Place = tuple[float, float]
BATTERY_LEAST = 0.1  # the robot refuses to start below
BATTERY_RESERVE = 0.15  # what should be left at the end where the mission says nothing of its own
TOO_FAR_M = 500.0  # the robot refuses to start a mission this far away
METRES_PER_DEG = 111_320.0


class MissionFacts(NamedTuple):
    """What the console knows of a stored mission.

    Args:
        battery_share, duration_s: what all of it needs.
        map_text: empty if the map around it is as it was planned, ``None`` if that is not known, else what changed.
        start: longitude and latitude of its first point.
        fences: corners of each farm, longitude and latitude; empty without one.
        is_pending: another document of it was sent and not read back yet.
        reserve_share: of the battery, what should be left at the end to get home.
        flight_text: what stands in the path of what flies, empty if nothing does, ``None`` if that is not known (yet).
    """

    sha256: str
    name: str
    revision: int
    battery_share: float | None = None
    duration_s: float | None = None
    map_number: int | None = None
    map_text: str | None = None
    start: Place | None = None
    fences: Sequence[Sequence[Place]] = ()
    is_pending: bool = False
    reserve_share: float = BATTERY_RESERVE
    flight_text: str | None = None


def start_checks(robot: Robot, facts: MissionFacts | None) -> list[Check]:
    """Return the checks in the order in which they are shown; none while it runs or has no mission."""
    order = robot.state.order if robot.state is not None else None
    if order is None or order.status in (OrderStatus.NONE, OrderStatus.RUNNING):
        return []
    return [
        _link(robot),
        _mission(robot, facts),
        _map(facts),
        *_flight(robot, facts),
        _battery(robot, facts),
        _site(robot, facts),
        _position(robot),
        _tool(robot),
        _people(robot),
        *_functions(robot),
    ]


def _check(key: str, ok: bool | None, text: str, clears: str = "", *, blocks: bool = True) -> Check:
    is_blocking = blocks and ok is not True
    return {"key": key, "ok": ok, "text": text, "clears": "" if ok else clears, "blocks": is_blocking}


def _link(robot: Robot) -> Check:
    if robot.link.is_online and robot.state is not None:
        return _check("link", True, "The robot is heard.")
    return _check("link", False, "The robot is not heard.", "Look at its power and its radio.")


def _mission(robot: Robot, facts: MissionFacts | None) -> Check:
    order = robot.state.order if robot.state is not None else None
    if facts is None or order is None:
        return _check("mission", None, "Its mission is not stored here.", "Send a stored mission.", blocks=False)
    if order.sha256 == facts.sha256:
        return _check("mission", True, f"It read back {facts.name}, version {facts.revision}.")
    return _check("mission", False, f"It has another version of {facts.name}.", "Send the mission again.")


def _map(facts: MissionFacts | None) -> Check:
    if facts is None or facts.map_number is None or facts.map_text is None:
        text = "On which map it was planned is not known."
        return _check("map", None, text, "Look at the field, or plan it again.", blocks=False)
    if facts.map_text:
        return _check("map", False, facts.map_text, "Plan it again if that is in the way.", blocks=False)
    return _check("map", True, f"Planned on map v{facts.map_number}; nothing changed around it.")


def _flight(robot: Robot, facts: MissionFacts | None) -> list[Check]:
    """Return nothing for what drives."""
    sheet = robot.factsheet
    if facts is None or sheet is None or sheet.family is not Family.UAV:
        return []
    if facts.flight_text is None:
        return [_check("flight", None, "What stands in its path is being looked up.", "Wait a moment.")]
    if facts.flight_text:
        return [_check("flight", False, facts.flight_text)]
    at = "" if sheet.path_height_m is None else f" at {number(sheet.path_height_m)} m"
    return [_check("flight", True, f"Nothing on the map stands in its path{at}.")]


def _battery(robot: Robot, facts: MissionFacts | None) -> Check:
    battery = robot.telemetry.battery if robot.telemetry is not None else None
    order = robot.state.order if robot.state is not None else None
    if battery is None:
        return _check("battery", None, "The charge is not known.", "Look at the machine.", blocks=False)
    has = f"Battery {percent(battery.soc)} %"
    if battery.soc < BATTERY_LEAST:
        return _check("battery", False, f"{has}: too low to start.", "Charge it or swap the battery.")
    need = _need(facts, None if order is None else order.remaining_s)
    if need is None:
        return _check("battery", None, f"{has}; what the mission needs is not known.", blocks=False)
    reserve = BATTERY_RESERVE if facts is None else facts.reserve_share
    told = f"{has}, the mission needs {percent(need)} % and {percent(reserve)} % reserve."
    if battery.soc < need + reserve:
        return _check("battery", False, told, "It will pause to be charged, and goes on later.", blocks=False)
    return _check("battery", True, told)


def _need(facts: MissionFacts | None, remaining_s: float | None) -> float | None:
    if facts is None or facts.battery_share is None or not facts.duration_s:
        return None
    share = 1.0 if remaining_s is None else min(remaining_s / facts.duration_s, 1.0)
    return facts.battery_share * share


def _site(robot: Robot, facts: MissionFacts | None) -> Check:
    pose = robot.telemetry.pose if robot.telemetry is not None else None
    if pose is None or facts is None or facts.start is None:
        return _check("site", None, "Whether it is at the field is not known.", blocks=False)
    here = (pose.lon_deg, pose.lat_deg)
    away_m = _metres(here, facts.start)
    is_resumed = has_mission(robot, OrderStatus.PAUSED)  # its first point is long behind it
    if away_m > TOO_FAR_M and not is_resumed:
        return _check("site", False, f"It is {number(away_m)} m from the start.", "Drive it to the field first.")
    if facts.fences and not any(_inside(here, one) for one in facts.fences):
        return _check("site", False, "It stands outside the farm.", "Look whether that is right.", blocks=False)
    no_edge = (
        "" if facts.fences or facts.map_text is None else " The map has no farm edge: nobody notices if it leaves."
    )
    where = "" if is_resumed else f", {number(away_m)} m from the first point"
    return _check("site", True, f"It is at the site{where}.{no_edge}")


def _position(robot: Robot) -> Check:
    gnss = robot.telemetry.gnss if robot.telemetry is not None else None
    if gnss is None:
        return _check("rtk", None, "How exact its position is, is not known.", "Look at the receiver.", blocks=False)
    if gnss.fix == "fixed":
        return _check("rtk", True, f"RTK fixed, ±{number(gnss.accuracy_m * 100, 1)} cm.")
    text = "RTK is not fixed: its position is not exact enough."
    return _check("rtk", False, text, "Wait, or look at the base station.")


def _tool(robot: Robot) -> Check:
    tool = robot.telemetry.tool if robot.telemetry is not None else None
    if tool is None:
        return _check("tool", None, "The state of the tool is not known.", "Look at the machine.", blocks=False)
    if tool.state == "fault" and tool.is_interlock_ok:
        return _check("tool", False, "The tool reports a fault.", "Look at its alarms.")
    if not tool.is_interlock_ok:
        return _check("tool", False, "The tool's interlock is open.", "Close the cover on the machine.")
    return _check("tool", True, "Tool interlock closed.")


def _people(robot: Robot) -> Check:
    faults = {fault.code for fault in robot.state.faults} if robot.state is not None else set()
    if "person-ahead" in faults:
        text = "Somebody or something stands in front of it."
        return _check("people", False, text, "Look at the machine and clear the way.")
    if robot.telemetry is None:
        return _check("people", None, "What is ahead of it is not known.", "Look at the machine.", blocks=False)
    free_m = robot.telemetry.obstacle_m
    seen = "Its sensors see nobody ahead." if free_m is None else f"{number(free_m)} m free ahead."
    return _check("people", True, seen)


def _functions(robot: Robot) -> list[Check]:
    """Return nothing for a robot that does not tell what it can do."""
    uses = Uses(robot)
    if not uses.are_known:
        return []
    if reason := uses.obstacle(Action.START):
        what, _, cure = reason.partition(". ")
        return [_check("functions", False, f"{what}.", cure)]
    if less := uses.limited():
        text = f"{less.info.label} is limited: {less.why}."
        return [_check("functions", False, text, f"{less.turns_on} on Supervisor.", blocks=False)]
    return [_check("functions", True, "Everything the work needs runs.")]


def _metres(a: Place, b: Place) -> float:
    east = (b[0] - a[0]) * math.cos(math.radians((a[1] + b[1]) / 2))
    return math.hypot(east, b[1] - a[1]) * METRES_PER_DEG


def _inside(place: Place, ring: Sequence[Place]) -> bool:
    x, y = place
    is_in = False
    for (x0, y0), (x1, y1) in zip(ring, (*ring[1:], ring[0]), strict=True):
        if (y0 > y) != (y1 > y) and x < (x1 - x0) * (y - y0) / (y1 - y0) + x0:
            is_in = not is_in
    return is_in
