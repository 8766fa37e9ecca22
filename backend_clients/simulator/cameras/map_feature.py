"""A feature of the farm's map, as the simulator is told it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class MapFeature:
    """One feature; geometry as in GeoJSON, degrees."""

    kind: str
    name: str
    properties: Mapping[str, Any]
    geometry: Mapping[str, Any]
