"""Aerial photos become tiles: the right colour at the right place, and no harm from a bad file."""

from __future__ import annotations

import asyncio
import io
import math
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from rasterio.crs import CRS
from rasterio.warp import transform

from hmi.base_maps import limits
from hmi.base_maps.archive import TileArchive
from hmi.base_maps.errors import BadBaseMap
from hmi.base_maps.facts import BaseMapFacts
from hmi.base_maps.photo import convert_photo
from hmi.base_maps.worker import BaseMapMaker
from tests.hmi.base_maps.photos import CORNER, GREEN, PIXEL_M, RED, field, write_photo

ROOM = 50_000_000
HALL = 'LOCAL_CS["hall",UNIT["metre",1]]'
SQUARE = (120, 40, 8)  # column, row, edge of the red square, pixels of the photo


def no_progress(_share: float) -> None:
    """Hear nothing."""


def converted(source: Path, room: int = ROOM) -> tuple[BaseMapFacts, TileArchive]:
    """Convert in this process."""
    target = source.with_suffix(".pmtiles")
    facts = convert_photo(source, target, room, no_progress)
    return facts, TileArchive(target)


def colour_at(archive: TileArchive, zoom: int, lon: float, lat: float) -> tuple[int, ...]:
    """Return RGBA of the tiles at a position."""
    x = (lon + 180) / 360 * 2**zoom
    y = (0.5 - math.log(math.tan(math.pi / 4 + math.radians(lat) / 2)) / (2 * math.pi)) * 2**zoom
    data = archive.tile(zoom, int(x), int(y))
    if data is None:
        return (0, 0, 0, 0)
    picture = Image.open(io.BytesIO(data)).convert("RGBA")
    pixel = picture.getpixel((int(x % 1 * picture.width), int(y % 1 * picture.height)))
    assert isinstance(pixel, tuple)
    return pixel


def lon_lat(
    column: float, row: float, crs: str = "EPSG:28992", corner: tuple[float, float] = CORNER
) -> tuple[float, float]:
    """Return the position of a pixel's place, by the coordinate system itself."""
    east, north = corner[0] + column * PIXEL_M, corner[1] - row * PIXEL_M
    (lon,), (lat,) = transform(crs, "EPSG:4326", [east], [north])
    return lon, lat


def is_near(colour: tuple[int, ...], wanted: tuple[int, ...], by: int = 40) -> bool:
    """Say whether a colour is the wanted one, after a lossy picture format."""
    return len(colour) == 4 and colour[3] == 255 and all(abs(a - b) <= by for a, b in zip(colour, wanted, strict=False))


@pytest.mark.parametrize(("crs", "corner"), [("EPSG:28992", CORNER), ("EPSG:32631", (590000.0, 5738000.0))])
def test_a_known_pixel_lands_where_its_coordinates_say(tmp_path: Path, crs: str, corner: tuple[float, float]) -> None:
    from rasterio import Affine

    picture = field()
    column, row, edge = SQUARE
    picture[:, row : row + edge, column : column + edge] = np.array(RED, np.uint8)[:, None, None]
    placed = Affine.translation(*corner) @ Affine.scale(PIXEL_M, -PIXEL_M)
    facts, archive = converted(write_photo(tmp_path / "photo.tif", picture, crs=crs, transform=placed))
    middle = lon_lat(column + edge / 2, row + edge / 2, crs, corner)
    assert is_near(colour_at(archive, facts.max_zoom, *middle), RED)
    outside_m = edge / 2 * PIXEL_M + 1.0  # a metre beside the square it is green again
    for right, down in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        away = outside_m / PIXEL_M
        place = lon_lat(column + edge / 2 + right * away, row + edge / 2 + down * away, crs, corner)
        assert is_near(colour_at(archive, facts.max_zoom, *place), GREEN)
    assert is_near(colour_at(archive, facts.min_zoom + 2, *lon_lat(50, 80, crs, corner)), GREEN)


def test_outside_of_the_photo_the_tiles_are_clear(tmp_path: Path) -> None:
    facts, archive = converted(write_photo(tmp_path / "photo.tif"))
    assert colour_at(archive, facts.max_zoom, *lon_lat(-4, 20))[3] == 0
    assert facts.bounds.west_deg < lon_lat(100, 80)[0] < facts.bounds.east_deg


