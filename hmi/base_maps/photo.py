"""Aerial photos: GeoTIFF in, tile archive in web mercator out. Runs in a process of its own, see ``worker``."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hmi.base_maps import limits
from hmi.base_maps.errors import BadBaseMap
from hmi.base_maps.facts import BaseMapFacts, BaseMapKind, Bounds
from hmi.base_maps.gdal_fence import DRIVER, shut_in
from hmi.base_maps.photo_colours import Colours, colours_of

EQUATOR_M = 2 * math.pi * 6378137.0
TILE_PX = 512
FARTHER = 2  # zooms after the one at which the whole photo fits into one tile
SHARPNESS = 0.25  # zooms by which a pixel of the photo may be coarsened; the next zoom would take four times the disk
POLES_DEG = 85.05
_STEPS = ((0, 0), (1, 0), (0, 1))

_NO_RASTERIO = "This installation cannot read GeoTIFF: the package rasterio is missing. Install it, or upload PMTiles."
_UNREADABLE = "This GeoTIFF cannot be read: {why}. Save it again from QGIS or the program that made it."


@dataclass(frozen=True, slots=True)
class Grid:
    """The tiles of the nearest zoom that the photo touches."""

    zoom: int
    column: int
    row: int
    columns: int
    rows: int

    @property
    def pixel_m(self) -> float:
        """Mercator metres of a pixel."""
        return EQUATOR_M / (TILE_PX * 2.0**self.zoom)

    @property
    def corner_m(self) -> tuple[float, float]:
        """North-west corner in EPSG:3857 metres, (east, north)."""
        tile_m = self.pixel_m * TILE_PX
        return self.column * tile_m - EQUATOR_M / 2, EQUATOR_M / 2 - self.row * tile_m


def convert_photo(source: Path, target: Path, most_bytes: int, told: Any) -> BaseMapFacts:
    """Make a tile archive of a GeoTIFF.

    Args:
        most_bytes: the archive may not be larger.
        told: called with the share that is done, 0 to 1.

    Raises:
        BadBaseMap: see the texts.
        MemoryError: it needs more than the process may have.
    """
    shut_in(target.parent)
    try:
        import rasterio
        from rasterio._err import CPLE_BaseError
        from rasterio.errors import RasterioError
    except ImportError as error:
        raise BadBaseMap("no_rasterio", _NO_RASTERIO) from error
    try:
        with rasterio.Env(), rasterio.open(source, driver=DRIVER) as photo:
            check_size(photo)
            check_place(photo)
            grid, bounds = grid_of(photo)
            colours = colours_of(photo)
            least = farthest(grid)
            _cut(photo, grid, least, colours, bounds, target, most_bytes, told)
    except (RasterioError, CPLE_BaseError, SystemError) as error:  # GDAL's own errors come as either
        raise BadBaseMap("unreadable", _UNREADABLE.format(why=_first_words(error, source))) from error
    return BaseMapFacts(BaseMapKind.PHOTO, bounds, least, grid.zoom, TILE_PX, "", "image/webp", "")


def check_size(photo: Any) -> None:
    """Refuse a photo whose pixels would take hours or all memory; raises ``BadBaseMap``."""
    pixels = photo.width * photo.height
    if pixels > limits.PIXELS or max(photo.width, photo.height) > limits.SIDE_PIXELS:
        text = (
            f"The photo has {photo.width:,} x {photo.height:,} pixels; {limits.PIXELS // 1_000_000:,} million are "
            "allowed. Cut it to the farm, or save it with larger pixels."
        )
        raise BadBaseMap("too_many_pixels", text)
    is_together = "PIXEL" in str(getattr(photo.interleaving, "value", "")).upper()
    bands = photo.count if is_together else 1
    high, wide = max(photo.block_shapes)
    if high * wide * bands * max(_bytes_of(one) for one in photo.dtypes) > limits.BLOCK_BYTES:
        text = "The photo is stored in one piece, which needs too much memory. Save it tiled: in QGIS TILED=YES."
        raise BadBaseMap("untiled", text)


def check_place(photo: Any) -> None:
    """Refuse a photo that does not say where it lies; raises ``BadBaseMap``."""
    if photo.crs is None or photo.transform.is_identity or photo.transform.is_degenerate:
        text = (
            "The photo does not say where it lies. Save it as GeoTIFF with its coordinate system inside: "
            "in QGIS Export, Save As, CRS. A .tfw file beside it is not enough."
        )
        raise BadBaseMap("no_coordinates", text)


def grid_of(photo: Any) -> tuple[Grid, Bounds]:
    """Return the tiles a photo touches and where it lies; raises ``BadBaseMap``."""
    from rasterio._err import CPLE_BaseError  # what transformations raise; rasterio has no public name for it
    from rasterio.errors import RasterioError
    from rasterio.warp import transform_bounds

    try:
        west, south, east, north = transform_bounds(photo.crs, "EPSG:4326", *photo.bounds)
        pixel_m = _pixel_m(photo)
    except (RasterioError, CPLE_BaseError) as error:
        text = "The coordinate system of the photo is not known here. Save it in WGS84, UTM or the national grid."
        raise BadBaseMap("coordinate_system", text) from error
    is_placed = all(math.isfinite(one) for one in (west, south, east, north))
    if not is_placed or pixel_m <= 0 or not (-180 <= west < east <= 180 and -POLES_DEG <= south < north <= POLES_DEG):
        raise BadBaseMap("place", "The photo lies outside the map of the Earth. Check its coordinate system.")
    zoom = math.ceil(math.log2(EQUATOR_M / (TILE_PX * pixel_m)) - SHARPNESS)
    zoom = max(0, min(zoom, limits.NEAREST_ZOOM))
    left, top = _tile_at(west, north, zoom)
    right, bottom = _tile_at(east, south, zoom)
    grid = Grid(zoom, left, top, right - left + 1, bottom - top + 1)
    if grid.columns * grid.rows > limits.TILES:
        raise BadBaseMap("too_many_pixels", "The photo covers too much ground. Cut it to the farm.")
    return grid, Bounds(west, south, east, north)


def farthest(grid: Grid) -> int:
    """Return the zoom from which on the photo would be a dot."""
    whole = math.ceil(math.log2(max(grid.columns, grid.rows)))
    return max(0, grid.zoom - whole - FARTHER)


def _cut(
    photo: Any, grid: Grid, least: int, colours: Colours, bounds: Bounds, target: Path, most_bytes: int, told: Any
) -> None:
    from rasterio import Affine
    from rasterio.enums import Resampling
    from rasterio.vrt import WarpedVRT
    from rasterio.windows import Window

    from hmi.base_maps.pyramid import Pyramid

    east_m, north_m = grid.corner_m
    size = {"width": grid.columns * TILE_PX, "height": grid.rows * TILE_PX}
    # colours between two numbers of a palette would be any colours
    smooth = Resampling.nearest if colours.palette is not None else Resampling.bilinear
    placed = Affine(grid.pixel_m, 0, east_m, 0, -grid.pixel_m, north_m)
    pyramid = Pyramid(target, (least, grid.zoom), (grid.column, grid.row), most_bytes)
    try:
        with WarpedVRT(
            photo, crs="EPSG:3857", transform=placed, resampling=smooth,
            add_alpha=not colours.has_alpha, warp_mem_limit=64, **size,
        ) as laid:  # fmt: skip
            for row in range(grid.rows):
                for column in range(grid.columns):
                    window = Window(column * TILE_PX, row * TILE_PX, TILE_PX, TILE_PX)
                    pyramid.add(column, row, colours.picture(laid, window))
                    told((row * grid.columns + column + 1) / (grid.rows * grid.columns))
        pyramid.finish(bounds, "")
    finally:
        pyramid.close()


def _pixel_m(photo: Any) -> float:
    """Return the edge of the pixel in the middle of a photo, in mercator metres; 0 where there is no such place."""
    from rasterio.warp import transform

    middle = (photo.width / 2, photo.height / 2)
    east, north = zip(*(photo.transform @ (middle[0] + right, middle[1] + down) for right, down in _STEPS), strict=True)
    x, y = transform(photo.crs, "EPSG:3857", list(east), list(north))
    if not all(math.isfinite(one) for one in (*x, *y)):
        return 0.0
    return min(math.hypot(x[i] - x[0], y[i] - y[0]) for i in (1, 2))


def _tile_at(lon_deg: float, lat_deg: float, zoom: int) -> tuple[int, int]:
    last = 2**zoom - 1
    x = (lon_deg + 180) / 360
    y = 0.5 - math.log(math.tan(math.pi / 4 + math.radians(lat_deg) / 2)) / (2 * math.pi)
    return min(last, max(0, int(x * 2**zoom))), min(last, max(0, int(y * 2**zoom)))


def _bytes_of(dtype: str) -> int:
    import numpy as np

    return int(np.dtype(dtype).itemsize)


def _first_words(error: Exception, source: Path) -> str:
    words = " ".join(str(error.__cause__ or error).split()).replace(str(source), "the file")
    return words[:120].rstrip(".")
