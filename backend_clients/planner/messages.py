"""What console and planner say to each other. Lengths in metres, angles in radians, positions longitude, latitude.

The answer is the path and nothing else: who asked counts time, ground and energy of it, and checks it, by itself.
"""

from __future__ import annotations

import hashlib
import json
from enum import StrEnum
from typing import Annotated, ClassVar, Literal

from pydantic import BaseModel, ConfigDict, Field, SerializerFunctionWrapHandler, model_serializer

VERSION: Literal[1] = 1
MAX_REQUEST = 4 * 2**20
MAX_ANSWER = 16 * 2**20
MAX_SEGMENTS = 20_000  # of the edge contract
MAX_POINTS = 200_000

Metres = Annotated[float, Field(ge=0, le=1000)]
Lon = Annotated[float, Field(ge=-180, le=180)]
Lat = Annotated[float, Field(ge=-90, le=90)]
Place = tuple[Lon, Lat]
Ring = Annotated[list[Place], Field(min_length=4, max_length=MAX_POINTS)]
Rings = Annotated[list[Ring], Field(min_length=1, max_length=500)]
Hash = Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]
PlanId = Annotated[str, Field(pattern=r"^[A-Za-z0-9_-]{1,64}$")]
Dose = Annotated[float, Field(ge=0, le=2)]
Speed = Annotated[float, Field(gt=0, le=20)]


