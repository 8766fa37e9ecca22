"""UnmannedAerialVehicle (dataModel.UnmannedAerialVehicle): a robot in the air, now."""

from __future__ import annotations

from datetime import datetime

from hmi.domain.robot import Mode, OrderStatus, Robot
from hmi.fiware.robot import errors_of, own_state
from hmi.fiware.urn import OWN, KeyValues, Urns, moment, point, told

_WORK = {
    OrderStatus.LOADED: "prepare", OrderStatus.RUNNING: "work", OrderStatus.PAUSED: "work",
    OrderStatus.DONE: "finish", OrderStatus.ABORTED: "stop", OrderStatus.FAILED: "stop", OrderStatus.NONE: "stop",
}  # fmt: skip
_HOVER_MPS = 0.2


def uav_entity(urns: Urns, robot: Robot, at: datetime) -> KeyValues:
    """Return a UAV; ``at`` is when its values were true. ``fuel`` is its charge in per cent, speed in m/s."""
    telemetry, state = robot.telemetry, robot.state
    pose = telemetry.pose if telemetry is not None else None
    battery = telemetry.battery if telemetry is not None else None
    order = state.order if state is not None else None
    return told(
        {
            "id": urns.of("UnmannedAerialVehicle", robot.id),
            "type": "UnmannedAerialVehicle",
            "name": robot.name,
            "observedAt": moment(at),
            "operationMode": "vlos" if state is not None and state.mode is Mode.MANUAL else "automated",
            "location": None if pose is None else point(pose.lat_deg, pose.lon_deg),
            "flightStatus": _flight(robot),
            "workStatus": None if state is None else _WORK[order.status if order is not None else OrderStatus.NONE],
            "groundSpeed": None if pose is None else round(abs(pose.speed_mps), 2),
            "fuel": None if battery is None else round(100 * battery.soc, 1),
            OWN: {**own_state(robot), "errors": errors_of(robot)},
        }
    )


def _flight(robot: Robot) -> str | None:
    """Return what it does in the air as far as its states say it, ``None`` if they do not."""
    if robot.state is None or robot.telemetry is None:
        return None
    states = {one.id for one in robot.state.active}
    if not states:
        return None
    if "take-off" in states:
        return "takeoff"
    if states & {"land", "landing"}:
        return "land"
    if not states & {"fly-there", "line", "turn", "leave", "wait"}:
        return "stop"
    return "hover" if abs(robot.telemetry.pose.speed_mps) < _HOVER_MPS else "flight"
