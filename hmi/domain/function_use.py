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
CAMERA = ("take-pictures",)
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


class Uses:
    """What a robot's functions hold back now; judged once, however many orders are asked about.

    Nodes are judged at the robot's newest heartbeat: while it is silent, other rules hold its orders back. Of a robot
    that tells nothing of its nodes nothing can be judged; it decides for itself.
    """

    def __init__(self, robot: Robot) -> None:
        sheet, heard_s = robot.factsheet, robot.link.heard_s
        is_told = sheet is not None and bool(sheet.functions) and bool(sheet.nodes or robot.nodes)
        self._states = evaluate(robot, heard_s) if is_told and heard_s is not None else {}

    @property
    def are_known(self) -> bool:
        """Whether anything is known of what it can do."""
        return bool(self._states)

    def obstacle(self, action: Action) -> str:
        """Return why an order is off because a function it uses is off, with what turns it on; empty if none is."""
        return self._first_off(_USED.get(action, ()))

    def jog_obstacle(self) -> str:
        """Return why the joints cannot be moved by hand; empty if they can."""
        return self._first_off((HAND,))

    def camera_obstacle(self) -> str:
        """Return why its cameras take no orders; empty if they do."""
        return self._first_off((CAMERA,))

    def limited(self) -> FunctionState | None:
        """Return the first function that is limited."""
        return next((one for one in self._states.values() if one.ability is Ability.LIMITED), None)

    def _first_off(self, used: tuple[tuple[str, ...], ...]) -> str:
        for names in used:
            state = next((self._states[name] for name in names if name in self._states), None)
            if state is not None and state.ability is Ability.OFF:
                return sentence(state)
        return ""


def obstacle(robot: Robot, action: Action) -> str:
    """See ``Uses.obstacle``."""
    return Uses(robot).obstacle(action)


def jog_obstacle(robot: Robot) -> str:
    """See ``Uses.jog_obstacle``."""
    return Uses(robot).jog_obstacle()


def camera_obstacle(robot: Robot) -> str:
    """See ``Uses.camera_obstacle``."""
    return Uses(robot).camera_obstacle()


def sentence(state: FunctionState) -> str:
    """Return why a function is off and what turns it on."""
    where = " on Supervisor" if any(one.is_node for one in state.causes) else ""
    return f"{state.info.label} is off: {state.why}. {state.turns_on}{where}."
