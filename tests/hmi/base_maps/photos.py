"""Small aerial photos and tile archives for tests."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import rasterio
from PIL import Image
from pmtiles.tile import Compression, TileType, zxy_to_tileid
from pmtiles.writer import Writer
from rasterio import Affine

GREEN, RED = (60, 140, 50), (220, 30, 30)
PIXEL_M = 0.5
CORNER = (77000.0, 423000.0)  # EPSG:28992, the Netherlands south of Rotterdam


def field(width: int = 200, height: int = 160) -> npt.NDArray[np.uint8]:
    """Return a green field, bands first."""
    picture = np.empty((3, height, width), np.uint8)
    picture[:] = np.array(GREEN, np.uint8)[:, None, None]
    return picture


def write_photo(path: Path, picture: npt.NDArray[Any] | None = None, **profile: Any) -> Path:
    """Write a GeoTIFF with its north-west corner at ``CORNER``."""
    shown = field() if picture is None else picture
    wanted = {
        "driver": "GTiff", "count": shown.shape[0], "height": shown.shape[1], "width": shown.shape[2],
        "dtype": shown.dtype.name, "crs": "EPSG:28992",
        "transform": Affine.translation(*CORNER) @ Affine.scale(PIXEL_M, -PIXEL_M), **profile,
    }  # fmt: skip
    with rasterio.open(path, "w", **wanted) as out:
        out.write(shown)
    return path


def picture_tile(colour: tuple[int, int, int], kind: str = "PNG", edge_px: int = 256) -> bytes:
    """Return one tile of one colour."""
    out = io.BytesIO()
    Image.new("RGB", (edge_px, edge_px), colour).save(out, kind)
    return out.getvalue()


def write_archive(path: Path, tiles: dict[tuple[int, int, int], bytes], metadata: Any = None, **header: Any) -> Path:
    """Write a PMTiles archive of these tiles."""
    with path.open("wb") as file:
        writer = Writer(file)
        for place in sorted(tiles, key=lambda one: zxy_to_tileid(*one)):
            writer.write_tile(zxy_to_tileid(*place), tiles[place])
        wanted = {
            "tile_type": TileType.PNG, "tile_compression": Compression.NONE, "min_lon_e7": int(4.2e7),
            "min_lat_e7": int(51.7e7), "max_lon_e7": int(4.3e7), "max_lat_e7": int(51.8e7), **header,
        }  # fmt: skip
        writer.finalize(wanted, metadata or {})
    return path


def patched(data: bytes, at: int, value: bytes) -> bytes:
    """Return bytes with some of them replaced."""
    return data[:at] + value + data[at + len(value) :]
