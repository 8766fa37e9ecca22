"""What a robot says: the upward half of edge contract v1.

All lengths in metres, speeds in m/s, angles in radians, times in milliseconds unless the name
says otherwise. ``mono_ms`` is the robot's own monotonic clock since boot: ages are computed from it,
never from wall clocks, which may be hours apart. Readers ignore fields they do not know.

Source of the shape: VDA 5050 (header, order progress, action states, error levels, presence by last
will, operating mode), with WGS84 positions and a declared ENU datum instead of a plant map.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from msgspec import Meta, Struct, field

from backend_clients.edge import fields
from backend_clients.edge.fields import (
    Count,
    Id,
    LatDeg,
    Level,
    LonDeg,
    Metres,
    Mode,
    Name,
    NodeState,
    OrderStatus,
    Positive,
    Radians,
    Share,
    Text,
)
from backend_clients.edge.machine import ActiveState, Chart, GaugeInfo, Joint, LastTransition, NodeInfo

Header = fields.Header


class Presence(Header, frozen=True, kw_only=True):
    """Retained; the last will says ``online: false``. Presence, never safety: it comes late."""

    online: bool
    reason: Literal["online", "shutdown", "lost"] = "online"


class Datum(Struct, frozen=True, kw_only=True):
    """WGS84 origin of the robot's ENU frame: x east, y north."""

    lat_deg: LatDeg
    lon_deg: LonDeg
    height_m: Metres = 0.0


class Dimensions(Struct, frozen=True, kw_only=True):
    """Outline of the machine, in metres, with the reference point ``base``."""

    length_m: Positive
    width_m: Positive
    height_m: Positive
    base_to_front_m: Positive
    track_m: Positive = 0.0


class Limits(Struct, frozen=True, kw_only=True):
    """Motion limits of the machine."""

    max_speed_mps: Positive
    max_accel_mps2: Positive
    decel_mps2: Annotated[float, Meta(gt=0, le=100, description="braking on STOP")]
    max_yaw_rate_radps: Positive
    turning_radius_m: Positive = 0.0
    can_reverse: Annotated[bool, Meta(description="driven by hand")] = True
    can_pivot: bool = False
    path_reverse_mps: (
        Annotated[float, Meta(gt=0, le=20, description="speed at which it follows a path backwards; left out: never")]
        | None
    ) = None
    path_height_m: (
        Annotated[
            float,
            Meta(gt=0, le=500, description="UAVs: height above the ground at which it flies all of a mission's path"),
        ]
        | None
    ) = None


class Tool(Struct, frozen=True, kw_only=True):
    """The implement: what it is and how wide it works."""

    kind: Id
    label: Name
    width_m: Positive


class CameraPtz(Struct, frozen=True, kw_only=True):
    """What turns a camera: joints by name, and the zoom's smallest and largest factor."""

    pan: Id | None = None
    tilt: Id | None = None
    zoom: tuple[Positive, Positive] | None = None


class Camera(Struct, frozen=True, kw_only=True):
    """A camera on the robot; where its pictures come from is in the registry, not here."""

    id: Id
    label: Name
    width_px: Count
    height_px: Count
    kind: Literal["colour", "infrared", "depth"] = "colour"
    fps: Annotated[float, Meta(gt=0, le=120)] = 15.0
    view: Literal["front", "rear", "tool", "head", "nadir", "distance"] = "front"
    fov_deg: Annotated[float, Meta(gt=0, le=360, description="horizontal")] | None = None
    ptz: CameraPtz | None = None
    has_lamp: bool = False
    has_trigger: bool = False


class Function(Struct, frozen=True, kw_only=True):
    """Something the robot can do, and the nodes and functions it needs for it (U7).

    Without one of ``depends_on`` it is off; without one of ``better_with`` it is limited.
    """

    name: Id
    label: Name
    depends_on: list[Id] = field(default_factory=list)
    better_with: list[Id] = field(default_factory=list)


