"""Whether it is known how a robot's joints stand; pure."""

from __future__ import annotations

from hmi.domain.freshness import STALE_S
from hmi.domain.robot import Robot


def joints_obstacle(robot: Robot, now_s: float) -> str:
    """Return why it is not known how the declared joints stand; empty where it is, or where none is declared.

    ``now_s`` is on the console's monotonic clock. One joint that is not told is enough: the arm stands elsewhere.
    """
    declared = robot.factsheet.joints if robot.factsheet is not None else ()
    if not declared:
        return ""
    body = robot.body
    if body is None:
        return "Its joints were not heard."
    if now_s - body.stamp.source_s > STALE_S:
        return "Its joints are not heard any more."
    missing = [one.label for one in declared if one.name not in body.joints]
    if not missing:
        return ""
    return "Its joints are not heard." if len(missing) == len(declared) else f"Its joint {missing[0]} is not heard."
