"""What the drawing process is told: the ground around a robot, and a look at one moment. ENU metres, radians."""

from __future__ import annotations

from msgspec import Struct, field

Point = tuple[float, float]
Line = tuple[float, float, float, float]


class Rows(Struct, frozen=True, array_like=True):
    """How crop stands in a field: rows ``spacing_m`` apart along ``bearing_rad``, one of them through ``anchor``.

    Rows along a curve are told near one place: ``anchor`` is then ``at`` so far along and across the rows, which run
    along ``bearing_rad`` there and bend to the left by ``bend_1pm``, with their first at 0 across.
    """

    crop: str
    spacing_m: float
    bearing_rad: float
    anchor: Point
    bend_1pm: float = 0.0
    at: Point = (0.0, 0.0)


class Ground(Struct, frozen=True, array_like=True):
    """A surface on the map: ``kind`` is field, road, yard, water, grass or forest; ``rows`` where crop grows.

    ``is_bent``: how its rows lie where the machine is comes with each look.
    """

    kind: str
    ring: list[Point]
    rows: Rows | None = None
    is_bent: bool = False


class Solid(Struct, frozen=True, array_like=True):
    """What stands on the ground: building, hedge, tree, pylon, stone, post; ``ring`` is its foot."""

    kind: str
    ring: list[Point]
    height_m: float


class Scene(Struct, frozen=True, array_like=True):
    """Everything that stays; ``key`` changes with its content. Later grounds lie on earlier ones."""

    key: str
    lat_deg: float
    lon_deg: float
    grounds: list[Ground] = field(default_factory=list)
    solids: list[Solid] = field(default_factory=list)


class Thing(Struct, frozen=True, array_like=True):
    """Something that may move or be gone: weeder, planter, uav, person, stump, stone; tree and its outcome."""

    kind: str
    x_m: float
    y_m: float
    theta_rad: float = 0.0
    z_m: float = 0.0
    height_m: float = 0.0
    radius_m: float = 0.0
    state: str = ""


class Crane(Struct, frozen=True, array_like=True):
    """A crane: the ENU places of its pillar's top, boom's end, stick's end and tip, and what its head does."""

    joints: list[tuple[float, float, float]]
    heading_rad: float = 0.0
    is_loaded: bool = False
    state: str = ""


class Look(Struct, frozen=True, array_like=True):
    """One picture to be drawn.

    ``treated`` are the stretches the tool has worked, ``trail`` the way behind the machine, newest point first.
    ``sun_ms``: the moment whose daylight it is, ``None`` for that of the wall clock.
    ``lamp``: ``None`` is by itself, on when it is dark. ``age_of_shot_s``: since a picture was triggered.
    ``is_hasty``: somebody waits for a first picture; plants nobody has drawn yet may be as coarse as from afar.
    ``rows``: how rows along a curve lie near the machine.
    """

    scene: str
    robot: str
    camera: str
    family: str
    width_px: int
    height_px: int
    wall_ms: int
    x_m: float
    y_m: float
    theta_rad: float
    z_m: float = 0.0
    lean_rad: float = 0.0
    pan_rad: float = 0.0
    tilt_rad: float = 0.0
    zoom: float = 1.0
    lamp: bool | None = None
    age_of_shot_s: float = 1e9
    is_tool_on: bool = False
    is_unsure: bool = False
    treated: list[Line] = field(default_factory=list)
    trail: list[Point] = field(default_factory=list)
    things: list[Thing] = field(default_factory=list)
    crane: Crane | None = None
    sun_ms: int | None = None
    is_hasty: bool = False
    rows: Rows | None = None


class Box(Struct, frozen=True, omit_defaults=False):
    """Something found in a picture: its box in shares of the picture, and whether the tool hit it."""

    kind: str
    x: float
    y: float
    w: float
    h: float
    score: float
    hit: bool | None = None


class Order(Struct, frozen=True, array_like=True):
    """To the drawing process: a scene to keep, or a look to draw."""

    number: int
    scene: Scene | None = None
    look: Look | None = None


class Picture(Struct, frozen=True, array_like=True):
    """From the drawing process: a JPEG and what is seen in it, or why there is none."""

    number: int
    jpeg: bytes = b""
    boxes: list[Box] = field(default_factory=list)
    problem: str = ""