def test_pixels_without_data_are_clear_and_do_not_darken_the_rest(tmp_path: Path) -> None:
    picture = field()
    picture[:, :, :100] = 0
    facts, archive = converted(write_photo(tmp_path / "photo.tif", picture, nodata=0))
    assert colour_at(archive, facts.max_zoom, *lon_lat(40, 80))[3] == 0
    assert is_near(colour_at(archive, facts.max_zoom, *lon_lat(150, 80)), GREEN)


def test_a_photo_of_16_bits_is_stretched_to_what_the_eye_sees(tmp_path: Path) -> None:
    picture = field().astype(np.uint16) * 10
    picture[:, :80] //= 4
    facts, archive = converted(write_photo(tmp_path / "photo.tif", picture))
    bright, dark = (colour_at(archive, facts.max_zoom, *lon_lat(100, row)) for row in (120, 20))
    assert sum(bright[:3]) > sum(dark[:3]) + 150


def test_grey_and_indexed_photos_keep_their_colours(tmp_path: Path) -> None:
    import rasterio

    facts, archive = converted(write_photo(tmp_path / "grey.tif", field()[:1]))
    grey = colour_at(archive, facts.max_zoom, *lon_lat(100, 80))
    assert is_near(grey, (GREEN[0],) * 3, 12)
    indexed = write_photo(tmp_path / "index.tif", np.full((1, 160, 200), 7, np.uint8), photometric="PALETTE")
    with rasterio.open(indexed, "r+") as out:
        out.write_colormap(1, {7: (*RED, 255)})
    facts, archive = converted(indexed)
    assert is_near(colour_at(archive, facts.max_zoom, *lon_lat(100, 80)), RED)


@pytest.mark.parametrize(
    ("change", "code"),
    [({"crs": None}, "no_coordinates"), ({"crs": CRS.from_string(HALL)}, "coordinate_system"),
     ({"crs": "EPSG:32760"}, "place")],
)  # fmt: skip
def test_a_photo_that_cannot_be_placed_is_refused(tmp_path: Path, change: dict[str, object], code: str) -> None:
    if code == "place":
        from rasterio import Affine

        change = {**change, "transform": Affine.translation(9e7, 9e7) @ Affine.scale(1, -1)}
    with pytest.raises(BadBaseMap) as refused:
        converted(write_photo(tmp_path / "photo.tif", **change))
    assert refused.value.code in (code, "coordinate_system", "place")
    assert "Save it" in refused.value.text or "Check" in refused.value.text


@pytest.mark.filterwarnings("ignore::rasterio.errors.NotGeoreferencedWarning")
def test_a_world_file_beside_a_photo_is_not_read(tmp_path: Path) -> None:
    from rasterio import Affine

    source = write_photo(tmp_path / "photo.tif", transform=Affine.identity())
    (tmp_path / "photo.tfw").write_text("0.5\n0\n0\n-0.5\n77000\n423000\n")
    with pytest.raises(BadBaseMap) as refused:
        converted(source)
    assert refused.value.code == "no_coordinates"
    assert ".tfw" in refused.value.text


def test_heights_are_no_photo(tmp_path: Path) -> None:
    with pytest.raises(BadBaseMap) as refused:
        converted(write_photo(tmp_path / "dem.tif", np.ones((1, 50, 50), np.float32)))
    assert refused.value.code == "not_a_picture"


def test_a_small_file_that_claims_a_million_million_pixels_is_refused_at_once(tmp_path: Path) -> None:
    bomb = write_photo(tmp_path / "bomb.tif", np.zeros((1, 8, 8), np.uint8), sparse_ok=True)
    data = bytearray(bomb.read_bytes())
    for tag, value in ((256, 390_000), (257, 390_000)):
        at = data.index(struct.pack("<HHI", tag, 3, 1))
        data[at : at + 12] = struct.pack("<HHII", tag, 4, 1, value)
    bomb.write_bytes(bytes(data))
    with pytest.raises(BadBaseMap) as refused:
        converted(bomb)
    assert refused.value.code in ("too_many_pixels", "unreadable")


