"""The wire document of a mission as plain data: what is stored, hashed and sent.

The form is that of the edge contract's mission message; this layer knows it without the contract's code, and a
test holds the two together. Lengths in metres in the ENU plane of ``datum``, ``parcel`` in lon/lat degrees.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from typing import Any

import msgspec

Document = dict[str, Any]


def canonical(document: Mapping[str, Any]) -> Document:
    """Return the document with every field of the contract present, numbers as the contract types them.

    Raises:
        KeyError: a field without default is missing.
        TypeError, ValueError: a field is not a number where one belongs.
    """
    datum = document["datum"]
    home = document.get("home")
    whole: Document = {
        "v": 1,
        "robot": document["robot"],
        "mission_id": document["mission_id"],
        "revision": int(document["revision"]),
        "name": document["name"],
        "field_name": document["field_name"],
        "datum": {
            "lat_deg": float(datum["lat_deg"]),
            "lon_deg": float(datum["lon_deg"]),
            "height_m": float(datum.get("height_m", 0.0)),
        },
        "width_m": float(document["width_m"]),
        "area_m2": float(document["area_m2"]),
        "parcel": [_points(ring) for ring in document["parcel"]],
        "segments": [_segment(segment) for segment in document["segments"]],
        "note": document.get("note", ""),
        "at_end": document.get("at_end", "stay"),
        "home": None if home is None else [float(home[0]), float(home[1])],
    }
    for name, form in (("plant_spacing_m", float), ("map_version", _map_version), ("continues", _continues)):
        if document.get(name) is not None:  # a field of the contract that is left out, not null, where it is unknown
            whole[name] = form(document[name])
    return whole


def mission_sha256(document: Mapping[str, Any]) -> str:
    """Return the SHA-256 hex digest the robot reads back for this document."""
    return hashlib.sha256(msgspec.json.encode(canonical(document), order="sorted")).hexdigest()


def for_robot(document: Mapping[str, Any], robot_id: str) -> Document:
    """Return the document addressed to another robot; its hash changes with it."""
    return {**document, "robot": robot_id}


def renamed(document: Mapping[str, Any], *, mission_id: str | None = None, name: str | None = None) -> Document:
    """Return the document under another id or name."""
    return {**document, "mission_id": mission_id or document["mission_id"], "name": name or document["name"]}


def _map_version(given: Mapping[str, Any]) -> Document:
    return {"number": int(given["number"]), "sha256": given["sha256"]}


def _continues(given: Mapping[str, Any]) -> Document:
    return {"base_sha256": given["base_sha256"], "segments": int(given["segments"])}


def _segment(segment: Mapping[str, Any]) -> Document:
    # left out where they say nothing: a document of a robot that knows neither has the hash it always had
    marks = {name: True for name in ("jump", "backward") if segment.get(name)}
    whole: Document = {
        "kind": segment["kind"],
        "points": _points(segment["points"]),
        "speed_mps": float(segment["speed_mps"]),
        "tool_on": bool(segment.get("tool_on", False)),
        "row": int(segment.get("row", 0)),
        "pivot": bool(segment.get("pivot", False)),
        **marks,
    }
    # the contract leaves out a dose that nobody gave
    return {**whole, "dose": float(segment["dose"])} if "dose" in segment else whole


def _points(points: Sequence[Sequence[float]]) -> list[list[float]]:
    return [[float(x), float(y)] for x, y in points]


def drives_backward(document: Mapping[str, Any]) -> bool:
    """Say whether a part of the path is driven backwards."""
    return any(segment.get("backward") for segment in document.get("segments", ()))