class Behaviour(Struct, frozen=True, kw_only=True):
    """What the robot says it does by itself. The console quotes it and marks it not verified."""

    drive_deadman_s: Positive = 0.5
    operator_lost_pause_s: Positive = 3.5
    link_lost_pause_s: Positive = 10.0
    start_horn_s: Positive = 3.0
    keep_out_m: Positive = 15.0
    stop_effect: Name = ""


class BatteryPack(Struct, frozen=True, kw_only=True):
    """The energy on board when full, and how fast it is charged at its usual place."""

    capacity_wh: Annotated[float, Meta(gt=0, le=1e7)]
    charge_w: Annotated[float, Meta(gt=0, le=1e7)] | None = None


class Factsheet(Header, frozen=True, kw_only=True):
    """Retained; who the robot is and what it can do."""

    family: Literal["weeder", "planter", "uav", "other"]
    name: Name
    model: Name
    software: Name
    datum: Datum
    dimensions: Dimensions
    limits: Limits
    tool: Tool | None = None
    battery: BatteryPack | None = None
    cameras: list[Camera] = field(default_factory=list)
    joints: list[Joint] = field(default_factory=list)
    gauges: Annotated[list[GaugeInfo], Meta(max_length=32)] = field(default_factory=list)
    nodes: Annotated[list[NodeInfo], Meta(max_length=64)] = field(default_factory=list)
    functions: list[Function] = field(default_factory=list)
    chart: Chart | None = None
    behaviour: Annotated[Behaviour | None, Meta(description="left out: nothing is quoted")] = None
    skips_by_name: Annotated[bool, Meta(description="understands the target of skip_target; left out: no")] = False


class Heartbeat(Header, frozen=True, kw_only=True):
    """5 Hz, QoS 0. Enabling commands must echo the newest ``challenge``."""

    challenge: Annotated[str, Meta(min_length=8, max_length=64)]
    echo_nonce: Annotated[str, Meta(max_length=64)] | None = None
    echo_held_ms: Annotated[Positive, Meta(description="how long the robot held the ping")] = 0.0


class Gnss(Struct, frozen=True, kw_only=True):
    """Quality of the position fix."""

    fix: Literal["none", "single", "float", "fixed"]
    accuracy_m: Positive
    satellites: Count = 0
    correction_age_s: Positive | None = None


class Battery(Struct, frozen=True, kw_only=True):
    """State of charge and what is left of it at the present load."""

    soc: Share
    remaining_s: Positive | None = None
    charging: bool = False


class ToolState(Struct, frozen=True, kw_only=True):
    """What the implement does now."""

    state: Literal["off", "armed", "on", "fault"]
    interlock_ok: bool = True
    rate_per_min: Positive | None = None
    temperature_c: Annotated[float, Meta(ge=-100, le=1000)] | None = None


class Telemetry(Header, frozen=True, kw_only=True):
    """10 Hz, QoS 0; only the newest counts."""

    lat_deg: LatDeg
    lon_deg: LonDeg
    x_m: Metres
    y_m: Metres
    theta_rad: Annotated[Radians, Meta(description="ENU yaw: 0 is east, counter-clockwise")]
    speed_mps: Annotated[float, Meta(ge=-100, le=100, description="along the machine's nose")]
    yaw_rate_radps: Radians = 0.0
    gnss: Gnss | None = None
    battery: Battery | None = None
    tool: ToolState | None = None
    cross_track_m: Annotated[Metres, Meta(description="left of the path is positive")] | None = None
    obstacle_m: Positive | None = None


class OrderState(Struct, frozen=True, kw_only=True):
    """Progress of the mission on the robot. Rows count from 1; 0 means before the first."""

    mission_id: Id
    revision: Count
    sha256: Annotated[str, Meta(pattern="^[0-9a-f]{64}$")]
    status: OrderStatus
    row: Count = 0
    rows: Count = 0
    segment: Count = 0
    segment_s_m: Positive = 0.0
    area_m2: Positive = 0.0
    area_done_m2: Positive = 0.0
    distance_m: Positive = 0.0
    remaining_s: Positive | None = None
    is_supervised: bool = True


