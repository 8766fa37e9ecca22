"""What the robot's state allows, with the reason where it does not; and why it is not moving.

Rights and the lease are no business of this module: the browser adds them.
"""

from __future__ import annotations

from typing import Any

from hmi.domain.command import Action
from hmi.domain.freshness import STALE_S
from hmi.domain.function_use import Uses
from hmi.domain.joint_use import joints_obstacle
from hmi.domain.robot import Mode, OrderStatus, Robot
from hmi.presenters.units import milliseconds
from hmi.presenters.words import HARDWARE_STOP, NO_LINK, NOT_REGISTERED, RESET_FIRST, has_mission, mode_of

Verdict = dict[str, Any]
ACTIONS = (
    "start", "pause", "resume", "later", "fresh", "change", "abort", "return_home", "drive", "reset",
    "go_to", "tool_retract", "tool_go_to", "skip_target", "stock_refilled", "jog", "camera",
)  # fmt: skip
"""The robot's commands, three that send a mission (resume later, start fresh, change the rest), moving joints, and
lamp, zoom and trigger of its cameras."""
_USES = {
    "start": Action.START,
    "resume": Action.RESUME,
    "return_home": Action.RETURN_HOME,
    "drive": Action.DRIVE_OPEN,
    "go_to": Action.GO_TO,
    "tool_retract": Action.TOOL_RETRACT,
    "tool_go_to": Action.TOOL_GO_TO,
}
"""What is off while a function that it uses is off."""
_ACTIVE = (OrderStatus.RUNNING, OrderStatus.PAUSED)
_STARTABLE = (OrderStatus.LOADED, OrderStatus.DONE, OrderStatus.ABORTED, OrderStatus.FAILED)
_MOVED = ("moved_while_paused", "return_home")
"""Hold codes after which a paused mission is started again, not resumed: it is no longer where it stopped."""

_HELPED_BY_RETRACTING = ("crane_limit", "ask_person")
"""Hold codes of a mission at work that goes on after the tool was retracted."""


def actions(robot: Robot) -> dict[str, Verdict]:
    """Return for every action whether the robot's state allows it, and if not, why in one sentence."""
    reasons = {
        "start": _start(robot),
        "pause": _pause(robot),
        "resume": _resume(robot),
        "later": _later(robot),
        "fresh": _fresh(robot),
        "change": _change(robot),
        "abort": _abort(robot),
        "return_home": _return_home(robot),
        "drive": _drive(robot),
        "reset": _reset(robot),
        "go_to": _go_to(robot),
        "tool_retract": _tool_retract(robot),
        "tool_go_to": _tool_go_to(robot),
        "skip_target": _skip_target(robot),
        "stock_refilled": _held(robot),
        "jog": _held(robot),
        "camera": "",
    }
    blocked = _blocked(robot)
    uses = Uses(robot)
    found = {name: blocked or reasons[name] or _lacking(uses, name) for name in ACTIONS}
    return {name: {"ok": not reason, "reason": reason} for name, reason in found.items()}


def why(robot: Robot) -> dict[str, Any] | None:
    """Return why it is not moving, what clears it, who can, and since when; ``None`` if there is nothing to say."""
    found = _why(robot)
    if found is None:
        return None
    code, text, clears, who = found
    return {"code": code, "text": text, "clears": clears, "who": who, "since": _since_ms(robot, code)}


def stands(robot: Robot) -> bool:
    """Say whether its safety controller says now that it stands with its tool off; an old word proves nothing."""
    safety, heard_s = robot.safety, robot.link.heard_s
    if safety is None or heard_s is None or heard_s - safety.stamp.source_s >= STALE_S:
        return False
    return safety.standstill and safety.tool_off


def _blocked(robot: Robot) -> str:
    if not robot.is_registered:
        return NOT_REGISTERED
    return "" if robot.link.is_online and robot.state is not None else NO_LINK


def _lacking(uses: Uses, name: str) -> str:
    """Return which function that it uses is off, and what turns it on."""
    if name == "jog":
        return uses.jog_obstacle()
    if name == "camera":
        return uses.camera_obstacle()
    return uses.obstacle(_USES[name]) if name in _USES else ""