class Message(BaseModel):
    """Strict on both sides: what is not in the format is refused, and so are NaN and infinities."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Brief(Message):
    """Leaves out what a later edition added where it says nothing: an older partner refuses what it does not know."""

    LATER: ClassVar[frozenset[str]] = frozenset()

    @model_serializer(mode="wrap")
    def _brief(self, handler: SerializerFunctionWrapHandler) -> dict[str, object]:
        whole: dict[str, object] = handler(self)
        return {name: value for name, value in whole.items() if value or name not in self.LATER}


class Told(Message):
    """What a service says about itself and its work: unknown fields are left alone, newer services may say more."""

    model_config = ConfigDict(frozen=True, extra="ignore", allow_inf_nan=False)


class Datum(Message):
    """Origin of the plane in which the path is told: azimuthal equidistant, WGS84, x east, y north."""

    lat_deg: Lat
    lon_deg: Lon


class Machine(Brief):
    """Outline and motion limits of the robot. Its base follows the path; ``margin_m`` stays free around it."""

    LATER = frozenset({"reverse_mps", "family"})
    length_m: Annotated[float, Field(gt=0, le=50)]
    width_m: Annotated[float, Field(gt=0, le=50)]
    base_to_front_m: Metres
    turning_radius_m: Annotated[float, Field(ge=0, le=100)]
    can_pivot: bool
    row_speed_mps: Speed
    turn_speed_mps: Speed
    transit_speed_mps: Speed
    accel_mps2: Annotated[float, Field(gt=0, le=20)]
    yaw_rate_radps: Annotated[float, Field(gt=0, le=20)]
    margin_m: Metres
    reverse_mps: Annotated[
        float, Field(ge=0, le=20, description="speed backwards in turns between rows or laps; 0: no path backwards")
    ] = 0.0
    family: Annotated[
        Literal["", "weeder", "planter", "uav", "other"],
        Field(description="uav: it flies over the crop and turns above it; left out: on the ground"),
    ] = ""


class Ground(Message):
    """A map feature: a polygon as it is (``width_m`` 0), a line or point with its width."""

    geometry: Annotated[
        dict[str, object], Field(description="GeoJSON Polygon, MultiPolygon, LineString, MultiLineString or Point")
    ]
    width_m: Metres = 0.0


class DoseArea(Message):
    """Ground with a dose of its own, times the usual one; 0 is off."""

    geometry: Annotated[dict[str, object], Field(description="GeoJSON Polygon or MultiPolygon")]
    dose: Dose


class Treatment(Message):
    """Where the tool works; later areas win. It is on ``lead_in_m`` before treated ground, and ``lead_out_m`` after."""

    areas: Annotated[list[DoseArea], Field(max_length=200)] = []
    rest_dose: Dose = 1.0
    lead_in_m: Annotated[float, Field(ge=0, le=10)]
    lead_out_m: Annotated[float, Field(ge=0, le=10)]


class Wish(Message):
    """What to plan. No names: neither of the farm, nor of people, robots or fields."""

    datum: Datum
    field: Rings
    machine: Machine
    width_m: Annotated[float, Field(gt=0, le=50, description="working width of the tool")]
    overlap: Annotated[float, Field(ge=0, le=0.5, description="share of the width that neighbouring rows work twice")]
    angle_rad: Annotated[float | None, Field(description="row direction, 0 east; null: choose")] = None
    headland_passes: Annotated[int | None, Field(ge=0, le=50, description="null: as many as turning needs")] = None
    pattern: Literal["shortest", "row_by_row", "skip_rows", "spiral"] = "shortest"
    corner: Literal["north_west", "north_east", "south_west", "south_east"] | None = None
    home: Annotated[Place | None, Field(description="where the robot stands; null: begin at the first row")] = None
    returns_home: bool = False
    obstacles: Annotated[list[Ground], Field(max_length=5000)] = []
    ways: Annotated[list[Ground], Field(max_length=5000)] = []
    treatment: Treatment


class PlanRequest(Message):
    """Body of ``POST /plans``. ``wish_sha256`` is said back in every answer: that is how the asker knows its own."""

    v: Literal[1] = VERSION
    wish_sha256: Hash
    wish: Wish


class Segment(Brief):
    """One smooth piece of path. ``pivot``: stop before it and turn on the spot to its first direction.

    ``is_backward``: the rear leads, in a turn with the tool off; where it changes the machine stops, its heading stays.
    """

    LATER = frozenset({"is_backward"})
    kind: Literal["approach", "row", "turn", "headland", "exit"]
    points: Annotated[list[tuple[float, float]], Field(min_length=2, max_length=MAX_POINTS)]
    speed_mps: Speed
    tool_on: bool = False
    row: Annotated[int, Field(ge=0, le=MAX_SEGMENTS, description="from 1 in driving order, 0 off the rows")] = 0
    pivot: bool = False
    dose: Annotated[float, Field(gt=0, le=2)] = 1.0
    is_continued: Annotated[bool, Field(description="a piece of the row or lap the segment before belongs to")] = False
    is_backward: bool = False


class PlanPath(Message):
    """The result: the whole path in driving order."""

    segments: Annotated[list[Segment], Field(min_length=1, max_length=MAX_SEGMENTS)]
    notes: Annotated[list[Annotated[str, Field(max_length=300)]], Field(max_length=20)] = []


class PlanState(StrEnum):
    """The life of a plan; the last three are ends."""

    QUEUED = "queued"
    RUNNING = "running"
    DONE = "done"
    FAILED = "failed"
    CANCELLED = "cancelled"


class Problem(Told):
    """Why not: ``code`` for programs, ``text`` one sentence for a person, ``field`` of the wish if one is wrong."""

    code: Annotated[str, Field(max_length=64)]
    text: Annotated[str, Field(max_length=400)]
    field: Annotated[str, Field(max_length=64)] = ""


class PlannerName(Told):
    """Who planned."""

    name: Annotated[str, Field(max_length=80)]
    version: Annotated[str, Field(max_length=40)] = ""


class PlanReport(Told):
    """Answer of ``POST /plans`` and ``GET /plans/{id}``. ``result`` comes with done, ``problem`` with failed."""

    v: Literal[1] = VERSION
    id: Annotated[PlanId, Field(description="the idempotency key, if one was given")]
    wish_sha256: Annotated[Hash, Field(description="as in the request")]
    state: PlanState
    progress: Annotated[float, Field(ge=0, le=1)] = 0.0
    words: Annotated[str, Field(max_length=120)] = ""
    result: PlanPath | None = None
    problem: Problem | None = None


class ServiceInfo(Told):
    """Answer of ``GET /``: that it is a planner, and how busy."""

    v: Literal[1] = VERSION
    service: Literal["planner"]
    planner: PlannerName
    waiting: Annotated[int, Field(ge=0)] = 0


def wish_sha256(wish: Wish) -> str:
    """Return what tells one wish from another."""
    text = json.dumps(wish.model_dump(mode="json"), sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()
