"""What the readers of the single formats hand over: shapes as the file tells them, nothing checked."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from hmi.map_files.coordinate_system import CoordinateSystem
from hmi.map_files.imported import Skipped


@dataclass(slots=True)
class SourceFeature:
    """One feature of a file.

    Attributes:
        which: how the operator finds it: number and, where known, name.
        geometry: GeoJSON of any type, in the coordinates of the file.
        name: where the format has a place of its own for it.
        kind: what the format says it is, in the words of the farm map.
        crs: its own, where it differs from its layer's.
        site: number of the field of the file that it belongs to, where the format says it.
        is_exact: written by this program: names and values stand as they are.
    """

    which: str
    geometry: Any
    properties: dict[str, Any] = field(default_factory=dict)
    name: str | None = None
    kind: str | None = None
    id: str | None = None
    crs: CoordinateSystem | None = None
    problems: list[str] = field(default_factory=list)
    is_exact: bool = False
    site: int | None = None


@dataclass(slots=True)
class SourceLayer:
    """Features that share a coordinate system; ``crs`` is None where the file does not say it."""

    name: str
    crs: CoordinateSystem | None
    features: list[SourceFeature]


@dataclass(slots=True)
class Source:
    """A file, read."""

    format: str
    layers: list[SourceLayer]
    skipped: list[Skipped] = field(default_factory=list)
