"""Roles, what each may do, and the one table that says so."""

from __future__ import annotations

from enum import StrEnum


class Role(StrEnum):
    """What a person is trusted with."""

    VIEWER = "viewer"
    OPERATOR = "operator"
    PLANNER = "planner"
    SUPERVISOR = "supervisor"
    DISPATCHER = "dispatcher"
    ADMIN = "admin"


class Permission(StrEnum):
    """One thing a person may do; asked inside every handler."""

    WATCH = "watch"
    STOP = "stop"
    PAUSE = "pause"
    ABORT = "abort"
    LEASE = "lease"
    TAKE_LEASE = "take_lease"
    START = "start"
    RESUME = "resume"
    RETURN_HOME = "return_home"
    DRIVE = "drive"
    GO_TO = "go_to"
    TOOL = "tool"
    RESET = "reset"
    RESET_FOR_OTHERS = "reset_for_others"
    SEND_MISSION = "send_mission"
    EDIT_MISSION = "edit_mission"
    EDIT_MAP = "edit_map"
    DISPATCH = "dispatch"
    REPLAY = "replay"
    MANAGE_WALLS = "manage_walls"
    ENROL_DEVICE = "enrol_device"
    MANAGE_ROBOTS = "manage_robots"
    MANAGE_NODES = "manage_nodes"
    READ_LOGS = "read_logs"
    RESTART_CAMERA = "restart_camera"
    MANAGE_USERS = "manage_users"
    READ_AUDIT = "read_audit"
    READ_DIAGNOSTICS = "read_diagnostics"
    ACKNOWLEDGE_ALARM = "acknowledge_alarm"
    SHELVE_ALARM = "shelve_alarm"
    MANAGE_ALARMS = "manage_alarms"
    KEEP_PICTURES = "keep_pictures"
    MANAGE_CAMERAS = "manage_cameras"
    MANAGE_SENSORS = "manage_sensors"
    TRIGGER_SENSOR = "trigger_sensor"


_WATCH = frozenset({Permission.WATCH, Permission.STOP, Permission.READ_DIAGNOSTICS})
_OPERATE = _WATCH | {
    Permission.PAUSE,
    Permission.ABORT,
    Permission.LEASE,
    Permission.START,
    Permission.RESUME,
    Permission.RETURN_HOME,
    Permission.DRIVE,
    Permission.GO_TO,
    Permission.TOOL,
    Permission.READ_LOGS,
    Permission.RESTART_CAMERA,
    Permission.RESET,
    Permission.SEND_MISSION,
    Permission.ENROL_DEVICE,
    Permission.ACKNOWLEDGE_ALARM,
    Permission.KEEP_PICTURES,
    Permission.TRIGGER_SENSOR,
}
_SUPERVISE = _OPERATE | {
    Permission.TAKE_LEASE,
    Permission.RESET_FOR_OTHERS,
    Permission.EDIT_MISSION,
    Permission.EDIT_MAP,
    Permission.DISPATCH,
    Permission.MANAGE_WALLS,
    Permission.READ_AUDIT,
    Permission.SHELVE_ALARM,
    Permission.REPLAY,
    Permission.MANAGE_SENSORS,
}

PERMISSIONS: dict[Role, frozenset[Permission]] = {
    Role.VIEWER: _WATCH,
    Role.OPERATOR: _OPERATE,
    Role.PLANNER: _WATCH
    | {Permission.SEND_MISSION, Permission.EDIT_MISSION, Permission.EDIT_MAP, Permission.MANAGE_SENSORS},
    Role.SUPERVISOR: _SUPERVISE,
    Role.DISPATCHER: _OPERATE | {Permission.DISPATCH},
    Role.ADMIN: frozenset(Permission),
}
"""The only table of rights. STOP is in every row: safety.md gives it to everybody who signed in."""


def may(role: Role, permission: Permission) -> bool:
    """Say whether ``role`` includes ``permission``."""
    return permission in PERMISSIONS[role]
