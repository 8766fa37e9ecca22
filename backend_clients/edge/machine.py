"""The machine inside a robot as edge contract v1 tells it: joints, gauges, nodes, state chart, site, scan.

Positions are ENU metres of the factsheet's datum, heights above the ground at the datum.
"""

from __future__ import annotations

from typing import Annotated, Literal

from msgspec import Meta, Struct, field

from backend_clients.edge.fields import Count, Header, Id, Metres, Name, Positive, Share, Text

MAX_SCAN_POINTS = 4000
MAX_BOXES = 128
Point3 = tuple[Metres, Metres, Metres]


class Joint(Struct, frozen=True, kw_only=True):
    """A moving joint with its limits, radians or metres; beyond a soft limit it warns and slows."""

    name: Name
    lower: float
    upper: float
    max_rate: Positive
    label: Name = ""
    unit: Literal["rad", "m"] = "rad"
    soft_lower: float | None = None
    soft_upper: float | None = None


class GaugeInfo(Struct, frozen=True, kw_only=True):
    """A value the machine measures, such as a pressure: its scale and where it is normal."""

    key: Id
    label: Name
    unit: Name
    lower: float
    upper: float
    ok_lower: float | None = None
    ok_upper: float | None = None
    limit_text: Name = ""


class NodeInfo(Struct, frozen=True, kw_only=True):
    """A software node the robot has: its usual rate, and which nodes must be started before it.

    ``period_ms`` is what its reports will say of themselves, for the time before the first one.
    """

    name: Id
    label: Name
    subsystem: Name = ""
    rate_hz: Positive | None = None
    starts_after: list[Id] = field(default_factory=list)
    period_ms: Annotated[int, Meta(ge=100, le=600_000, description="longest time between two reports")] | None = None


class ChartState(Struct, frozen=True, kw_only=True):
    """One state of the supervisor. The children of a ``parallel`` state are its regions, all active at once."""

    id: Id
    label: Name
    parent: Id | None = None
    kind: Literal["simple", "composite", "parallel", "region", "final"] = "simple"
    is_initial: bool = False
    subsystem: Name = ""
    normal_s: Annotated[Positive, Meta(description="usual time in it")] | None = None
    entry: Annotated[list[Text], Meta(max_length=16)] = field(default_factory=list)
    exit: Annotated[list[Text], Meta(max_length=16)] = field(default_factory=list)


class ChartTransition(Struct, frozen=True, kw_only=True):
    """A change of state: what causes it and what must be true."""

    source: Id
    target: Id
    event: Name
    guard: Text = ""


class Chart(Struct, frozen=True, kw_only=True):
    """The robot's supervisor as data; the console draws whatever is declared."""

    states: Annotated[list[ChartState], Meta(min_length=1, max_length=400)]
    transitions: Annotated[list[ChartTransition], Meta(max_length=2000)] = field(default_factory=list)


class ActiveState(Struct, frozen=True, kw_only=True):
    """A state of the chart that is active, and since when by ``mono_ms``."""

    id: Id
    since_ms: Count


class LastTransition(Struct, frozen=True, kw_only=True):
    """The newest change of state, by ``mono_ms``; ``result`` is the code of the action that ended."""

    source: Id
    target: Id
    event: Name
    result: Name = ""
    at_ms: Count


class Sighting(Struct, frozen=True, kw_only=True):
    """Somebody or something the robot sees near itself."""

    id: Id
    kind: Literal["person", "animal", "vehicle", "object"]
    x_m: Metres
    y_m: Metres
    distance_m: Positive


class Body(Header, frozen=True, kw_only=True):
    """10 Hz while it moves, 2 Hz at rest, QoS 0: measured joints, the planned ones, gauges, who is near.

    ``tool`` is where the tool's tip is; ``planned`` holds the pose the joints are on their way to.
    """

    joints: dict[Name, float] = field(default_factory=dict)
    planned: dict[Name, float] = field(default_factory=dict)
    gauges: dict[Id, float] = field(default_factory=dict)
    tool: Point3 | None = None
    is_loaded: bool | None = None
    stock: Annotated[Count, Meta(description="seedlings or the like left")] | None = None
    seen: Annotated[list[Sighting], Meta(max_length=32)] = field(default_factory=list)


class Obstacle(Struct, frozen=True, kw_only=True):
    """A stump, stone or the like, as a standing cylinder."""

    id: Id
    kind: Name
    x_m: Metres
    y_m: Metres
    radius_m: Positive
    height_m: Positive


class Target(Struct, frozen=True, kw_only=True):
    """A place to work at, and what became of it."""

    id: Id
    x_m: Metres
    y_m: Metres
    status: Literal["planned", "current", "done", "failed_tool", "failed_ground", "failed_machine", "skipped"]
    text: Text = ""


class Worksite(Header, frozen=True, kw_only=True):
    """Retained, QoS 1, at each change: where it works now. A new ``stop`` begins with an empty surface."""

    stop: Count
    area: Annotated[list[tuple[Metres, Metres]], Meta(max_length=64)] = field(default_factory=list)
    obstacles: Annotated[list[Obstacle], Meta(max_length=256)] = field(default_factory=list)
    targets: Annotated[list[Target], Meta(max_length=256)] = field(default_factory=list)


class Scan(Header, frozen=True, kw_only=True):
    """At most 1 Hz, QoS 0: a point cloud. ``points`` is base64 of little-endian int16 x, y, z in centimetres
    from ``origin``; at most ``MAX_SCAN_POINTS``.
    """

    origin: Point3
    points: Annotated[str, Meta(max_length=MAX_SCAN_POINTS * 8)]


class Box(Struct, frozen=True, kw_only=True):
    """Something found in a picture, in shares of it from its upper left corner.

    ``hit``: whether the tool hit it; left out or null where it was not there yet, or has none.
    """

    kind: Id
    x: Share
    y: Share
    w: Share
    h: Share
    score: Share = 1.0
    hit: bool | None = None


class Detections(Header, frozen=True, kw_only=True):
    """At most 2 Hz a camera, QoS 0, only while its pictures are fetched: what was found in one of them.

    ``mono_ms`` is when that picture was taken, ``captured_ms`` the same by the wall clock, as the picture says.
    """

    camera: Id
    captured_ms: int
    boxes: Annotated[list[Box], Meta(max_length=MAX_BOXES)] = field(default_factory=list)