def _held(robot: Robot) -> str:
    """Return why nothing that moves the machine is possible at all."""
    safety = robot.safety
    if safety is None:
        return "Its safety controller was not heard yet."
    if safety.hardware_stop:
        return HARDWARE_STOP
    return RESET_FIRST if safety.latched else ""


def _start(robot: Robot) -> str:
    mode = mode_of(robot)
    if held := _held(robot):
        return held
    if mode is Mode.MANUAL:
        return "End driving by hand first"
    if has_mission(robot, OrderStatus.RUNNING):
        return "The mission is running"
    if mode is Mode.AUTO:
        return "It is moving"
    if mode is Mode.FAULT:
        return "Clear the fault first"
    if has_mission(robot, OrderStatus.PAUSED):
        return "" if _was_moved(robot) else "Resume or abort the paused mission first"
    return "" if has_mission(robot, *_STARTABLE) else "Send a mission first"


def _pause(robot: Robot) -> str:
    mode = mode_of(robot)
    if mode in (Mode.AUTO, Mode.MANUAL):
        return ""
    return {Mode.PAUSED: "It is paused", Mode.STOPPED: "It is stopped"}.get(mode, "Nothing is running")


def _resume(robot: Robot) -> str:
    mode = mode_of(robot)
    if held := _held(robot):
        return held
    if mode is Mode.MANUAL:
        return "End driving by hand first"
    if mode is Mode.FAULT:
        return "Clear the fault first"
    if mode is not Mode.PAUSED or not has_mission(robot, *_ACTIVE):
        return "No paused mission"
    return "It was moved since the pause. Drive it back, or Resume later" if _was_moved(robot) else ""


def _later(robot: Robot) -> str:
    """Whether interrupted work can be taken up again from where it stands."""
    if held := _held(robot):
        return held
    if mode_of(robot) in (Mode.AUTO, Mode.MANUAL):
        return "It must stand still first"
    if has_mission(robot, OrderStatus.PAUSED):
        return "" if _was_moved(robot) else "It stands where it paused. Resume it"
    if not has_mission(robot, OrderStatus.ABORTED, OrderStatus.FAILED) or not is_begun(robot):
        return "No interrupted mission"
    return ""


def _fresh(robot: Robot) -> str:
    """Whether the whole mission can be sent again from its first row."""
    if mode_of(robot) not in (Mode.IDLE, Mode.PAUSED):
        return _held(robot) or "Pause it first"
    is_left = has_mission(robot, OrderStatus.PAUSED, OrderStatus.DONE, OrderStatus.ABORTED, OrderStatus.FAILED)
    return "" if is_left else "No mission to begin again"


def _change(robot: Robot) -> str:
    """Whether the rest of what is under way can be changed."""
    is_running = mode_of(robot) is Mode.AUTO and has_mission(robot, OrderStatus.RUNNING)
    if not is_running and not (mode_of(robot) is Mode.PAUSED and has_mission(robot, OrderStatus.PAUSED)):
        return "No mission under way"
    is_away = has_mission(robot, OrderStatus.PAUSED) and _was_moved(robot)
    return "It was moved since the pause. Resume later brings it back first" if is_away else ""


def is_begun(robot: Robot) -> bool:
    """Say whether something of its mission is done."""
    order = robot.state.order if robot.state is not None else None
    return order is not None and (order.area_done_m2 > 0 or order.row > 0)


def _abort(robot: Robot) -> str:
    is_moving = mode_of(robot) is Mode.AUTO
    return "" if is_moving or has_mission(robot, *_ACTIVE) else "No mission to abort"


def _return_home(robot: Robot) -> str:
    mode = mode_of(robot)
    if held := _held(robot):
        return held
    if mode is Mode.MANUAL:
        return "End driving by hand first"
    return "Clear the fault first" if mode is Mode.FAULT else ""


def _go_to(robot: Robot) -> str:
    return _return_home(robot) or ("Pause it first" if mode_of(robot) is Mode.AUTO else "")


