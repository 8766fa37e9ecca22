"""What a mission takes of the battery of the robot it is about to be sent to, in one sentence."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from hmi.domain.planned_machine import MACHINE, battery_share_on
from hmi.domain.robot import Robot
from hmi.presenters.start_checks import BATTERY_RESERVE
from hmi.presenters.units import percent

ONE_CHARGE = 0.85  # of a full battery, as the cards of a plan count


def battery_row(statistics: Mapping[str, Any], robot: Robot, planned_for: str) -> dict[str, Any]:
    """Return the share of this robot's full battery, what it has now, and a sentence; ``None`` for what is not known.

    Args:
        planned_for: what people call the machine that the figures are of.
    """
    share = battery_share_on(statistics, robot.factsheet)
    battery = robot.telemetry.battery if robot.telemetry is not None else None
    reserve = statistics.get("reserve_share") or BATTERY_RESERVE
    need = None if share is None else share + reserve
    is_enough = None if need is None or battery is None else battery.soc >= need
    soc = None if battery is None else battery.soc
    row = {"robot_id": robot.id, "share": share, "reserve_share": reserve, "soc": soc, "is_enough": is_enough}
    machine = statistics.get(MACHINE) or {}
    if robot.factsheet is None and machine.get("robot_id") != robot.id:
        share = None  # the figure is another machine's
        row |= {"share": None, "is_enough": None}
    if share is None:
        of = f" The figure is for {planned_for}." if planned_for else ""
        return {**row, "text": f"What it takes of the battery of {robot.name} is not known.{of}"}
    takes = f"It takes {percent(share)} % of the full battery of {robot.name}"
    if share > ONE_CHARGE:
        charges = math.ceil(share / ONE_CHARGE)
        return {
            **row,
            "text": f"It takes {charges} full charges of {robot.name}: it pauses to be charged, and goes on.",
        }
    if battery is None:
        return {**row, "text": f"{takes}; what it has now is not known."}
    if is_enough:
        return {**row, "text": f"{takes}, which has {percent(battery.soc)} % now."}
    more = f"with {percent(reserve)} % reserve, and it has {percent(battery.soc)} % now"
    return {**row, "text": f"Not enough: it takes {percent(share)} % of the full battery of {robot.name} {more}."}
