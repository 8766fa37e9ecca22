"""What falls apart: the largest piece stays the feature, the others become new ones beside it."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from hmi.mapping.attributes import LONGEST_NAME
from hmi.mapping.coordinates import Geometry, paths, with_paths
from hmi.mapping.errors import OperationRefused
from hmi.mapping.feature import MapFeature
from hmi.mapping.ground import Shape, frame_of, polygon_geometry, shape_of
from hmi.mapping.operations.edges import needless
from hmi.mapping.operations.outcome import Change, added, changed
from hmi.mapping.operations.selection import title
from hmi.planning.projection import LocalFrame

MOST_PIECES = 50  # more is a slip of the finger, not a wish
CRUMB_M2 = 0.1  # what an operation leaves that is smaller is rounding, not land
_LETTERED = re.compile(r"^(?P<stem>.+)-[b-z]$")
_ID_LENGTH = 64


def changes_for_pieces(
    feature: MapFeature, pieces: Sequence[Geometry], draft: Mapping[str, MapFeature], properties: Mapping[str, object]
) -> tuple[Change, ...]:
    """Return the changes that put ``pieces``, largest first, in the place of ``feature``.

    Raises:
        OperationRefused: no piece, or too many.
    """
    if not pieces:
        raise OperationRefused("vanishes", f"Nothing would be left of {title(feature)}. Choose less, or delete it.")
    if len(pieces) > MOST_PIECES:
        raise OperationRefused(
            "too_many_pieces",
            f"{title(feature)} would fall into {len(pieces)} pieces, at most {MOST_PIECES} are allowed.",
        )
    first, *others = pieces
    changes = [changed(feature, replace(feature, geometry=first, properties=dict(properties)))]
    for (new_id, letter), geometry in zip(_free_ids(feature, draft), others, strict=False):
        name = f"{_stem_name(feature)[: LONGEST_NAME - 1 - len(letter)].rstrip()} {letter}" if feature.name else ""
        changes.append(added(MapFeature(new_id, feature.kind, name, geometry, dict(properties))))
    return tuple(changes)


def polygon_pieces(pieces: Sequence[Shape], frame: LocalFrame) -> list[Geometry]:
    """Return polygons of ``frame`` in degrees, in their order, without crumbs."""
    found = (clean_geometry(piece, frame) for piece in pieces if piece.area > CRUMB_M2)
    return [geometry for geometry in found if geometry is not None]


def clean_geometry(piece: Shape, frame: LocalFrame) -> Geometry | None:
    """Return a polygon of ``frame`` in degrees; ``None`` if nothing is left.

    Where edges of two features lie on each other, overlays leave double corners and spikes: those are taken away.
    """
    geometry = polygon_geometry(piece, frame)
    if geometry is None:
        return None
    rings = []
    for ring in paths(geometry):
        corners = ring[:-1]
        gone = set(needless(frame.to_local(corners), is_closed=True))
        left = [place for n, place in enumerate(corners) if n not in gone]
        rings.append([*left, list(left[0])] if len(left) > 2 else ring)
    clean = with_paths(geometry, rings)
    return clean if shape_of(clean, frame).is_valid else geometry


def rows_that_follow(changes: Sequence[Change], draft: Mapping[str, MapFeature]) -> tuple[Change, ...]:
    """Return the changes of rows whose parcel was split or merged: they name the piece that holds most of them."""
    gone = {change.id for change in changes}
    left = [change.after for change in changes if change.after is not None and change.after.kind == "parcel"]
    rows = [one for one in draft.values() if one.kind == "rows" and one.properties.get("parcel_id") in gone]
    return tuple(change for one in rows if (change := _follow(one, left)) is not None)


def _follow(rows: MapFeature, parcels: Sequence[MapFeature]) -> Change | None:
    frame = frame_of([rows])
    line = shape_of(rows.geometry, frame)
    lengths = {one.id: shape_of(one.geometry, frame).intersection(line).length for one in parcels}
    if not lengths:
        return None
    stays = rows.properties["parcel_id"]
    best = max(lengths, key=lambda key: (lengths[key], key == stays))
    if best == stays:
        return None
    return changed(rows, replace(rows, properties={**rows.properties, "parcel_id": best}))


def _free_ids(feature: MapFeature, draft: Mapping[str, MapFeature]) -> Iterator[tuple[str, str]]:
    found = _LETTERED.match(feature.id)
    stem = found["stem"] if found else feature.id
    for letter in _letters():
        new_id = f"{stem[: _ID_LENGTH - 1 - len(letter)]}-{letter}"
        if new_id not in draft:
            yield new_id, letter


def _letters() -> Iterator[str]:
    alphabet = "bcdefghijklmnopqrstuvwxyz"
    yield from alphabet
    number = 2
    while True:
        yield from (f"{letter}{number}" for letter in alphabet)
        number += 1


def _stem_name(feature: MapFeature) -> str:
    letter = feature.id[-1] if _LETTERED.match(feature.id) else ""
    name = feature.name
    if letter and name.endswith(f" {letter}") and len(name) > 2:
        name = name[:-2]
    return name
