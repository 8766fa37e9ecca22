"""How long until a robot needs a person if nobody acts, from what it reports alone."""

from __future__ import annotations

from hmi.domain.robot import Family, Mode, OrderStatus, Robot
from hmi.presenters.words import has_mission, mode_of

RESERVE: dict[Family, float] = {Family.UAV: 0.3}
USUAL_RESERVE = 0.15  # of the battery: what the queue asks for, too
NOBODY = frozenset({"", "nobody"})  # a hold that clears by itself names nobody
_DRIVES_AWAY = frozenset({"return_home", "start_horn"})
STEP_S = 60.0  # told in whole minutes: a figure that changes each second says nothing more


def help_s(robot: Robot) -> float | None:
    """Return seconds until somebody is needed: 0 when it waits for a person now, ``None`` when that is not known."""
    if waits_for_person(robot):
        return 0.0
    known = [s for s in (_battery_s(robot), _mission_s(robot)) if s is not None]
    return None if not known else max(0.0, min(known) // STEP_S * STEP_S)


def waits_for_person(robot: Robot) -> bool:
    """Say whether it stands and nothing but a person gets it going again."""
    if not robot.is_registered or not robot.link.is_online or robot.state is None:
        return False
    safety, hold = robot.safety, robot.state.hold
    if safety is not None and (safety.latched or safety.hardware_stop):
        return True
    mode = mode_of(robot)
    if mode is Mode.MANUAL:
        return False
    if hold is not None:
        return hold.who not in NOBODY and not (mode is Mode.AUTO and hold.code in _DRIVES_AWAY)
    return mode in (Mode.FAULT, Mode.PAUSED)


def hover_s(robot: Robot) -> float | None:
    """Return how long an aircraft in the air can hold its place until its reserve; ``None`` for others."""
    is_uav = robot.factsheet is not None and robot.factsheet.family is Family.UAV
    is_up = robot.state is not None and robot.state.mode in (Mode.PAUSED, Mode.AUTO, Mode.MANUAL)
    return _battery_s(robot) if is_uav and is_up else None


def _battery_s(robot: Robot) -> float | None:
    battery = robot.telemetry.battery if robot.telemetry is not None else None
    if battery is None or battery.is_charging or battery.remaining_s is None or battery.soc <= 0:
        return None
    family = robot.factsheet.family if robot.factsheet is not None else Family.OTHER
    reserve = RESERVE.get(family, USUAL_RESERVE)
    return max(0.0, battery.remaining_s * (battery.soc - reserve) / battery.soc)


def _mission_s(robot: Robot) -> float | None:
    """A robot that has done its mission waits for the next one."""
    if not has_mission(robot, OrderStatus.RUNNING) or robot.state is None or robot.state.order is None:
        return None
    return robot.state.order.remaining_s
