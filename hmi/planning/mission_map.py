"""A mission's document as GeoJSON for the map: parcel, path in driving order, home."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from hmi.planning.projection import LocalFrame

DIGITS = 7  # of longitude and latitude: a centimetre


def mission_geojson(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return a FeatureCollection: the parcel, then every segment in driving order, then home.

    A segment has ``kind``, ``row`` (0 off the rows), ``segment`` (its number from 0), ``pivot`` and ``tool_on``;
    the collection carries ``mission_id``, ``sha256`` is the caller's to add.
    """
    frame = LocalFrame(document["datum"]["lat_deg"], document["datum"]["lon_deg"])
    parcel = {
        "kind": "parcel",
        "name": document["field_name"],
        "width_m": document["width_m"],
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
        }
        features.append(_feature("LineString", line, properties))
    if document.get("home"):
        place = _rounded(frame.to_lon_lat([document["home"]]))[0]
        features.append(_feature("Point", place, {"kind": "home", "name": "Home"}))
    return {"type": "FeatureCollection", "mission_id": document["mission_id"], "features": features}


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
