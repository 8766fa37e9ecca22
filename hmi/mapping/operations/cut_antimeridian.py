"""Cut a shape in two at longitude 180."""

from __future__ import annotations

import shapely
from shapely.affinity import translate
from shapely.geometry import Polygon

from hmi.mapping.coordinates import Geometry, is_ring, paths, rounded
from hmi.mapping.errors import OperationRefused
from hmi.mapping.ground import polygons_in
from hmi.mapping.kinds import POLYGON
from hmi.mapping.operations.arguments import Arguments
from hmi.mapping.operations.outcome import Outcome
from hmi.mapping.operations.pieces import changes_for_pieces
from hmi.mapping.operations.selection import Selection, title


def cut_antimeridian(selection: Selection, arguments: Arguments) -> Outcome:
    """Make one feature on each side of an area that crosses longitude 180 (RFC 7946, section 3.1.9).

    Raises:
        OperationRefused: no area, it crosses itself, or it does not cross that line.
    """
    del arguments
    feature = selection.one()
    if not is_ring(feature.geometry):
        raise OperationRefused("not_a_polygon", f"{title(feature)} is no area. Draw one line on each side instead.")
    rings = [[(lon % 360, lat) for lon, lat in ring] for ring in paths(feature.geometry)]
    whole = Polygon(rings[0], rings[1:])
    if not whole.is_valid:
        raise OperationRefused("crosses_itself", f"The outline of {title(feature)} crosses itself. Untangle it first.")
    west, south, east, north = whole.bounds
    if not west < 180 < east or east - west > 180:
        raise OperationRefused("nothing_to_do", f"{title(feature)} does not cross longitude 180.")
    sides = (shapely.box(west, south, 180, north), shapely.box(180, south, east, north))
    pieces = [(piece, n) for n, side in enumerate(sides) for piece in polygons_in(whole.intersection(side))]
    pieces.sort(key=lambda pair: -pair[0].area)
    geometries = [_geometry(translate(piece, -360) if n else piece) for piece, n in pieces]
    changes = changes_for_pieces(feature, geometries, selection.draft, feature.properties)
    return Outcome(f"{title(feature)} cut at longitude 180", changes)


def _geometry(piece: Polygon) -> Geometry:
    wound = shapely.orient_polygons(piece)
    rings = [[rounded(*xy) for xy in ring.coords] for ring in (wound.exterior, *wound.interiors)]
    return {"type": POLYGON, "coordinates": rings}
