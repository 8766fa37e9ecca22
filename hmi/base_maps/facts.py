"""What is known of a base map once it was read."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class BaseMapKind(StrEnum):
    """What a base map was made of, which decides how it is drawn."""

    PHOTO = "photo"
    RASTER = "raster"
    VECTOR = "vector"


@dataclass(frozen=True, slots=True)
class Bounds:
    """Box in WGS84 degrees."""

    west_deg: float
    south_deg: float
    east_deg: float
    north_deg: float


@dataclass(frozen=True, slots=True)
class BaseMapFacts:
    """Contents of a tile archive.

    Attributes:
        tile_px: edge of a raster tile; 0 for vector tiles.
        schema: names of the layers of vector tiles, ``protomaps`` or ``openmaptiles``; empty for rasters.
        media_type: of a tile.
        credit: who must be named beside the picture, plain text.
    """

    kind: BaseMapKind
    bounds: Bounds
    min_zoom: int
    max_zoom: int
    tile_px: int
    schema: str
    media_type: str
    credit: str


@dataclass(frozen=True, slots=True)
class MadeBaseMap:
    """A tile archive that is ready to be kept; ``sha256`` is that of its bytes."""

    facts: BaseMapFacts
    sha256: str
    size_bytes: int
