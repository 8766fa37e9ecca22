"""Tile archives of strangers: what is good is read, what is not is refused with what to do."""

from __future__ import annotations

import gzip
import struct
from pathlib import Path
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pmtiles.tile import Compression, Entry, TileType, serialize_directory

from hmi.base_maps.archive import TileArchive, checked_header
from hmi.base_maps.directory import directory, unpacked
from hmi.base_maps.errors import BadBaseMap
from hmi.base_maps.facts import BaseMapKind
from hmi.base_maps.inspection import inspect_archive
from tests.hmi.base_maps.photos import patched, picture_tile, write_archive

PLACE = (12, 2096, 1357)
ROADS = {"vector_layers": [{"id": name} for name in ("earth", "water", "roads", "pois")]}


@pytest.fixture
def archive(tmp_path: Path) -> Path:
    tiles = {PLACE: picture_tile((1, 2, 3)), (13, 4192, 2714): picture_tile((4, 5, 6))}
    return write_archive(tmp_path / "map.pmtiles", tiles, {"attribution": '<a href="x">&copy; Survey</a>\x07 2026'})


def test_a_good_archive_says_where_it_lies_and_gives_its_tiles(archive: Path) -> None:
    facts = inspect_archive(archive)
    assert (facts.kind, facts.min_zoom, facts.max_zoom, facts.tile_px) == (BaseMapKind.RASTER, 12, 13, 256)
    assert (facts.bounds.west_deg, facts.bounds.north_deg) == (pytest.approx(4.2), pytest.approx(51.8))
    assert facts.media_type == "image/png"
    opened = TileArchive(archive)
    assert opened.tile(*PLACE) == picture_tile((1, 2, 3))
    assert opened.tile(12, 0, 0) is None
    assert opened.tile(12, 5000, 0) is None


def test_the_source_of_a_map_is_named_without_its_markup(archive: Path) -> None:
    assert inspect_archive(archive).credit == "© Survey 2026"


def test_thousands_of_tiles_lie_in_directories_of_their_own(tmp_path: Path) -> None:
    random = Random(1)
    tiles = {(8, x, y): random.randbytes(random.randint(1, 500)) for x in range(140) for y in range(140)}
    opened = TileArchive(write_archive(tmp_path / "many.pmtiles", tiles))
    assert opened.header["leaf_directory_length"] > 0
    for place in ((8, 0, 0), (8, 139, 139), (8, 41, 7)):
        assert opened.tile(*place) == tiles[place]


@pytest.mark.parametrize(
    ("at", "value", "code"),
    [
        (0, b"GIF89a.", "not_pmtiles"),
        (7, b"\x02", "old_version"),
        (97, b"\x09", "damaged"),
        (97, b"\x03", "packing"),
        (98, b"\x04", "packing"),
        (99, b"\x05", "tile_type"),
        (100, b"\x0e\x0d", "zooms"),
        (101, b"\x40", "zooms"),
        (102, struct.pack("<i", 2_000_000_000), "bounds"),
        (102, struct.pack("<iiii", 0, 0, 0, 0), "bounds"),
        (16, struct.pack("<Q", 2**60), "damaged"),
        (16, struct.pack("<Q", 0), "empty"),
        (56, struct.pack("<QQ", 2**63, 2**63), "damaged"),
    ],
)
def test_a_header_that_makes_no_sense_is_refused_with_what_to_do(
    archive: Path, at: int, value: bytes, code: str
) -> None:
    archive.write_bytes(patched(archive.read_bytes(), at, value))
    with pytest.raises(BadBaseMap) as refused:
        inspect_archive(archive)
    assert refused.value.code == code
    assert refused.value.text.endswith((".", "pmtiles"))


def test_a_file_that_was_cut_off_is_refused(archive: Path) -> None:
    whole = archive.read_bytes()
    for length in (3, 100, 140, len(whole) - 1):
        archive.write_bytes(whole[:length])
        with pytest.raises(BadBaseMap):
            inspect_archive(archive)


def test_a_directory_that_unpacks_to_gigabytes_is_refused_before_it_does() -> None:
    bomb = gzip.compress(b"\1" * 60_000_000)
    with pytest.raises(BadBaseMap) as refused:
        directory(bomb, Compression.GZIP)
    assert refused.value.code == "too_large"
    with pytest.raises(BadBaseMap):
        unpacked(gzip.compress(b" " * 9_000_000), Compression.GZIP, 1_000_000)


def test_directories_that_point_at_each_other_end(tmp_path: Path) -> None:
    root = serialize_directory([Entry(0, 0, 30, 0)])
    loop = serialize_directory([Entry(0, 0, len(root), 0)])
    head = write_archive(tmp_path / "a", {PLACE: b"x"}).read_bytes()[:127]
    places = struct.pack("<8Q", 127, len(loop), 0, 0, 127, len(loop), 127, len(loop))
    path = tmp_path / "loop.pmtiles"
    path.write_bytes(patched(head, 8, places) + loop)
    with pytest.raises(BadBaseMap):
        TileArchive(path).tile(0, 0, 0)


@given(st.binary(max_size=200))
def test_no_directory_of_noise_does_more_than_be_refused(noise: bytes) -> None:
    try:
        entries = directory(noise, Compression.NONE)
    except BadBaseMap:
        return
    assert entries == sorted(entries, key=lambda one: one.tile_id)


@given(st.binary(min_size=120, max_size=120), st.integers(0, 10_000))
def test_no_header_of_noise_does_more_than_be_refused(noise: bytes, size: int) -> None:
    try:
        header = checked_header(b"PMTiles\3" + noise[1:], size)
    except BadBaseMap:
        return
    assert header["min_zoom"] <= header["max_zoom"]


def test_tiles_that_are_no_pictures_or_of_an_odd_size_are_refused(tmp_path: Path) -> None:
    for tile, code in ((b"<svg onload=alert(1)>", "tile_type"), (picture_tile((0, 0, 0), edge_px=300), "tile_size")):
        with pytest.raises(BadBaseMap) as refused:
            inspect_archive(write_archive(tmp_path / "odd.pmtiles", {PLACE: tile}))
        assert refused.value.code == code


def test_a_vector_map_with_known_layers_is_taken_and_one_with_others_explained(tmp_path: Path) -> None:
    how = {"tile_type": TileType.MVT, "tile_compression": Compression.GZIP}
    tiles = {PLACE: gzip.compress(b"")}
    facts = inspect_archive(write_archive(tmp_path / "v.pmtiles", tiles, ROADS, **how))
    assert (facts.kind, facts.schema, facts.tile_px) == (BaseMapKind.VECTOR, "protomaps", 0)
    with pytest.raises(BadBaseMap) as refused:
        inspect_archive(write_archive(tmp_path / "w.pmtiles", tiles, {"vector_layers": [{"id": "wells"}]}, **how))
    assert refused.value.code == "schema"
    assert "wells" in refused.value.text