def test_an_archive_that_would_not_fit_is_given_up(tmp_path: Path) -> None:
    noise = np.random.default_rng(1).integers(0, 255, (3, 600, 600), dtype=np.uint8)
    with pytest.raises(BadBaseMap) as refused:
        converted(write_photo(tmp_path / "photo.tif", noise), room=20_000)
    assert refused.value.code == "no_room"


def test_an_empty_photo_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadBaseMap) as refused:
        converted(write_photo(tmp_path / "photo.tif", field() * 0, nodata=0))
    assert refused.value.code == "empty"


FENCED = """
import sys
from pathlib import Path
from hmi.base_maps.gdal_fence import shut_in
shut_in(Path(sys.argv[1]))
import rasterio
from hmi.base_maps.errors import BadBaseMap
from hmi.base_maps.photo import convert_photo
try:
    convert_photo(Path(sys.argv[2]), Path(sys.argv[1]) / "out", 10**7, lambda share: None)
except BadBaseMap as error:
    print(error.code)
with rasterio.Env() as env:
    print(sorted({"HTTP", "WMS", "WMTS", "WCS", "EEDA", "PLMOSAIC", "STACTA"} & set(env.drivers())))
"""


@pytest.mark.parametrize("asks", ["vrt", "curl"])
def test_a_file_that_points_at_others_is_refused_and_drivers_that_fetch_are_gone(tmp_path: Path, asks: str) -> None:
    inner = write_photo(tmp_path / "secret.tif")
    source = str(inner) if asks == "vrt" else "/vsicurl/http://127.0.0.1:9/x.tif"
    fake = tmp_path / "photo.tif"
    fake.write_text(
        '<VRTDataset rasterXSize="9" rasterYSize="9"><SRS>EPSG:28992</SRS><VRTRasterBand dataType="Byte" band="1">'
        f"<SimpleSource><SourceFilename>{source}</SourceFilename></SimpleSource></VRTRasterBand></VRTDataset>"
    )
    done = subprocess.run(
        [sys.executable, "-c", FENCED, str(tmp_path), str(fake)], capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == ["unreadable", "[]"]


@pytest.mark.slow
async def test_a_photo_is_converted_beside_the_console_and_tells_how_far_it_is(tmp_path: Path) -> None:
    source = write_photo(tmp_path / "upload")
    heard: list[float] = []
    made = await BaseMapMaker(niceness=0).make(source, tmp_path / "made", ROOM, heard.append)
    assert made.size_bytes == (tmp_path / "made").stat().st_size
    assert made.facts.kind.value == "photo"
    assert heard == sorted(heard)


async def test_a_file_that_is_neither_photo_nor_tiles_is_refused(tmp_path: Path) -> None:
    (tmp_path / "upload").write_bytes(b"%PDF-1.7 ...")
    with pytest.raises(BadBaseMap) as refused:
        await BaseMapMaker(niceness=0).make(tmp_path / "upload", tmp_path / "made", ROOM, no_progress)
    assert refused.value.code == "unknown_format"


async def test_a_photo_that_takes_too_long_is_given_up_and_its_process_ends(tmp_path: Path) -> None:
    source = write_photo(tmp_path / "upload")
    with pytest.raises(BadBaseMap) as refused:
        await BaseMapMaker(limit_s=0.01, niceness=0).make(source, tmp_path / "made", ROOM, no_progress)
    assert refused.value.code == "too_long"
    assert not [task for task in asyncio.all_tasks() if "base-map" in task.get_name()]


def test_a_photo_stored_in_one_piece_is_refused_before_it_fills_the_memory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    source = write_photo(tmp_path / "photo.tif")
    monkeypatch.setattr(limits, "BLOCK_BYTES", 1_000)
    with pytest.raises(BadBaseMap) as refused:
        converted(source)
    assert refused.value.code == "untiled"
    assert "TILED=YES" in refused.value.text


def test_the_limits_hold_the_photo_of_a_farm() -> None:
    hectares = 160
    assert hectares * 10_000 / 0.02**2 <= limits.PIXELS
