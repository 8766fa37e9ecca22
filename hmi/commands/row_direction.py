"""What the rows of a plan run along: as a person chose it, else as the map says of the field."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from hmi.domain.mission_plan import PlanRefused, RowLine, Rows
from hmi.store.features import Feature

FOLLOWED = (Rows.AB_LINE, Rows.GUIDE_LINE, Rows.RECORDED_ROWS)
_DRAWN = {"a-b": Rows.AB_LINE, "curve": Rows.GUIDE_LINE, "recorded": Rows.RECORDED_ROWS}
_MISSING = {
    Rows.AB_LINE: "no A-B line",
    Rows.GUIDE_LINE: "no curved guide line",
    Rows.RECORDED_ROWS: "no recorded rows",
}


@dataclass(frozen=True, slots=True)
class RowDirection:
    """What rows run along: an ENU angle in radians, or lines; without both the best angle is searched.

    ``rows`` is what a person chose.
    """

    rows: Rows | None = None
    angle_rad: float | None = None
    lines: tuple[RowLine, ...] = ()


def row_direction(
    rows: Rows | None, bearing_deg: float | None, field: Feature, features: Sequence[Feature]
) -> RowDirection:
    """Return what the rows of a field shall run along.

    Args:
        rows: what a person chose; ``None`` leaves it to bearing and map.
        bearing_deg: clockwise from north, as a person asked.
        field: a parcel.
        features: of its farm; lines of kind rows name their parcel.

    Raises:
        PlanRefused: both are given, or the field has no such line.
    """
    if rows is None:
        return _usual(bearing_deg, field, features)
    if bearing_deg is not None:
        text = "Choose either what the rows run along or a direction in degrees, not both."
        raise PlanRefused("two_directions", text, "row_bearing_deg")
    if rows not in _MISSING:
        return RowDirection(rows)
    lines = tuple(lines_of(field, features, rows))
    if not lines:
        text = f"The field has {_MISSING[rows]}. Draw or record one under Maps, or choose another row direction."
        raise PlanRefused("no_lines", text, "rows")
    return RowDirection(rows, _mean_angle(lines)) if rows is Rows.AB_LINE else RowDirection(rows, None, lines)


def lines_of(field: Feature, features: Sequence[Feature], rows: Rows | None = None) -> Iterator[RowLine]:
    """Yield the lines drawn or recorded in a field, or those of one kind."""
    for one in features:
        if one.kind != "rows" or one.properties.get("parcel_id") != field.id or rows not in (None, kind_of(one)):
            continue
        several = one.geometry["type"] == "MultiLineString"
        lines = one.geometry["coordinates"] if several else [one.geometry["coordinates"]]
        for number, line in enumerate(lines, 1):
            name = one.title if len(lines) == 1 else f"row {number} of {one.title}"
            yield RowLine(name, tuple((float(p[0]), float(p[1])) for p in line))


def kind_of(lines: Feature) -> Rows:
    """Return what a feature of kind rows is: as it says, else by its shape."""
    said = _DRAWN.get(str(lines.properties.get("type", "")))
    if said is not None:
        return said
    coordinates = lines.geometry["coordinates"]
    if lines.geometry["type"] == "MultiLineString" and len(coordinates) > 1:
        return Rows.RECORDED_ROWS
    line = coordinates[0] if lines.geometry["type"] == "MultiLineString" else coordinates
    return Rows.AB_LINE if len(line) == 2 else Rows.GUIDE_LINE


def _usual(bearing_deg: float | None, field: Feature, features: Sequence[Feature]) -> RowDirection:
    if bearing_deg is not None:
        return RowDirection(None, math.pi / 2 - math.radians(bearing_deg))
    of_field = field.properties.get("row_bearing_deg")
    if of_field is not None:
        return RowDirection(None, math.pi / 2 - math.radians(float(of_field)))
    return RowDirection(None, _mean_angle(tuple(lines_of(field, features))))


def _mean_angle(lines: Sequence[RowLine]) -> float | None:
    """Return the mean direction from first to last points, longer lines weigh more; ``None`` if there are none."""
    east = north = 0.0
    for line in lines:
        (x0, y0), (x1, y1) = line.points[0], line.points[-1]
        dx, dy = (x1 - x0) * math.cos(math.radians(y0)), y1 - y0
        angle, length = math.atan2(dy, dx), math.hypot(dx, dy)
        # a row has no beginning: doubled angles of opposite directions are the same
        east, north = east + length * math.cos(2 * angle), north + length * math.sin(2 * angle)
    return math.atan2(north, east) / 2 if east or north else None