def _tool_retract(robot: Robot) -> str:
    """A mission at work takes it only while it waits for it."""
    if held := _held(robot):
        return held
    hold = robot.state.hold if robot.state is not None else None
    is_waiting = hold is not None and hold.code in _HELPED_BY_RETRACTING
    return "Pause it first" if mode_of(robot) is Mode.AUTO and not is_waiting else ""


def _tool_go_to(robot: Robot) -> str:
    """Nobody sends an arm of which nobody knows how it stands."""
    if held := _held(robot):
        return held
    if mode_of(robot) is Mode.AUTO:
        return "Pause it first"
    return "" if robot.link.heard_s is None else joints_obstacle(robot, robot.link.heard_s)


def _skip_target(robot: Robot) -> str:
    if held := _held(robot):
        return held
    return "" if has_mission(robot, *_ACTIVE) else "No mission under way"


def _drive(robot: Robot) -> str:
    return _held(robot)


def _reset(robot: Robot) -> str:
    safety = robot.safety
    if safety is None or not (safety.latched or safety.hardware_stop):
        return "No stop is active"
    if safety.hardware_stop:
        return HARDWARE_STOP
    return "" if safety.standstill else "Wait until it stands still"


def _was_moved(robot: Robot) -> bool:
    return robot.state is not None and robot.state.hold is not None and robot.state.hold.code in _MOVED


def _why(robot: Robot) -> tuple[str, str, str, str] | None:
    if not robot.is_registered:
        return "not_registered", "It is heard but not registered here.", "Accept it under Admin, Robots.", "admin"
    if not robot.link.is_broker_up:
        return "no_broker", "The server has no link to the robots' broker.", "Start the broker.", "admin"
    if not robot.link.is_online or robot.state is None:
        return "no_link", "It is not heard.", "Look at its power and its radio.", "anybody at the machine"
    return _stopped(robot) or _halted(robot)


def _stopped(robot: Robot) -> tuple[str, str, str, str] | None:
    safety = robot.safety
    if safety is None:
        return None
    if safety.hardware_stop:
        text = "The red button on the machine is pressed."
        return "hardware_stop", text, "Release it at the machine.", "anybody at the machine"
    if not safety.latched:
        return None
    names = " and ".join(dict.fromkeys(p.by for p in safety.presses if not p.is_reset and p.by))
    by = f"{names} pressed STOP." if names else "STOP was pressed."
    clears = "Reset the stop, then resume." if stands(robot) else "Reset the stop when it stands, tool off."
    return "stop_latched", by, clears, "operator"


def _halted(robot: Robot) -> tuple[str, str, str, str] | None:
    state = robot.state
    assert state is not None
    worst = next((f for f in state.faults if f.level in ("critical", "high")), None)
    if state.hold is not None:
        return state.hold.code, state.hold.text, state.hold.clears, state.hold.who
    if state.mode is Mode.FAULT:
        if worst is None:
            return "fault", "It reports a fault.", "Look at its alarms.", "operator"
        return worst.code, worst.text, worst.hint, "operator"
    if state.mode is Mode.PAUSED:
        return "paused", "The mission is paused.", "Slide to resume.", "operator"
    if state.mode is Mode.STOPPED:
        return "stopped", "It is stopped.", "Start or resume the mission.", "operator"
    if state.mode is Mode.IDLE and has_mission(robot, OrderStatus.LOADED):
        return "ready", "The mission is loaded and waits for the start.", "Slide to start.", "operator"
    return None


def _since_ms(robot: Robot, code: str) -> float | None:
    if code == "no_link":
        return milliseconds(robot.link.heard_s)
    if code == "stop_latched" and robot.safety is not None:
        return milliseconds(min((p.pressed_s for p in robot.safety.presses if not p.is_reset), default=None))
    is_of_state = robot.state is not None and code not in ("not_registered", "no_broker", "hardware_stop")
    return milliseconds(robot.state.path_since_s) if robot.state is not None and is_of_state else None
