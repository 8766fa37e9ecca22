"""Why an order is not sent, with the sentence a person reads.

::

    CommandError
    └── OrderRefused     the console did not send the order
"""

from __future__ import annotations

from hmi.domain.command import Action
from hmi.domain.lease import LeaseCode
from hmi.domain.role import Permission

NOT_REGISTERED, UNKNOWN_ROBOT = "not_registered", "unknown_robot"
STALE_TICK, ROBOT_SILENT, NOT_CONNECTED = "stale_tick", "robot_silent", "not_connected"
HELD_BY_OTHER = LeaseCode.HELD_BY_OTHER.value
BUSY, ID_REUSED, LATCHED, REASON_MISSING = "busy", "id_reused", "latched", "reason_missing"
NO_LEASE, NOT_MANUAL, DRIVEN_ELSEWHERE = "no_lease", "not_manual", "driven_elsewhere"
DELAY, DELAY_UNKNOWN, BAD_SETPOINT = "delay", "delay_unknown", "bad_setpoint"
PICTURE_OLD = "picture_old"
NOT_STANDING, OTHER_PRESS, NOTHING_TO_RESET = "not_standing", "other_press", "nothing_to_reset"
NEW_PRESS = "new_press"
UNKNOWN_MISSION, HASH_MISMATCH, HAS_PROGRESS = "unknown_mission", "hash_mismatch", "has_progress"
NO_CLOUD, NO_REVERSE = "no_cloud", "no_reverse"
OTHER_MACHINE, IN_QUEUE = "other_machine", "in_queue"
MAP_CHANGED, NOT_READ_BACK, CHECKLIST_MISSING = "map_changed", "not_read_back", "checklist_missing"
IS_DRAFT = "draft"
IN_FLIGHT_PATH, NOT_NOW = "in_flight_path", "not_now"
HARDWARE_STOP, SAFETY_UNKNOWN, WRONG_MISSION = "hardware_stop", "safety_unknown", "wrong_mission"
LEASE_REVOKED = "lease_revoked"  # the robot's own word, edge.md
STATE_UNKNOWN, OTHER_TARGET, JOINTS_UNKNOWN = "state_unknown", "other_target", "joints_unknown"
FUNCTION_OFF, UNKNOWN_NODE, INCOMPLETE = "function_off", "unknown_node", "incomplete"

ACTION_PERMISSION: dict[Action, Permission] = {
    Action.START: Permission.START,
    Action.RESUME: Permission.RESUME,
    Action.PAUSE: Permission.PAUSE,
    Action.ABORT: Permission.ABORT,
    Action.RETURN_HOME: Permission.RETURN_HOME,
    Action.DRIVE_OPEN: Permission.DRIVE,
    Action.DRIVE_CLOSE: Permission.DRIVE,
    Action.GO_TO: Permission.GO_TO,
    Action.TOOL_RETRACT: Permission.TOOL,
    Action.TOOL_GO_TO: Permission.TOOL,
    Action.SKIP_TARGET: Permission.TOOL,
    Action.STOCK_REFILLED: Permission.TOOL,
    Action.NODE_START: Permission.MANAGE_NODES,
    Action.NODE_STOP: Permission.MANAGE_NODES,
    Action.NODE_RESTART: Permission.MANAGE_NODES,
}
"""Which right each action asks for."""


class CommandError(Exception):
    """Root of the errors of ``hmi.commands``."""


class OrderRefused(CommandError):
    """The console did not send an order.

    Args:
        code: stable machine-readable reason.
        text: one sentence for a person: what, and what to do.
    """

    def __init__(self, code: str, text: str) -> None:
        super().__init__(f"{code}: {text}")
        self.code = code
        self.text = text
