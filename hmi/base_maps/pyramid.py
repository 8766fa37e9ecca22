"""A picture cut into web mercator tiles, with all smaller zooms, row by row and in little memory."""

from __future__ import annotations

import io
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from pmtiles.tile import Compression, TileType, zxy_to_tileid
from pmtiles.writer import Writer

from hmi.base_maps.errors import BadBaseMap
from hmi.base_maps.facts import Bounds

TILE_PX = 512
QUALITY = 82  # leaves of a beet row stay crisp; 90 doubles the size
EFFORT = 1  # of the WebP encoder; 4 takes four times as long for a tenth less

Picture = npt.NDArray[np.uint8]
"""Rows, columns, RGBA."""


class Pyramid:
    """Takes the tiles of the nearest zoom row by row, writes them and everything above them.

    Args:
        size: columns and rows of tiles at the nearest zoom.
        origin: column and row of its first tile, counted over the whole world.
        zooms: farthest and nearest.
        most_bytes: the archive may not be larger.
    """

    def __init__(self, path: Path, zooms: tuple[int, int], origin: tuple[int, int], most_bytes: int) -> None:
        self._path = path
        self._file = path.open("wb")
        self._writer: Any = Writer(self._file)  # type: ignore[no-untyped-call]
        self._writer.tile_f.close()
        self._writer.tile_f = tempfile.TemporaryFile(dir=path.parent)  # noqa: SIM115 - not in /tmp, which may be memory
        self._zooms, self._origin = zooms, origin
        self._rows: dict[int, tuple[int, dict[int, Picture]]] = {}
        self._bytes = 0
        self._most_bytes = most_bytes
        self.tiles = 0

    def add(self, column: int, row: int, picture: Picture) -> None:
        """Take one tile of the nearest zoom; rows come in order from the north."""
        nearest = self._zooms[1]
        self._take(nearest, self._origin[0] + column, self._origin[1] + row, picture)

    def finish(self, bounds: Bounds, credit: str) -> None:
        """Write what is left and the head of the archive; raises ``BadBaseMap`` when nothing was seen."""
        for zoom in range(self._zooms[1] - 1, self._zooms[0] - 1, -1):
            self._flush(zoom)
        if not self.tiles:
            raise BadBaseMap("empty", "The photo is empty: every pixel of it is transparent or without data.")
        e7 = {key: round(value * 1e7) for key, value in (
            ("min_lon_e7", bounds.west_deg), ("min_lat_e7", bounds.south_deg),
            ("max_lon_e7", bounds.east_deg), ("max_lat_e7", bounds.north_deg),
        )}  # fmt: skip
        header = {"tile_type": TileType.WEBP, "tile_compression": Compression.NONE, **e7}
        self._writer.finalize(header, {"attribution": credit, "type": "overlay", "tileSize": TILE_PX})
        self._file.close()

    def close(self) -> None:
        """Let go of the files."""
        self._file.close()
        self._writer.tile_f.close()

    def _take(self, zoom: int, x: int, y: int, picture: Picture) -> None:
        if not picture[..., 3].any():
            return
        self._write(zoom, x, y, picture)
        if zoom <= self._zooms[0]:
            return
        above = zoom - 1
        row, waiting = self._rows.get(above, (y // 2, {}))
        if row != y // 2:
            self._flush(above)
            row, waiting = y // 2, {}
        self._rows[above] = (row, waiting)
        parent = waiting.get(x // 2)
        if parent is None:
            parent = waiting[x // 2] = np.zeros((TILE_PX, TILE_PX, 4), np.uint8)
        half = TILE_PX // 2
        top, left = (y % 2) * half, (x % 2) * half
        parent[top : top + half, left : left + half] = halved(picture)

    def _flush(self, zoom: int) -> None:
        row, waiting = self._rows.pop(zoom, (0, {}))
        for x in sorted(waiting):
            self._take(zoom, x, row, waiting[x])

    def _write(self, zoom: int, x: int, y: int, picture: Picture) -> None:
        data = encoded(picture)
        self._bytes += len(data)
        if self._bytes > self._most_bytes:
            raise BadBaseMap(
                "no_room",
                f"The photo needs more than the {self._most_bytes // 1_000_000} MB that are left for base maps of "
                "this farm. Delete one that is not needed, or save the photo with larger pixels.",
            )
        self._writer.write_tile(zxy_to_tileid(zoom, x, y), data)
        self.tiles += 1


def halved(picture: Picture) -> Picture:
    """Return a picture of half the size; pixels without data do not darken their neighbours."""
    from PIL import Image

    # averaged with the colours weighted by their alpha
    return np.asarray(Image.fromarray(picture).convert("RGBa").reduce(2).convert("RGBA"))


def encoded(picture: Picture) -> bytes:
    """Return a picture as WebP, without its alpha where all of it is opaque."""
    from PIL import Image

    is_opaque = bool((picture[..., 3] == 255).all())
    shown = Image.fromarray(np.ascontiguousarray(picture[..., :3] if is_opaque else picture))
    out = io.BytesIO()
    shown.save(out, "WEBP", quality=QUALITY, method=EFFORT)
    return out.getvalue()


Progress = Callable[[float], None]
"""Hears the share that is done, 0 to 1."""
