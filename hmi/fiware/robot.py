"""StateMessage (dataModel.AutonomousMobileRobot): a robot on the ground, now."""

from __future__ import annotations

import math
from datetime import datetime
from typing import Any

from hmi.domain.robot import Gnss, Mode, Order, Robot
from hmi.fiware.urn import OWN, KeyValues, Urns, moment, point, told

MOST_ERRORS = 20


def state_message(urns: Urns, robot: Robot, at: datetime) -> KeyValues:
    """Return a robot that has told where it is; ``at`` is when that was true.

    The schema wants a battery: a robot that tells none has none here, and so does not fit the schema.
    The destination is unknown, since a robot tells how far it is and not where it goes.
    """
    pose = robot.telemetry.pose if robot.telemetry is not None else None
    battery = robot.telemetry.battery if robot.telemetry is not None else None
    return told(
        {
            "id": urns.of("StateMessage", robot.id),
            "type": "StateMessage",
            "name": robot.name,
            "commandTime": moment(at),
            "mode": _mode(robot),
            "errors": errors_of(robot),
            "pose": {} if pose is None else {
                "point2D": {"x": round(pose.x_m, 3), "y": round(pose.y_m, 3)},
                "orientation2D": {"theta": round(pose.theta_rad, 4)},
                "geographicPoint": {
                    "latitude": round(pose.lat_deg, 8), "longitude": round(pose.lon_deg, 8), "altitude": 0.0
                },
            },
            "destination": {},
            "accuracy": _accuracy(robot.telemetry.gnss if robot.telemetry is not None else None),
            "battery": None if battery is None else {"remainingPercentage": round(100 * battery.soc, 1)},
            "location": None if pose is None else point(pose.lat_deg, pose.lon_deg),
            "speed": None if pose is None else round(pose.speed_mps, 2),
            OWN: own_state(robot),
        }
    )  # fmt: skip


def robot_removed(entity: KeyValues) -> KeyValues:
    """Return what is told of a robot that is none of the farm's any more: nothing more will come."""
    return {"id": entity["id"], "type": entity["type"], OWN: {**entity[OWN], "online": False, "removed": True}}


def errors_of(robot: Robot) -> list[str]:
    """Return the robot's faults in its own words."""
    faults = robot.state.faults if robot.state is not None else ()
    return [f"{one.code}: {one.text}"[:200] for one in faults[:MOST_ERRORS]]


def own_state(robot: Robot) -> dict[str, Any]:
    """Return what the models have no place for: mode, state path, stop, mission."""
    state, safety = robot.state, robot.safety
    mode = None if state is None else state.mode.value
    path = None if state is None else list(state.path)
    hold = None if state is None or state.hold is None else state.hold.text
    return told(
        {
            "robot": robot.id,
            "family": None if robot.factsheet is None else str(robot.factsheet.family),
            "online": robot.link.is_online,
            "mode": mode,
            "path": path,
            "hold": hold,
            "stopLatched": None if safety is None else safety.latched,
            "standstill": None if safety is None else safety.standstill,
            "mission": _mission(None if state is None else state.order),
        }
    )


def _mode(robot: Robot) -> str:
    mode = robot.state.mode if robot.state is not None else Mode.UNKNOWN
    is_stopped = robot.safety is not None and (robot.safety.latched or robot.safety.hardware_stop)
    if is_stopped or mode in (Mode.FAULT, Mode.STOPPED):
        return "error"
    return "navi" if mode in (Mode.AUTO, Mode.MANUAL) else "standby"


def _accuracy(gnss: Gnss | None) -> KeyValues:
    """Return the covariance of x and y, row by row, in m2."""
    if gnss is None or not math.isfinite(gnss.accuracy_m):
        return {}
    variance = round(gnss.accuracy_m**2, 6)
    return {"covariance": [variance, 0.0, 0.0, variance]}


def _mission(order: Order | None) -> KeyValues | None:
    if order is None or not order.mission_id:
        return None
    return {
        "id": order.mission_id, "revision": order.revision, "sha256": order.sha256, "status": order.status.value,
        "row": order.row, "rows": order.rows, "areaDone": round(order.area_done_m2, 1),
        "area": round(order.area_m2, 1),
    }  # fmt: skip
