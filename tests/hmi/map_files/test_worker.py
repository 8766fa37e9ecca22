"""Reading in a process of its own."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator

import pytest

from hmi.map_files import limits
from hmi.map_files.errors import BadMapFile
from hmi.map_files.reader import read_map
from hmi.map_files.worker import MapReader
from tests.hmi.map_files import samples

KML = samples.file("farm.kml")
SLOW = json.dumps([{"type": "Point", "coordinates": [5, 52]}] * 4000).encode()


@pytest.fixture
async def reader() -> AsyncIterator[MapReader]:
    reader = MapReader()
    yield reader
    await reader.close()


async def test_a_file_is_read_as_in_this_process_and_says_how_far_it_is(reader: MapReader) -> None:
    shares: list[float] = []
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


async def test_too_many_files_at_once_are_refused(reader: MapReader) -> None:
    work = [asyncio.create_task(reader.read(KML, "farm.kml")) for _ in range(5)]
    await asyncio.sleep(0)
    codes = [r.code for r in await asyncio.gather(*work, return_exceptions=True) if isinstance(r, BadMapFile)]
    assert codes == ["busy"]
