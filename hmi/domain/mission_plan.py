"""A plan as it is wished for and as it comes back: what console, planner and map agree on.

::

    MissionError
    ├── PlanRefused       the wish cannot be planned; says why and what to change
    ├── PathUnfit         a path from elsewhere is not one that the robot may drive; says why
    └── MissionRefused    what was asked of a stored mission is not possible now
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Protocol

from hmi.domain.mission_document import Document
from hmi.domain.robot import Factsheet

Geometry = Mapping[str, Any]
"""A GeoJSON geometry, longitude and latitude in degrees."""


class MissionError(Exception):
    """Root of the errors about missions.

    Args:
        code: stable machine-readable reason, e.g. ``width_not_positive``.
        text: one sentence for a person: what is wrong and what to change.
        field: name of the input that is wrong, or empty.
    """

    def __init__(self, code: str, text: str, field: str = "") -> None:
        super().__init__(f"{code}: {text}")
        self.code = code
        self.text = text
        self.field = field

    def __reduce__(self) -> tuple[type[MissionError], tuple[str, str, str]]:
        """Survive the way back from a worker process."""
        return type(self), (self.code, self.text, self.field)


class PlanRefused(MissionError):
    """The wish was understood and cannot be planned."""


class PathUnfit(MissionError):
    """A path that was planned elsewhere breaks a rule that every plan keeps."""


class MissionRefused(MissionError):
    """A stored mission cannot be changed, copied or deleted like this now."""


class Pattern(StrEnum):
    """In which order the rows of a field are driven."""

    SHORTEST = "shortest"
    ROW_BY_ROW = "row_by_row"
    SKIP_ROWS = "skip_rows"
    SPIRAL = "spiral"


class Rows(StrEnum):
    """What the rows run along, as a person chooses it."""

    BEST_ANGLE = "best_angle"
    ALONG_EDGE = "along_edge"
    AB_LINE = "ab_line"
    GUIDE_LINE = "guide_line"
    RECORDED_ROWS = "recorded_rows"


@dataclass(frozen=True, slots=True)
class RowLine:
    """A line of the map that rows follow: what people call it, and its longitudes and latitudes."""

    name: str
    points: tuple[tuple[float, float], ...]


class Corner(StrEnum):
    """Where in the field the rows begin."""

    NORTH_WEST = "north_west"
    NORTH_EAST = "north_east"
    SOUTH_WEST = "south_west"
    SOUTH_EAST = "south_east"


class StartPlace(StrEnum):
    """Where a mission begins."""

    HOME = "home"
    FIELD = "field"


@dataclass(frozen=True, slots=True)
class TreatedArea:
    """Ground with a treatment of its own: ``dose`` times the usual one, 0 is off, 2 the most."""

    geometry: Geometry
    dose: float


@dataclass(frozen=True, slots=True)
class Treatment:
    """Where the tool works. Later areas win over earlier ones.

    Args:
        areas: ground that differs from the rest of the field.
        rest_dose: of the ground outside the areas.
        lead_in_m, lead_out_m: the tool is on so long before and after treated ground; ``None`` takes the tool's own.
    """

    areas: tuple[TreatedArea, ...] = ()
    rest_dose: float = 1.0
    lead_in_m: float | None = None
    lead_out_m: float | None = None


@dataclass(frozen=True, slots=True)
class Surroundings:
    """The map around a field, each feature with its width in metres (0 for polygons).

    Args:
        obstacles: where no machine may be.
        ways: roads and yards it may use on its way to the field.
        crossed: water, hedges and trees: as obstacles, but for where a way is drawn across.
        slow: zones, each with the most that may be driven there, m/s, in place of a width.
        names: what people call the obstacles, and after them what is crossed; empty where nobody is told of them.
        unmeasured: of a machine that flies, the obstacles it flies around because nobody entered how high they are, by
            number.
        flight_height_m: of a machine that flies, above the ground; ``None``: it does not say.
    """

    obstacles: tuple[tuple[Geometry, float], ...] = ()
    ways: tuple[tuple[Geometry, float], ...] = ()
    crossed: tuple[tuple[Geometry, float], ...] = ()
    slow: tuple[tuple[Geometry, float], ...] = ()
    names: tuple[str, ...] = ()
    unmeasured: tuple[int, ...] = ()
    flight_height_m: float | None = None


@dataclass(frozen=True, slots=True)
class PlanWish:
    """What to plan. Angles in radians, ENU; lengths in metres.

    Args:
        mission_id, name, robot_id, field_name: as they shall stand in the document.
        parcel: the field, a GeoJSON polygon.
        width_m: working width of the tool; the rows are that far apart, less the overlap.
        datum_lat_deg, datum_lon_deg: origin of the plane; best the robot's own.
        robot: what the robot says it is; ``None`` takes the usual weeder.
        angle_rad: row direction; ``None`` searches the one with the fewest rows.
        headland_passes: laps around the field; ``None`` takes as many as turning needs.
        home: longitude and latitude of where the robot stands; ``None`` begins at the first row.
        returns_home: drive back at the end.
        pattern: order of the rows.
        corner: where the rows begin; ``None`` begins where the way from home is short.
        overlap: share of the width that neighbouring rows work twice.
        row_speed_mps: speed on the rows; ``None`` takes the robot's usual one.
        plant_spacing_m: of a planter, along the row; ``None`` takes the usual density.
        rows: what the rows run along, ``None`` for ``angle_rad``, which edge and lines do without.
        row_lines: the guide lines or recorded rows to follow.
        row_spacing_m: distance of the recorded rows; ``None`` measures it.
    """

    mission_id: str
    name: str
    robot_id: str
    field_name: str
    parcel: Geometry
    width_m: float
    datum_lat_deg: float
    datum_lon_deg: float
    robot: Factsheet | None = None
    angle_rad: float | None = None
    headland_passes: int | None = None
    home: tuple[float, float] | None = None
    returns_home: bool = False
    surroundings: Surroundings = Surroundings()
    revision: int = 1
    pattern: Pattern = Pattern.SHORTEST
    corner: Corner | None = None
    overlap: float = 0.0
    row_speed_mps: float | None = None
    plant_spacing_m: float | None = None
    treatment: Treatment = Treatment()
    rows: Rows | None = None
    row_lines: tuple[RowLine, ...] = ()
    row_spacing_m: float | None = None


@dataclass(frozen=True, slots=True)
class PlannedMission:
    """A mission ready to store: wire document, its hash, and the numbers of the plan (SI)."""

    document: Document
    sha256: str
    statistics: dict[str, Any]


@dataclass(frozen=True, slots=True)
class Candidate:
    """A plan to look at: its numbers (SI) and a drawing of it, metres east and north of the wish's datum."""

    statistics: dict[str, Any]
    drawing: dict[str, Any]


Tell = Callable[[float, str], None]
"""Hears how far a plan is: a share, 0 to 1, and words for a person."""


def nobody(_share: float, _words: str) -> None:
    """Hear of progress and leave it."""


class Planner(Protocol):
    """Plans off the event loop."""

    async def candidate(self, wish: PlanWish, tell: Tell = nobody) -> Candidate:
        """Return the plan to look at; cancelling gives the work up. Raises as ``plan``."""
        ...

    async def plan(self, wish: PlanWish, tell: Tell = nobody) -> PlannedMission:
        """Return the plan.

        Raises:
            PlanRefused: it cannot be planned, or took too long.
        """
        ...