class ActionState(Struct, frozen=True, kw_only=True):
    """What became of a command, VDA 5050 style."""

    command_id: Annotated[str, Meta(max_length=64)]
    action: Id
    status: Literal["waiting", "running", "finished", "failed"]
    text: Text = ""


class Fault(Struct, frozen=True, kw_only=True):
    """An active error: code, level, what it means and what clears it."""

    code: Id
    level: Level
    text: Text
    hint: Text = ""


class Hold(Struct, frozen=True, kw_only=True):
    """Why the robot is not moving now, what clears it and who can."""

    code: Id
    text: Text
    clears: Text = ""
    who: Name = ""


class State(Header, frozen=True, kw_only=True):
    """2 Hz and at every change, QoS 1."""

    mode: Mode
    path: Annotated[list[Name], Meta(max_length=12, description="active supervisor states, outer first")]
    path_since_ms: Annotated[Count, Meta(description="mono_ms when the innermost state was entered")]
    lease_token: Count = 0
    set_speed_mps: Positive | None = None
    order: OrderState | None = None
    actions: Annotated[list[ActionState], Meta(max_length=32)] = field(default_factory=list)
    faults: Annotated[list[Fault], Meta(max_length=64)] = field(default_factory=list)
    hold: Hold | None = None
    active: Annotated[
        list[ActiveState], Meta(max_length=64, description="every active state of the chart, outer first")
    ] = field(default_factory=list)
    last_transition: LastTransition | None = None


class Press(Struct, frozen=True, kw_only=True):
    """One STOP press that the robot has latched."""

    stop_id: Annotated[str, Meta(min_length=8, max_length=64)]
    by: Name
    device: Name = ""
    mono_ms: Count
    is_reset: bool = False


class Safety(Header, frozen=True, kw_only=True):
    """5 Hz, 10 Hz while stopping, and at every change; QoS 0 and 1 mixed, idempotent.

    ``standstill`` is true only when motion was zero for 0.5 s and the tool is off.
    """

    hardware_stop: bool
    latched: bool
    standstill: bool
    speed_mps: Annotated[float, Meta(ge=0, le=100)]
    tool_off: bool
    presses: Annotated[list[Press], Meta(max_length=64)] = field(default_factory=list)
    stopping_distance_m: Positive | None = None


class Event(Header, frozen=True, kw_only=True):
    """QoS 1, never conflated; ``event_id`` makes duplicates harmless."""

    event_id: Annotated[str, Meta(min_length=8, max_length=64)]
    kind: Literal["state_entered", "state_left", "alarm_raised", "alarm_cleared", "treatment", "mission", "safety"]
    name: Name
    text: Text = ""
    data: dict[str, Any] = field(default_factory=dict)


class Node(Header, frozen=True, kw_only=True):
    """Life cycle of one software node on the robot (U6); retained per change, at least each ``period_ms``."""

    name: Id
    state: NodeState
    rate_hz: Positive | None = None
    cpu_pct: Positive | None = None
    restarts: Count = 0
    text: Text = ""
    host: Name = ""
    since_ms: Annotated[Count, Meta(description="mono_ms when this state of its life began")] | None = None
    clock_offset_ms: Annotated[float, Meta(ge=-1e9, le=1e9, description="its clock ahead of the robot's")] | None = None
    period_ms: Annotated[int, Meta(ge=100, le=600_000, description="longest time between two reports")] = 5000


class Ack(Header, frozen=True, kw_only=True):
    """Answer to one downward message. Every refusal has a code and a sentence."""

    kind: Literal["command", "stop", "stop-reset", "mission", "drive"]
    ref: Annotated[str, Meta(max_length=64, description="id of the message answered")]
    outcome: Literal["accepted", "rejected"]
    code: Id = "ok"
    text: Text = ""
    speed_mps: Annotated[float, Meta(ge=0, le=100)] | None = None
    sha256: Annotated[str, Meta(pattern="^[0-9a-f]{64}$")] | None = None
