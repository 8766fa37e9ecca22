"""From what a person asks to what the planner is given: the field, its surroundings and home from the farm's map."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from hmi.commands.row_direction import row_direction
from hmi.domain.family import Family
from hmi.domain.flight import is_height_missed, is_in_the_air
from hmi.domain.map_ground import CLOSED_KINDS, CROSSED_KINDS, SLOW_MPS, WAY_KINDS, WIDTHS_M
from hmi.domain.mission_plan import (
    Corner,
    Geometry,
    Pattern,
    PlanRefused,
    PlanWish,
    Rows,
    StartPlace,
    Surroundings,
    TreatedArea,
    Treatment,
)
from hmi.domain.robot import Factsheet
from hmi.mapping.attributes import LONGEST_NAME
from hmi.store.errors import NotFound
from hmi.store.features import Feature

NEAR_HOME_M = 2000.0  # a home further away belongs to another site
FAR_M = 3000.0  # a robot this far from a field is at another site: sending must be a mistake
EARTH_M = 6_371_000.0
LEAST_MPS = 0.01
USUAL_WIDTH_M = 4.0  # of what the map has as a line or point without saying how wide


@dataclass(frozen=True, slots=True)
class AreaOrder:
    """Ground with a dose of its own: a feature of the map, or a GeoJSON polygon."""

    dose: float
    feature_id: str | None = None
    geometry: Geometry | None = None


@dataclass(frozen=True, slots=True)
class PlanOrder:
    """What a person asks to be planned.

    Args:
        row_bearing_deg: clockwise from north; ``None`` follows the field's crop rows, or searches the best.
        rows: what the rows run along; ``None`` as asked by ``row_bearing_deg``, or in the field's direction.
        headland_passes: ``None`` takes as many as turning needs.
        home_id: map feature where the robot stands; ``None`` takes its own or the nearest.
        starts_at: ``field`` plans no way from home and back: somebody brings the robot to the first row.
        overlap: share of the width worked twice.
        treatments: ground with a dose of its own; ``rest_dose`` is that of all other ground of the field.
        lead_in_m, lead_out_m: ``None`` takes the tool's own.
    """

    field_id: str
    robot_id: str
    width_m: float
    name: str = ""
    row_bearing_deg: float | None = None
    rows: Rows | None = None
    headland_passes: int | None = None
    home_id: str | None = None
    starts_at: StartPlace = StartPlace.HOME
    returns_home: bool = True
    is_supervised: bool = True
    pattern: Pattern = Pattern.SHORTEST
    start_corner: Corner | None = None
    overlap: float = 0.0
    row_speed_mps: float | None = None
    plant_spacing_m: float | None = None
    treatments: tuple[AreaOrder, ...] = ()
    rest_dose: float = 1.0
    lead_in_m: float | None = None
    lead_out_m: float | None = None


def wish_for(
    order: PlanOrder, mission_id: str, field: Feature, features: Sequence[Feature], sheet: Factsheet | None
) -> PlanWish:
    """Return the wish for a field of the map.

    Raises:
        NotFound: the home or a treatment area is not on the map.
        PlanRefused: a treatment area is no polygon, or the field has no such lines as the rows shall follow.
    """
    direction = row_direction(order.rows, order.row_bearing_deg, field, features)
    place = _places(field.geometry)[0]
    home = _home(features, order, place)
    origin = (sheet.datum_lon_deg, sheet.datum_lat_deg) if sheet else home or place
    if order.starts_at is StartPlace.FIELD:
        home = None
    return PlanWish(
        mission_id=mission_id,
        name=order.name or f"{field.title[:60]}, {order.width_m:g} m",
        robot_id=order.robot_id,
        field_name=field.title[:LONGEST_NAME],  # maps of before have longer ones
        parcel=field.geometry,
        width_m=order.width_m,
        datum_lat_deg=round(origin[1], 7),
        datum_lon_deg=round(origin[0], 7),
        robot=sheet,
        angle_rad=direction.angle_rad,
        headland_passes=order.headland_passes,
        home=home,
        returns_home=order.returns_home,
        surroundings=surroundings_of(features, field.geometry, field.id, sheet),
        pattern=order.pattern,
        corner=order.start_corner,
        overlap=order.overlap,
        row_speed_mps=order.row_speed_mps,
        plant_spacing_m=order.plant_spacing_m,
        treatment=_treatment(order, features),
        rows=direction.rows,
        row_lines=direction.lines,
        row_spacing_m=field.properties.get("row_spacing_m"),
    )


def _treatment(order: PlanOrder, features: Sequence[Feature]) -> Treatment:
    known = {one.id: one for one in features}
    areas = []
    for area in order.treatments:
        if area.feature_id is not None and area.feature_id not in known:
            raise NotFound(f"there is no map feature {area.feature_id!r}")
        shape = known[area.feature_id].geometry if area.feature_id is not None else area.geometry
        if shape is None or shape.get("type") not in ("Polygon", "MultiPolygon"):
            raise PlanRefused("bad_treatment", "A treatment area is a polygon. Draw its outline.", "treatments")
        areas.append(TreatedArea(shape, area.dose))
    return Treatment(tuple(areas), order.rest_dose, order.lead_in_m, order.lead_out_m)


def _home(features: Sequence[Feature], order: PlanOrder, place: tuple[float, float]) -> tuple[float, float] | None:
    homes = {one.id: one for one in features if one.kind == "home"}
    if order.home_id is not None:
        if order.home_id not in homes:
            raise NotFound(f"there is no home {order.home_id!r} on the map")
        return _places(homes[order.home_id].geometry)[0]
    near = [one for one in homes.values() if metres(_places(one.geometry)[0], place) < NEAR_HOME_M]
    own = [one for one in near if one.properties.get("robot") == order.robot_id]
    best = min(own or near, key=lambda one: metres(_places(one.geometry)[0], place), default=None)
    return None if best is None else _places(best.geometry)[0]


def is_flying(sheet: Factsheet | None) -> bool:
    """Say whether a robot flies over what others drive around."""
    return sheet is not None and sheet.family is Family.UAV


def surroundings_of(
    features: Sequence[Feature], field: Geometry, field_id: str | None, sheet: Factsheet | None = None
) -> Surroundings:
    """Return what is near a field, any part of it; a farm may have sites on other continents.

    Args:
        sheet: of whoever goes there; what flies is kept off by what is as high as it, and needs no roads.
    """
    around = _Box.around(field).grown(FAR_M)
    near = [one for one in features if one.id != field_id and around.meets(one.geometry)]
    slow = tuple((one.geometry, _slow_mps(one)) for one in near if one.kind == "slow")
    if is_flying(sheet):
        height_m = None if sheet is None else sheet.path_height_m
        high = [one for one in near if is_in_the_air(one.kind, one.properties, height_m)]
        return Surroundings(
            tuple((one.geometry, _width(one)) for one in high),
            ((around.geometry, 0.0),),
            (),
            slow,
            tuple(one.title for one in high),
            tuple(k for k, one in enumerate(high) if is_height_missed(one.kind, one.properties)),
            height_m,
        )
    solid = [one for one in near if one.kind in CLOSED_KINDS and one.kind not in CROSSED_KINDS]
    crossed = [one for one in near if one.kind in CROSSED_KINDS]
    return Surroundings(
        tuple((one.geometry, _width(one)) for one in solid),
        tuple((one.geometry, _width(one)) for one in near if one.kind in WAY_KINDS),
        tuple((one.geometry, _width(one)) for one in crossed),
        slow,
        tuple(one.title for one in (*solid, *crossed)),
    )


@dataclass(frozen=True, slots=True)
class _Box:
    """A box in degrees; longitudes count from ``lon``, so that it may lie on longitude 180."""

    lon: float
    west: float
    south: float
    east: float
    north: float

    @classmethod
    def around(cls, geometry: Geometry, lon: float | None = None) -> _Box:
        """Return the box of a shape; without ``lon`` its own first place is in the middle."""
        places = _places(geometry)
        middle = places[0][0] if lon is None else lon
        lons = [math.remainder(x - middle, 360.0) for x, _ in places]
        lats = [y for _, y in places]
        return cls(middle, min(lons), min(lats), max(lons), max(lats))

    @property
    def geometry(self) -> Geometry:
        """It as a polygon."""
        west, east = self.lon + self.west, self.lon + self.east
        ring = [(west, self.south), (east, self.south), (east, self.north), (west, self.north), (west, self.south)]
        return {"type": "Polygon", "coordinates": [[list(place) for place in ring]]}

    def grown(self, metres: float) -> _Box:
        """Return it with so much more on each side."""
        up = math.degrees(metres / EARTH_M)
        aside = up / max(math.cos(math.radians(min(max(abs(self.south), abs(self.north)), 89.0))), 0.01)
        return _Box(self.lon, self.west - aside, self.south - up, self.east + aside, self.north + up)

    def meets(self, geometry: Geometry) -> bool:
        """Say whether a shape's own box touches this one."""
        other = _Box.around(geometry, self.lon)
        is_beside = other.west > self.east or other.east < self.west
        return not (is_beside or other.south > self.north or other.north < self.south)


