"""The words of the operate and fleet screens: modes, machines, what to do."""

from __future__ import annotations

from hmi.domain.robot import Family, Mode, OrderStatus, Robot

KINDS = {
    Family.WEEDER: "Laser weeder",
    Family.PLANTER: "Tree planter",
    Family.UAV: "Drone",
    Family.OTHER: "Robot",
}
TOOLS = {Family.WEEDER: "Laser", Family.PLANTER: "Crane", Family.UAV: "Payload", Family.OTHER: "Tool"}
TOOL_STATES = {"on": "On", "armed": "Armed", "off": "Off", "fault": "Fault"}
FAULT_LEVELS = {"critical": 1, "high": 2, "medium": 3, "low": 4}

RESET_FIRST = "Reset the stop first"
NO_LINK = "Commands are off until the link is back."
NOT_REGISTERED = "It is not registered here. An admin can accept it."
HARDWARE_STOP = "Hardware button is pressed on the machine. Release it there first."

_MODE_TEXT = {
    Mode.MANUAL: "Driven by hand",
    Mode.PAUSED: "Paused",
    Mode.STOPPED: "Stopped",
    Mode.FAULT: "Fault",
    Mode.UNKNOWN: "Not heard yet",
}
_IDLE_TEXT = {
    OrderStatus.LOADED: "Ready to start",
    OrderStatus.DONE: "Mission done",
    OrderStatus.ABORTED: "Mission aborted",
    OrderStatus.FAILED: "Mission failed",
}


def mode_of(robot: Robot) -> Mode:
    """Return the mode to show: a latched or pressed stop wins over what the operating state says."""
    if robot.safety is not None and (robot.safety.latched or robot.safety.hardware_stop):
        return Mode.STOPPED
    return robot.state.mode if robot.state is not None else Mode.UNKNOWN


def mode_text(robot: Robot) -> str:
    """Return one or two words beside the mode chip."""
    mode = mode_of(robot)
    if mode is Mode.STOPPED and robot.safety is not None:
        if robot.safety.hardware_stop:
            return "Button pressed"
        return "Latched" if robot.safety.latched else "Stopped"
    if mode is Mode.AUTO:
        return "Running" if has_mission(robot, OrderStatus.RUNNING) else _innermost(robot, "Automatic")
    if mode is Mode.IDLE:
        status = robot.state.order.status if robot.state and robot.state.order else OrderStatus.NONE
        return _IDLE_TEXT.get(status, "Ready")
    return _MODE_TEXT[mode]


def has_mission(robot: Robot, *statuses: OrderStatus) -> bool:
    """Say whether the robot's mission is in one of these states."""
    return robot.state is not None and robot.state.order is not None and robot.state.order.status in statuses


def kind_label(robot: Robot) -> str:
    """Return what kind of machine it is, in plain words."""
    return KINDS[robot.factsheet.family if robot.factsheet else Family.OTHER]


def tool_label(robot: Robot) -> str:
    """Return what its implement is called."""
    if robot.factsheet is None:
        return TOOLS[Family.OTHER]
    return robot.factsheet.tool_label or TOOLS[robot.factsheet.family]


def _innermost(robot: Robot, otherwise: str) -> str:
    return robot.state.path[-1] if robot.state is not None and robot.state.path else otherwise
