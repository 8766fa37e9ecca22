"""Cut a shape in two at longitude 180."""

from __future__ import annotations

from typing import Any

import shapely
from shapely.affinity import translate
from shapely.geometry import LineString, Polygon

from hmi.mapping.coordinates import Geometry, is_ring, paths, rounded
from hmi.mapping.errors import OperationRefused
from hmi.mapping.feature import MapFeature
from hmi.mapping.ground import polygons_in
from hmi.mapping.kinds import LINE, POLYGON
from hmi.mapping.operations.arguments import Arguments
from hmi.mapping.operations.outcome import Outcome
from hmi.mapping.operations.pieces import changes_for_pieces
from hmi.mapping.operations.selection import Selection, title


def cut_antimeridian(selection: Selection, arguments: Arguments) -> Outcome:
    """Make a feature for each piece of an area or line that crosses longitude 180 (RFC 7946, section 3.1.9).

    Raises:
        OperationRefused: several lines or a point, an area that crosses itself, or nothing crosses that line.
    """
    del arguments
    feature = selection.one()
    whole = _whole(feature)
    west, south, east, north = whole.bounds
    if not west < 180 < east or east - west > 180:
        raise OperationRefused("nothing_to_do", f"{title(feature)} does not cross longitude 180.")
    sides = (shapely.box(west, south - 1, 180, north + 1), shapely.box(180, south - 1, east, north + 1))
    pieces = [(piece, n) for n, side in enumerate(sides) for piece in _parts(whole, side)]
    pieces.sort(key=lambda pair: (-pair[0].area, -pair[0].length))
    geometries = [_geometry(translate(piece, -360) if n else piece) for piece, n in pieces]
    changes = changes_for_pieces(feature, geometries, selection.draft, feature.properties)
    return Outcome(f"{title(feature)} cut at longitude 180", changes)


def can_cut(feature: MapFeature) -> bool:
    """Say whether it is one area or one line."""
    return is_ring(feature.geometry) or feature.geometry["type"] == LINE


def _whole(feature: MapFeature) -> Polygon | LineString:
    """Return its shape in degrees, longitudes from 0 to 360."""
    if not can_cut(feature):
        text = f"{title(feature)} is neither an area nor one line. Draw it once on each side instead."
        raise OperationRefused("cannot_cut", text)
    lines = [[(lon % 360, lat) for lon, lat in path] for path in paths(feature.geometry)]
    if feature.geometry["type"] == LINE:
        return LineString(lines[0])
    whole = Polygon(lines[0], lines[1:])
    if not whole.is_valid:
        raise OperationRefused("crosses_itself", f"The outline of {title(feature)} crosses itself. Untangle it first.")
    return whole


def _parts(whole: Polygon | LineString, side: Polygon) -> list[Any]:
    there = whole.intersection(side)
    if isinstance(whole, Polygon):
        return list(polygons_in(there))
    return [part for part in shapely.get_parts(there) if isinstance(part, LineString)]


def _geometry(piece: Polygon | LineString) -> Geometry:
    if isinstance(piece, LineString):
        return {"type": LINE, "coordinates": [rounded(*xy) for xy in piece.coords]}
    wound = shapely.orient_polygons(piece)
    rings = [[rounded(*xy) for xy in ring.coords] for ring in (wound.exterior, *wound.interiors)]
    return {"type": POLYGON, "coordinates": rings}
