"""From what a file tells to what can be taken over: shape by shape, a bad one never takes the good ones along."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from statistics import median
from typing import Any

from pyproj import Geod

from hmi.domain.map_ground import FLOWN_OVER_KINDS
from hmi.map_files import attributes
from hmi.map_files.coordinate_system import WGS84, CoordinateSystem
from hmi.map_files.errors import BadMapFile
from hmi.map_files.imported import Geometry, Imported, MapItem, Skipped
from hmi.map_files.kind_guess import ALL_KINDS, guess, named, possible
from hmi.map_files.limits import Allowance
from hmi.map_files.own_words import settled
from hmi.map_files.shape import BadShape, fit, lines_of, outline_of, simple_parts
from hmi.map_files.source import Source, SourceFeature, SourceLayer
from hmi.mapping.attributes import LONGEST_NAME

_GEOD = Geod(ellps="WGS84")
TOLD_EVERY = 50  # shapes
FAR_DEG = 5.0  # about 500 km: no farm is that large
OUTLINE_M2 = 500.0  # smaller than any field
_OUTLINED = "The line ends where it began and was taken as an outline."
_ASSUMED = "The file does not name its coordinate system; WGS84 was assumed. Check the place on the map."
_EXCHANGED = "It lies far from the rest of the file: latitude and longitude may be exchanged."


def harvest(source: Source, report: Callable[[int, int], None] = lambda shapes, of: None) -> Imported:
    """Return the items and what was skipped.

    Args:
        report: is told now and then how many shapes of how many were looked at.

    Raises:
        BadMapFile: nothing in it, too much in it, or no coordinate system that could be meant.
    """
    reaper = _Reaper(source.skipped, sum(len(layer.features) for layer in source.layers), report)
    for layer in source.layers:
        try:
            reaper.layer(layer)
        except BadMapFile as error:
            if error.code != "no_coordinate_system" or len(source.layers) == 1:
                raise
            reaper.skipped.append(Skipped(layer.name, error.text, "Export this layer once more."))
    items = tuple(_looked_at(reaper.items))
    if not items and not reaper.skipped:
        raise BadMapFile("nothing_in_it", "The file holds no shapes. Export it again with the fields in it.")
    return Imported(source.format, ", ".join(reaper.systems) or WGS84.label, items, tuple(reaper.skipped))


class _Reaper:
    def __init__(self, skipped: list[Skipped], total: int, report: Callable[[int, int], None]) -> None:
        self._total, self._report, self._seen = total, report, 0
        self.items: list[MapItem] = []
        self.skipped = list(skipped)
        self.systems: list[str] = []
        self._allowance = Allowance()

    def layer(self, layer: SourceLayer) -> None:
        """Take what is in one layer.

        Raises:
            BadMapFile: too much in it, or coordinates that are not degrees and nobody says what.
        """
        crs, notes = layer.crs, []
        if crs is None:
            _check_degrees(layer)
            crs, notes = WGS84, [_ASSUMED]
        for feature in layer.features:
            self._allowance.feature()
            self._seen += 1
            if self._seen % TOLD_EVERY == 0:
                self._report(self._seen, self._total)
            self._feature(layer.name, feature, feature.crs or crs, notes)

    def _feature(self, layer: str, feature: SourceFeature, crs: CoordinateSystem, notes: list[str]) -> None:
        if crs.label not in self.systems:
            self.systems.append(crs.label)
        found: list[tuple[Geometry, list[str]]] = []
        which = f"{layer}: {feature.which}" if layer else feature.which
        try:
            parts = simple_parts(feature.geometry)
        except BadShape as error:
            self.skipped.append(Skipped(which, error.why, error.mend))
            return
        for i, part in enumerate(parts):
            problems = [*notes, *feature.problems]
            try:
                found.append((fit(part, crs, self._allowance, problems), problems))
            except BadShape as error:
                of = f", part {i + 1}" if len(parts) > 1 else ""
                self.skipped.append(Skipped(which + of, error.why, error.mend))
        self._items(layer, feature, found)

    def _items(self, layer: str, feature: SourceFeature, found: list[tuple[Geometry, list[str]]]) -> None:
        told: list[str] = []
        name, kind, properties = _told(feature, told)
        if name and len(name) > LONGEST_NAME:
            told.append(f"Its name is longer than {LONGEST_NAME} letters; the rest was left out.")
        shapes = [(one, problems) for shape, problems in found for one in _by_kind(shape, kind, layer, name, feature)]
        for i, (drawn, said_of_it) in enumerate(shapes):
            shape, problems = _outlined(drawn, said_of_it, feature, [layer, name or ""])
            number = f" ({i + 1})" if name and len(shapes) > 1 else ""
            called = name and f"{name[: LONGEST_NAME - len(number)]}{number}"
            best = guess(shape["type"], kind, feature.properties, [layer, name or ""])
            kinds = (best, *(k for k in possible(shape["type"]) if k != best))
            if kind in ALL_KINDS and kind not in kinds:
                problems.append(f"A {shape['type']} cannot be a {kind}; choose what it is.")
            said = [*problems, *told]
            own = (
                properties
                if feature.is_exact or best not in FLOWN_OVER_KINDS
                else attributes.with_height(properties, said)
            )
            kept = settled(best, shape, own, said)
            n = len(self.items)
            is_named = feature.is_exact and name is not None
            title = called if called or is_named else f"{best.capitalize()} {n + 1}"
            own_id = feature.id if len(shapes) == 1 else None
            said = list(dict.fromkeys(said))
            area, site = _area_m2(shape), feature.site
            self.items.append(MapItem(n, title or "", best, kinds, shape, kept, tuple(said), own_id, area, site))


def _outlined(
    shape: Geometry, problems: list[str], feature: SourceFeature, names: list[str]
) -> tuple[Geometry, list[str]]:
    """Take a line around a field, of which nothing says that it is a road or the like, as the field."""
    if feature.is_exact or feature.kind or named(shape["type"], feature.properties, names):
        return shape, problems
    outline = outline_of(shape)
    if outline is None or _area_m2(outline) < OUTLINE_M2:
        return shape, problems
    return outline, [*problems, _OUTLINED]


def _area_m2(shape: Geometry) -> float:
    """Return the area on the ellipsoid; a plane for each shape would take longer than reading the file."""
    rings = shape["coordinates"] if shape["type"] == "Polygon" else []
    areas = [abs(_GEOD.polygon_area_perimeter([p[0] for p in ring], [p[1] for p in ring])[0]) for ring in rings]
    return float(max(areas[0] - sum(areas[1:]), 0.0)) if areas else 0.0


def _told(feature: SourceFeature, problems: list[str]) -> tuple[str | None, str | None, dict[str, Any]]:
    """Return name, kind and properties; those of our own files stand as they are."""
    if feature.is_exact:
        return feature.name, feature.kind, attributes.tidy(feature.properties, problems, is_own=True)
    name, properties = attributes.mapped(feature.properties, problems)
    return attributes.clean_name(feature.name or name or "") or None, feature.kind, properties


def _by_kind(shape: Geometry, kind: str | None, layer: str, name: str | None, feature: SourceFeature) -> list[Geometry]:
    """Keep several lines together only where they are rows."""
    if shape["type"] != "MultiLineString":
        return [shape]
    if guess("LineString", kind, feature.properties, [layer, name or ""]) == "rows":
        return [shape]
    return [{"type": "LineString", "coordinates": line} for line in shape["coordinates"]]


def _check_degrees(layer: SourceLayer) -> None:
    """Refuse positions that cannot be degrees where nobody says what else they are."""
    for feature in layer.features:
        try:
            parts = simple_parts(feature.geometry)
            places = [place for part in parts for line in lines_of(part) for place in line]
        except BadShape:
            continue
        if any(_is_no_degree(place) for place in places):
            text = (
                f"{layer.name or 'The file'} does not name its coordinate system, and its numbers are not degrees. "
                "Export it in WGS84 (EPSG:4326), or add the .prj file."
            )
            raise BadMapFile("no_coordinate_system", text)


def _is_no_degree(place: Any) -> bool:
    numbers = place[:2] if isinstance(place, list) else []
    return all(isinstance(n, (int, float)) and math.isfinite(n) for n in numbers) and any(abs(n) > 180 for n in numbers)


def _looked_at(items: list[MapItem]) -> list[MapItem]:
    """Add a problem to items that would lie with the others if their axes were exchanged."""
    if len(items) < 3:
        return items
    places = [lines_of(item.geometry)[0][0] for item in items]
    lon, lat = median(p[0] for p in places), median(p[1] for p in places)
    return [
        replace(item, problems=(*item.problems, _EXCHANGED)) if _is_exchanged(place, (lon, lat)) else item
        for item, place in zip(items, places, strict=True)
    ]


def _is_exchanged(place: list[float], middle: tuple[float, float]) -> bool:
    return math.dist(place, middle) > FAR_DEG and math.dist(place[::-1], middle) < FAR_DEG