def _width(feature: Feature) -> float:
    """Return how wide a line is, or a point across."""
    radius = feature.properties.get("radius_m")
    usual = WIDTHS_M.get(feature.kind, USUAL_WIDTH_M)
    return float(feature.properties.get("width_m", usual)) if radius is None else 2 * float(radius)


def _slow_mps(zone: Feature) -> float:
    return max(float(zone.properties.get("speed_mps") or SLOW_MPS), LEAST_MPS)


def _places(geometry: Mapping[str, Any]) -> list[tuple[float, float]]:
    """Return the positions of any GeoJSON geometry, longitude and latitude."""
    found: list[tuple[float, float]] = []
    waiting = [geometry["coordinates"]]
    while waiting:
        one = waiting.pop()
        if one and isinstance(one[0], int | float):
            found.append((float(one[0]), float(one[1])))
        else:
            waiting += reversed(one)
    return found


def metres(a: tuple[float, float], b: tuple[float, float]) -> float:
    """Return the distance of two places, longitude and latitude, on a round earth."""
    lon_a, lat_a, lon_b, lat_b = map(math.radians, (*a, *b))
    half = math.sin((lat_b - lat_a) / 2) ** 2 + math.cos(lat_a) * math.cos(lat_b) * math.sin((lon_b - lon_a) / 2) ** 2
    return 2 * EARTH_M * math.asin(min(1.0, math.sqrt(half)))
