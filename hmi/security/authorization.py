"""May this person do this with this robot? Asked inside every handler, for a page may outlive its rights."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from hmi.domain.role import PERMISSIONS, Permission, Role, may
from hmi.security.errors import NotAllowed, NotSignedIn
from hmi.security.session_info import SessionInfo

_DOING: dict[Permission, str] = {
    Permission.WATCH: "Watching",
    Permission.STOP: "Stopping",
    Permission.PAUSE: "Pausing",
    Permission.ABORT: "Aborting",
    Permission.LEASE: "Taking control",
    Permission.TAKE_LEASE: "Taking control from somebody",
    Permission.START: "Starting",
    Permission.RESUME: "Resuming",
    Permission.RETURN_HOME: "Sending it home",
    Permission.DRIVE: "Driving",
    Permission.GO_TO: "Sending it to a place",
    Permission.TOOL: "Moving its tool",
    Permission.RESET: "Resetting a stop",
    Permission.RESET_FOR_OTHERS: "Resetting for somebody else",
    Permission.SEND_MISSION: "Sending a mission",
    Permission.EDIT_MISSION: "Changing missions",
    Permission.EDIT_MAP: "Changing maps",
    Permission.DISPATCH: "Sending a robot out",
    Permission.REPLAY: "Replay",
    Permission.MANAGE_WALLS: "Managing wall screens",
    Permission.ENROL_DEVICE: "Enrolling a tablet",
    Permission.MANAGE_ROBOTS: "Adding and changing robots",
    Permission.MANAGE_NODES: "Restarting nodes",
    Permission.READ_LOGS: "Reading a robot's log",
    Permission.RESTART_CAMERA: "Opening a camera anew",
    Permission.MANAGE_USERS: "Changing people",
    Permission.READ_AUDIT: "Reading the audit log",
    Permission.READ_DIAGNOSTICS: "Reading diagnostics",
    Permission.ACKNOWLEDGE_ALARM: "Acknowledging alarms",
    Permission.SHELVE_ALARM: "Shelving",
    Permission.MANAGE_ALARMS: "Changing alarm settings",
    Permission.KEEP_PICTURES: "Keeping pictures",
    Permission.MANAGE_CAMERAS: "Managing cameras and their pictures",
    Permission.MANAGE_SENSORS: "Changing stations and their limits",
    Permission.TRIGGER_SENSOR: "Taking a picture",
}
_SMALLEST_FIRST = (Role.VIEWER, Role.OPERATOR, Role.PLANNER, Role.DISPATCHER, Role.SUPERVISOR, Role.ADMIN)
_UNREGISTERED_MAY = frozenset(
    {Permission.WATCH, Permission.STOP, Permission.MANAGE_ROBOTS, Permission.READ_DIAGNOSTICS}
)


class KnownRobot(Protocol):
    """What is needed of a registered robot."""

    @property
    def name(self) -> str:
        """Name for people."""
        ...

    @property
    def farm_id(self) -> str:
        """The farm it belongs to."""
        ...


class Authorize(Protocol):
    """The shape of ``Authorizer``, for those who are given one."""

    def __call__(self, session: SessionInfo | None, permission: Permission, robot_id: str | None = None) -> None:
        """See ``Authorizer.__call__``."""
        ...


class Authorizer:
    """Decides by role, farm and registry; an instance is called like a function.

    Args:
        robot_of: returns a registered robot of any farm from memory, ``None`` if it is not registered.
    """

    def __init__(self, robot_of: Callable[[str], KnownRobot | None]) -> None:
        self._robot_of = robot_of

    def __call__(self, session: SessionInfo | None, permission: Permission, robot_id: str | None = None) -> None:
        """Return if allowed.

        Raises:
            NotSignedIn: ``session`` is ``None``.
            NotAllowed: with a sentence that names what is missing.
        """
        if session is None:
            raise NotSignedIn
        robot = None if robot_id is None else self._robot_of(robot_id)
        if robot is not None and robot.farm_id != session.farm_id:
            raise NotAllowed("This robot belongs to another farm.", "other_farm")
        if not may(session.role, permission):
            raise NotAllowed(refusal(session.role, permission, None if robot is None else robot.name))
        if robot_id is not None and robot is None and permission not in _UNREGISTERED_MAY:
            raise NotAllowed("This robot is new here. An admin must accept it first.", "not_registered")


def is_allowed(authorize: Authorize, session: SessionInfo | None, permission: Permission, robot_id: str | None) -> str:
    """Return an empty text if allowed, else the sentence why not: for greying out, never instead of asking."""
    try:
        authorize(session, permission, robot_id)
    except (NotSignedIn, NotAllowed) as error:
        return error.text
    return ""


def refusal(role: Role, permission: Permission, robot_name: str | None) -> str:
    """Word a refusal: what one may do, what not, and who could."""
    needed = next(one for one in _SMALLEST_FIRST if permission in PERMISSIONS[one])
    sentence = f"{_DOING[permission]} needs the {needed.value} role."
    if robot_name is None or not may(role, Permission.WATCH):
        return sentence
    return f"You can watch {robot_name}. {sentence}"
