"""What the console knows about one robot, each part with the time it was true.

SI and radians. Every part is replaced as a whole and carries a ``Stamp``; a missing part is ``None``,
never a zero. Times are on the console's monotonic clock (``Clock.mono_s``).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from hmi.domain import family, stamp
from hmi.domain.camera import CameraInfo
from hmi.domain.machine import Body, FunctionInfo, GaugeInfo, JointInfo, NodeInfo, Sight, Worksite
from hmi.domain.state_chart import ActiveState, Chart, LastTransition

Family = family.Family
Stamp = stamp.Stamp


class Mode(StrEnum):
    """Who moves the machine, as the robot reports it."""

    AUTO = "auto"
    MANUAL = "manual"
    PAUSED = "paused"
    STOPPED = "stopped"
    IDLE = "idle"
    FAULT = "fault"
    UNKNOWN = "unknown"


class OrderStatus(StrEnum):
    """What the robot says about its mission."""

    NONE = "none"
    LOADED = "loaded"
    RUNNING = "running"
    PAUSED = "paused"
    DONE = "done"
    ABORTED = "aborted"
    FAILED = "failed"


@dataclass(frozen=True, slots=True)
class Pose:
    """Position and motion. ``theta_rad`` is ENU yaw, 0 east, counter-clockwise."""

    lat_deg: float
    lon_deg: float
    x_m: float
    y_m: float
    theta_rad: float
    speed_mps: float
    yaw_rate_radps: float
    stamp: Stamp


@dataclass(frozen=True, slots=True)
class Gnss:
    """Quality of the fix: none, single, float or fixed."""

    fix: str
    accuracy_m: float
    satellites: int
    correction_age_s: float | None


@dataclass(frozen=True, slots=True)
class Battery:
    """State of charge 0..1 and the time left at the present load."""

    soc: float
    remaining_s: float | None
    is_charging: bool


@dataclass(frozen=True, slots=True)
class ToolState:
    """The implement now: off, armed, on or fault."""

    state: str
    is_interlock_ok: bool
    rate_per_min: float | None
    temperature_c: float | None


@dataclass(frozen=True, slots=True)
class Telemetry:
    """Fast values; any of them may be missing."""

    pose: Pose
    gnss: Gnss | None
    battery: Battery | None
    tool: ToolState | None
    cross_track_m: float | None
    obstacle_m: float | None


@dataclass(frozen=True, slots=True)
class Order:
    """Progress of the mission on the robot; rows count from 1."""

    mission_id: str
    revision: int
    sha256: str
    status: OrderStatus
    row: int
    rows: int
    segment: int
    segment_s_m: float
    area_m2: float
    area_done_m2: float
    distance_m: float
    remaining_s: float | None
    is_supervised: bool


@dataclass(frozen=True, slots=True)
class Fault:
    """An active error as the robot words it; level is critical, high, medium or low."""

    code: str
    level: str
    text: str
    hint: str


@dataclass(frozen=True, slots=True)
class Hold:
    """Why it is not moving, what clears it, who can."""

    code: str
    text: str
    clears: str
    who: str


@dataclass(frozen=True, slots=True)
class RobotState:
    """Operating state. ``path_since_s`` is on the console's monotonic clock."""

    mode: Mode
    path: tuple[str, ...]
    path_since_s: float
    lease_token: int
    set_speed_mps: float | None
    order: Order | None
    faults: tuple[Fault, ...]
    hold: Hold | None
    stamp: Stamp
    active: tuple[ActiveState, ...] = ()
    last_transition: LastTransition | None = None


@dataclass(frozen=True, slots=True)
class Press:
    """One STOP press latched by the robot."""

    stop_id: str
    by: str
    device: str
    pressed_s: float
    is_reset: bool


@dataclass(frozen=True, slots=True)
class SafetyState:
    """What the robot's safety controller says."""

    hardware_stop: bool
    latched: bool
    standstill: bool
    speed_mps: float
    tool_off: bool
    presses: tuple[Press, ...]
    stopping_distance_m: float | None
    stamp: Stamp


@dataclass(frozen=True, slots=True)
class Node:
    """Life cycle of one software node (U6), reported at least each ``period_s``."""

    name: str
    state: str
    rate_hz: float | None
    cpu_pct: float | None
    restarts: int
    text: str
    stamp: Stamp
    host: str = ""
    since_s: float | None = None
    clock_offset_s: float | None = None
    period_s: float = 5.0


@dataclass(frozen=True, slots=True)
class Factsheet:
    """What the robot says it is; numbers in SI. Times of its own behaviour are ``None`` where it tells none."""

    family: Family
    name: str
    model: str
    software: str
    datum_lat_deg: float
    datum_lon_deg: float
    length_m: float
    width_m: float
    height_m: float
    base_to_front_m: float
    track_m: float
    max_speed_mps: float
    max_accel_mps2: float
    decel_mps2: float
    max_yaw_rate_radps: float
    turning_radius_m: float
    can_reverse: bool
    can_pivot: bool
    tool_kind: str
    tool_label: str
    tool_width_m: float
    drive_deadman_s: float | None
    operator_lost_pause_s: float | None
    link_lost_pause_s: float | None
    start_horn_s: float | None
    keep_out_m: float
    stop_effect: str
    functions: tuple[FunctionInfo, ...] = ()
    nodes: tuple[NodeInfo, ...] = ()
    joints: tuple[JointInfo, ...] = ()
    gauges: tuple[GaugeInfo, ...] = ()
    chart: Chart | None = None
    cameras: tuple[CameraInfo, ...] = ()
    battery_wh: float | None = None
    charge_w: float | None = None
    path_reverse_mps: float | None = None
    """Speed at which it follows a path backwards in a turn; ``None``: never."""
    path_height_m: float | None = None
    """Height above the ground at which it flies all of a mission's path; ``None``: it does not say, or drives."""
    skips_by_name: bool = False
    """Whether it understands which point an order to skip is about."""


@dataclass(frozen=True, slots=True)
class LinkHealth:
    """How well the robot is heard.

    ``heard_s`` is when the newest heartbeat was true; ``rtt_s`` the console-robot round trip, measured at
    ``rtt_at_s``; ``rtt_max_s`` the largest of the last minute. ``wall_offset_s`` is how far its wall
    clock is ahead of ours. ``said_goodbye``: it was shut down in order and told so, as opposed to lost.
    """

    is_online: bool
    heard_s: float | None
    challenge: str | None
    challenge_s: float | None
    boot: str | None
    rtt_s: float | None
    rtt_max_s: float | None
    is_broker_up: bool
    rtt_at_s: float | None = None
    wall_offset_s: float | None = None
    said_goodbye: bool = False


@dataclass(frozen=True, slots=True)
class Robot:
    """All that is known of one robot. ``is_registered`` false: shown, never operated."""

    id: str
    is_registered: bool
    name: str
    farm_id: str
    link: LinkHealth
    factsheet: Factsheet | None = None
    telemetry: Telemetry | None = None
    state: RobotState | None = None
    safety: SafetyState | None = None
    nodes: dict[str, Node] = field(default_factory=dict)
    body: Body | None = None
    worksite: Worksite | None = None
    sights: Mapping[str, Sight] = field(default_factory=dict)
