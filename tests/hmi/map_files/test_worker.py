"""Reading in a process of its own."""

from __future__ import annotations

import asyncio
import json
import tempfile
from collections.abc import AsyncIterator
from pathlib import Path

import psutil
import pytest

from hmi.map_files import limits
from hmi.map_files.errors import BadMapFile
from hmi.map_files.progress import Progress
from hmi.map_files.reader import read_map
from hmi.map_files.worker import MapReader
from tests.hmi.map_files import samples

KML = samples.file("farm.kml")
MANY = json.dumps([{"type": "LineString", "coordinates": [[5, 52], [5, 53 + n / 1e4]]} for n in range(3000)]).encode()
SLOW = json.dumps([{"type": "Point", "coordinates": [5, 52]}] * 4000).encode()


@pytest.fixture
async def reader() -> AsyncIterator[MapReader]:
    reader = MapReader()
    yield reader
    await reader.close()


@pytest.mark.slow
async def test_a_file_is_read_as_in_this_process_and_says_how_far_it_is(reader: MapReader) -> None:
    shares: list[Progress] = []
    imported = await reader.read(KML, "farm.kml", shares.append)
    assert imported == read_map(KML, "farm.kml")
    assert shares == sorted(shares)


async def test_a_refusal_comes_back_whole(reader: MapReader) -> None:
    with pytest.raises(BadMapFile) as caught:
        await reader.read(b"%PDF", "a.pdf")
    assert (caught.value.code, "PDF" in caught.value.text) == ("not_a_map", True)


async def test_a_file_that_takes_too_long_is_given_up() -> None:
    reader = MapReader(limit_s=0.01)
    with pytest.raises(BadMapFile) as caught:
        await reader.read(KML, "farm.kml")
    assert caught.value.code == "too_long"
    await reader.close()


@pytest.mark.slow
async def test_a_file_that_needs_too_much_memory_is_given_up() -> None:
    reader = MapReader(memory_bytes=1_000_000_000)
    nested = b"[" + b"[[],[],[],[],[],[],[],[],[],[]]," * 1_000_000 + b"[]]"
    with pytest.raises(BadMapFile) as caught:
        await reader.read(nested, "a.json")
    assert caught.value.code == "too_large"
    await reader.close()


async def test_cancel_gives_up_the_file_and_the_next_one_is_read(reader: MapReader) -> None:
    work = asyncio.create_task(reader.read(SLOW, "a.json"))
    await asyncio.sleep(0)
    while not work.done():
        reader.cancel()
        await asyncio.sleep(0.01)
    with pytest.raises(BadMapFile) as caught:
        await work
    assert caught.value.code == "cancelled"
    assert (await reader.read(KML, "farm.kml")).items


async def test_too_large_a_file_starts_no_process(reader: MapReader) -> None:
    with pytest.raises(BadMapFile) as caught:
        await reader.read(bytes(limits.FILE_BYTES + 1), "a.json")
    assert caught.value.code == "too_large"


@pytest.mark.slow
async def test_too_many_files_at_once_are_refused(reader: MapReader) -> None:
    work = [asyncio.create_task(reader.read(KML, "farm.kml")) for _ in range(5)]
    await asyncio.sleep(0)
    codes = [r.code for r in await asyncio.gather(*work, return_exceptions=True) if isinstance(r, BadMapFile)]
    assert codes == ["busy"]


def readers() -> set[int]:
    """Return the processes that read files for this one."""
    below = psutil.Process().children(recursive=True)
    return {one.pid for one in below if one.is_running() and "spawn_main" in " ".join(one.cmdline())}


def folders() -> set[Path]:
    """Return what reading leaves on disk while it goes on."""
    return set(Path(tempfile.gettempdir()).glob("headland-import-*"))


async def test_giving_up_the_wait_ends_the_process_at_work_and_leaves_nothing(reader: MapReader) -> None:
    there = folders()
    work = asyncio.create_task(reader.read(SLOW, "a.json"))
    for _ in range(500):
        if readers():
            break
        await asyncio.sleep(0.01)
    assert readers()
    work.cancel()
    with pytest.raises(asyncio.CancelledError):
        await work
    assert (readers(), folders() - there) == (set(), set())
    assert (await reader.read(KML, "farm.kml")).items


@pytest.mark.slow
async def test_a_large_file_comes_whole_in_its_parts_and_counts_its_shapes(reader: MapReader) -> None:
    told: list[Progress] = []
    imported = await reader.read(MANY, "a.json", told.append)
    assert [item.n for item in imported.items] == list(range(3000))
    assert imported == read_map(MANY, "a.json")
