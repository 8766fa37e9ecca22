"""Look into an uploaded tile archive and say what it is, or why it cannot be used. Runs in a process of its own."""

from __future__ import annotations

import html
import io
import re
from pathlib import Path
from typing import Any

from pmtiles.tile import TileType

from hmi.base_maps import limits
from hmi.base_maps.archive import TileArchive
from hmi.base_maps.directory import unpacked
from hmi.base_maps.errors import BadBaseMap
from hmi.base_maps.facts import BaseMapFacts, BaseMapKind, Bounds
from hmi.base_maps.schema import schema_of

_TAG = re.compile(r"<[^<>]{0,500}>")
_FORMATS = {TileType.PNG: "PNG", TileType.JPEG: "JPEG", TileType.WEBP: "WEBP"}
_TILE_EDGES = (256, 512, 1024)


def inspect_archive(path: Path) -> BaseMapFacts:
    """Return what a PMTiles archive holds; raises ``BadBaseMap``."""
    archive = TileArchive(path)
    header = archive.header
    metadata = archive.metadata()
    _, tile = archive.some_tile()
    is_vector = header["tile_type"] is TileType.MVT
    if is_vector:
        unpacked(tile, header["tile_compression"], limits.TILE_BYTES * 4)
    return BaseMapFacts(
        kind=BaseMapKind.VECTOR if is_vector else BaseMapKind.RASTER,
        bounds=Bounds(*(header[key] / 1e7 for key in ("min_lon_e7", "min_lat_e7", "max_lon_e7", "max_lat_e7"))),
        min_zoom=header["min_zoom"],
        max_zoom=header["max_zoom"],
        tile_px=0 if is_vector else _edge_px(tile, header["tile_type"]),
        schema=schema_of(metadata) if is_vector else "",
        media_type=archive.media_type,
        credit=credit_of(metadata),
    )


def credit_of(metadata: dict[str, Any]) -> str:
    """Return who must be named, without the markup that writers put around it."""
    raw = metadata.get("attribution")
    if not isinstance(raw, str):
        return ""
    plain = html.unescape(_TAG.sub("", raw[:5000]))
    return " ".join("".join(c if c.isprintable() else " " for c in plain).split())[: limits.CREDIT_CHARS]


def _edge_px(tile: bytes, kind: TileType) -> int:
    from PIL import Image, UnidentifiedImageError

    try:
        with Image.open(io.BytesIO(tile), formats=(_FORMATS[kind],)) as picture:
            width, height = picture.size
    except (UnidentifiedImageError, OSError, ValueError, Image.DecompressionBombError) as error:
        text = f"Its tiles should be {_FORMATS[kind].lower()} pictures, but they are not. Write the file anew."
        raise BadBaseMap("tile_type", text) from error
    if width != height or width not in _TILE_EDGES:
        text = f"Its tiles are {width} x {height} pixels. Write them with 256 or 512 pixels on each side."
        raise BadBaseMap("tile_size", text)
    return int(width)
