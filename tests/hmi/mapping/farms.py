"""Features to try things on, given in metres around one place."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import shapely
from hypothesis import strategies as st

from hmi.mapping.feature import MapFeature, parse_feature
from hmi.mapping.ground import Shape, shape_of
from hmi.mapping.operations import Outcome, apply
from hmi.planning.projection import LocalFrame

HERE = LocalFrame(51.7, 4.2)
XY = tuple[float, float]


def degrees(points_m: Iterable[XY]) -> list[list[float]]:
    """Return metres east and north of the place as longitudes and latitudes."""
    return [[float(lon), float(lat)] for lon, lat in HERE.to_lon_lat(list(points_m))]


def box(west: float, south: float, east: float, north: float) -> list[XY]:
    """Return a closed ring, counter-clockwise."""
    return [(west, south), (east, south), (east, north), (west, north), (west, south)]


def raw(feature_id: str, kind: str, geometry: Mapping[str, Any], **properties: Any) -> dict[str, Any]:
    """Return a GeoJSON feature."""
    name = properties.pop("name", feature_id.replace("-", " ").capitalize())
    own = {"id": feature_id, "kind": kind, "name": name, **properties}
    return {"type": "Feature", "id": feature_id, "properties": own, "geometry": geometry}


def area(feature_id: str, outline: Sequence[XY], *holes: Sequence[XY], kind: str = "parcel", **own: Any) -> MapFeature:
    """Return a polygon feature of rings in metres."""
    rings = [degrees(ring) for ring in (outline, *holes)]
    return parse_feature(raw(feature_id, kind, {"type": "Polygon", "coordinates": rings}, **own))


def line(feature_id: str, points: Sequence[XY], kind: str = "road", **own: Any) -> MapFeature:
    """Return a line feature of points in metres."""
    own = {"width_m": 4, **own} if kind == "road" else own
    return parse_feature(raw(feature_id, kind, {"type": "LineString", "coordinates": degrees(points)}, **own))


def point(feature_id: str, at: XY, kind: str = "home", **own: Any) -> MapFeature:
    """Return a point feature at a place in metres."""
    return parse_feature(raw(feature_id, kind, {"type": "Point", "coordinates": degrees([at])[0]}, **own))


def draft(*features: MapFeature) -> dict[str, MapFeature]:
    """Return a draft by id."""
    return {one.id: one for one in features}


def metres(feature: MapFeature | None) -> Shape:
    """Return a feature's shape in metres around the place."""
    assert feature is not None
    return shape_of(feature.geometry, HERE)


def do(op: str, features: Mapping[str, MapFeature], ids: Sequence[str], **args: Any) -> dict[str, MapFeature]:
    """Return the draft after an operation; its outcome keeps the rules of every operation."""
    outcome = apply(op, features, ids, args)
    assert_sound(outcome, features)
    return outcome.applied_to(features)


def assert_sound(outcome: Outcome, features: Mapping[str, MapFeature]) -> None:
    """Hold an outcome to what every operation promises: honest before, valid after, undone exactly."""
    assert outcome.changes
    assert 0 < len(outcome.label) < 200
    after = outcome.applied_to(features)
    for change in outcome.changes:
        assert change.before == features.get(change.id)
        assert change.after != change.before
        if change.after is not None:
            assert change.after.id == change.id
            assert metres(change.after).is_valid
    assert outcome.taken_back_from(after) == dict(features)


@st.composite
def fields(draw: st.DrawFn, most_holes: int = 1) -> MapFeature:
    """Draw star-shaped parcels from a garden to some hectares, some with a hole."""
    size = draw(st.floats(20, 150))
    count = draw(st.integers(4, 12))
    radii = [draw(st.floats(0.4, 1.0)) * size for _ in range(count)]
    start = draw(st.floats(0, 1))
    ring = [
        (r * math.cos(math.tau * (n + start) / count), r * math.sin(math.tau * (n + start) / count))
        for n, r in enumerate(radii)
    ]
    hole_m = 0.1 * size
    outline = shapely.Polygon(ring)
    middle = shapely.Point(0, 0)
    holes = []
    if most_holes and draw(st.booleans()) and outline.exterior.distance(middle) > 2 * hole_m:
        holes = [box(-hole_m, -hole_m, hole_m, hole_m)[::-1]]
    return area("north", [*ring, ring[0]], *holes, name="North", crop="Wheat", row_bearing_deg=11.5)


@st.composite
def scribbles(draw: st.DrawFn) -> MapFeature:
    """Draw parcels as a finger may: corners anywhere on a coarse grid, edges that cross, double corners."""
    grid = st.integers(0, 8)
    corners = draw(st.lists(st.tuples(grid, grid), min_size=3, max_size=9).filter(lambda c: len(set(c)) > 2))
    ring = [(x * 10.0, y * 10.0) for x, y in corners]
    return area("north", [*ring, ring[0]], name="North")
