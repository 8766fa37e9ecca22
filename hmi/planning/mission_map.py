"""A mission's document as GeoJSON for the map: parcel, path in driving order, home."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from hmi.domain.planned_machine import MACHINE
from hmi.planning.projection import LocalFrame

DIGITS = 7  # of longitude and latitude: a centimetre


def mission_geojson(document: Mapping[str, Any], statistics: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """Return a FeatureCollection: the parcel, then every segment in driving order, then home, then areas.

    A segment has ``kind``, ``row`` (0 off the rows), ``segment`` (its number from 0), ``pivot``, ``tool_on`` and, if
    it is not the usual one, ``dose``; areas are of ``kind`` dose, obstacle or leave_out.
    The collection carries ``mission_id``, ``sha256`` is the caller's to add.

    Args:
        statistics: the mission's figures; they know its treatment areas and what was drawn on it.
    """
    frame = LocalFrame(document["datum"]["lat_deg"], document["datum"]["lon_deg"])
    parcel = {
        "kind": "parcel",
        "name": document["field_name"],
        "width_m": _treated_m(document, statistics or {}),
        "area_m2": document["area_m2"],
    }
    features = [_feature("Polygon", [_rounded(ring) for ring in document["parcel"]], parcel)]
    for number, line in enumerate(_lines(document["segments"], frame)):
        segment = document["segments"][number]
        properties = {
            "kind": segment["kind"],
            "row": segment.get("row", 0),
            "segment": number,
            "tool_on": segment.get("tool_on", False),
            "pivot": segment.get("pivot", False),
            **({"dose": segment["dose"]} if "dose" in segment else {}),
        }
        features.append(_feature("LineString", line, properties))
    if document.get("home"):
        place = _rounded(frame.to_lon_lat([document["home"]]))[0]
        features.append(_feature("Point", place, {"kind": "home", "name": "Home"}))
    features += areas_of(statistics or {})
    return {"type": "FeatureCollection", "mission_id": document["mission_id"], "features": features}


def _treated_m(document: Mapping[str, Any], statistics: Mapping[str, Any]) -> float:
    """Return how wide one pass works: rows further apart than the tool is wide leave ground between them."""
    width_m: float = document["width_m"]
    return min(width_m, statistics.get(MACHINE, {}).get("tool_width_m") or width_m)


def areas_of(statistics: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the treatment areas a mission was planned with and the ground drawn on it since."""
    treatment = statistics.get("treatment") or {}
    doses = [
        _feature(one["geometry"]["type"], one["geometry"]["coordinates"], {"kind": "dose", "dose": one["dose"]})
        for one in treatment.get("areas", ())
    ]
    drawn = [
        _feature(
            "Polygon",
            [[*one["outline"], one["outline"][0]]],
            {"kind": one["kind"], "clearance_m": one["clearance_m"]},
        )
        for one in statistics.get("drawn_areas", ())
    ]
    return [*doses, *drawn]


def _lines(segments: Any, frame: LocalFrame) -> list[list[list[float]]]:
    """Project all segments at once; a parcel at half a metre has tens of thousands of points."""
    counts = [len(segment["points"]) for segment in segments]
    if not counts:
        return []
    places = _rounded(frame.to_lon_lat(np.concatenate([np.asarray(s["points"], dtype=float) for s in segments])))
    ends = np.cumsum(counts).tolist()
    return [places[end - count : end] for end, count in zip(ends, counts, strict=True)]


def _rounded(points: Any) -> list[list[float]]:
    rounded: list[list[float]] = np.round(np.asarray(points, dtype=float), DIGITS).tolist()
    return rounded


def _feature(kind: str, coordinates: Any, properties: dict[str, Any]) -> dict[str, Any]:
    return {"type": "Feature", "properties": properties, "geometry": {"type": kind, "coordinates": coordinates}}
