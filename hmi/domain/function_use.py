"""Which function of a robot an order uses, by the names docs/nodes.md gives them; pure.

A robot that declares no function of these names is not held back by any.
"""

from __future__ import annotations

from hmi.domain.command import Action
from hmi.domain.functions import Ability, FunctionState, evaluate
from hmi.domain.robot import Robot

WORK = ("treat", "plant", "search", "work")
PATH = ("follow-path",)
DRIVE = ("manual-drive",)
TOOL = ("move-tool", "move-crane")
HAND = ("manual-tool", "manual-crane", *TOOL)
"""Joints moved by hand; a robot that tells only of its tool as a whole is asked about that."""

_USED: dict[Action, tuple[tuple[str, ...], ...]] = {
    Action.START: (WORK, PATH),
    Action.RESUME: (WORK, PATH),
    Action.RETURN_HOME: (PATH,),
    Action.GO_TO: (PATH,),
    Action.DRIVE_OPEN: (DRIVE,),
    Action.TOOL_RETRACT: (TOOL,),
    Action.TOOL_GO_TO: (TOOL,),
}


def obstacle(robot: Robot, action: Action) -> str:
    """Return why an order is off because a function it uses is off, one sentence or two; empty if none is.

    Nodes are judged at the robot's newest heartbeat: while it is silent, other rules hold its orders back.
    """
    return _first_off(robot, _USED.get(action, ()))


def jog_obstacle(robot: Robot) -> str:
    """Return why the joints cannot be moved by hand; empty if they can."""
    return _first_off(robot, (HAND,))


def sentence(state: FunctionState) -> str:
    """Return why a function is off and what turns it on."""
    where = " on Supervisor" if any(one.is_node for one in state.causes) else ""
    return f"{state.info.label} is off: {state.why}. {state.turns_on}{where}."


def _first_off(robot: Robot, used: tuple[tuple[str, ...], ...]) -> str:
    if not used or robot.factsheet is None or not robot.factsheet.functions or robot.link.heard_s is None:
        return ""
    states = evaluate(robot, robot.link.heard_s)
    for names in used:
        state = next((states[name] for name in names if name in states), None)
        if state is not None and state.ability is Ability.OFF:
            return sentence(state)
    return ""
