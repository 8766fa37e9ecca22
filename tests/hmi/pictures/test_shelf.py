"""Files and records stay together, whole or not there at all, and the disk never fills."""

from __future__ import annotations

import asyncio
import hashlib
from datetime import timedelta
from pathlib import Path

import pytest

from hmi.domain.picture import Moment, Picture, PictureKind
from hmi.domain.role import Role
from hmi.store.errors import NotFound, PicturesBusy, PicturesFull, TooMuchMarked
from hmi.store.picture_files import NewestFrame
from hmi.store.picture_shelf import MOST_WAITING
from hmi.store.pictures import PictureFilter
from tests.hmi.commands.field import FARM
from tests.hmi.pictures.conftest import MakeRig
from tests.hmi.pictures.jpeg import picture
from tests.hmi.pictures.rig import WEEDER, PictureRig

MB = 1_000_000


def draft(rig: PictureRig, number: int, *, days_ago: float = 0.0, kind: str = "snapshot") -> Picture:
    """Return a picture to be kept."""
    at = rig.clock.utc() - timedelta(days=days_ago)
    return Picture(
        f"{number:032x}", FARM, PictureKind(kind), WEEDER, "front", at, at, "image/jpeg", 64, 48, 0, "", Moment()
    )


async def ids(rig: PictureRig) -> list[int]:
    """Return which pictures are listed, newest first."""
    found = await rig.records.database.run(rig.records.pictures.some, FARM, PictureFilter(), 500)
    return [int(one.id, 16) for one in found]


async def test_a_kept_picture_is_whole_and_its_hash_is_that_of_the_file(rig: PictureRig) -> None:
    data = picture()
    kept = await rig.shelf.keep(draft(rig, 1), data)
    path = await rig.shelf.path(kept)
    assert path.read_bytes() == data
    assert (kept.size_bytes, kept.sha256) == (len(data), hashlib.sha256(data).hexdigest())
    assert not list((rig.folder / "pictures/incoming").iterdir())


async def test_a_picture_whose_record_cannot_be_written_leaves_no_file(rig: PictureRig) -> None:
    await rig.shelf.keep(draft(rig, 1), picture())
    with pytest.raises(Exception, match="UNIQUE"):
        await rig.shelf.keep(draft(rig, 1, days_ago=40), picture())
    assert len(rig.files()) == 1


async def test_files_without_a_record_and_half_written_ones_are_gone_after_a_restart(make_rig: MakeRig) -> None:
    rig = await make_rig()
    kept = await rig.shelf.keep(draft(rig, 1), picture())
    there = await rig.shelf.path(kept)
    there.with_name(f"{2:032x}.jpg").write_bytes(b"stray")
    (rig.folder / "pictures/incoming" / f"{3:032x}.jpg").write_bytes(b"half")
    rig = await make_rig()
    assert rig.files() == [there]
    assert not list((rig.folder / "pictures/incoming").iterdir())


async def test_a_removed_picture_takes_its_file_and_an_empty_month_along(rig: PictureRig) -> None:
    kept = await rig.shelf.keep(draft(rig, 1), picture())
    await rig.shelf.remove(kept)
    assert (await ids(rig), rig.files()) == ([], [])
    with pytest.raises(FileNotFoundError):
        await rig.shelf.path(kept)
    assert rig.shelf.health().used_bytes == 0


@pytest.mark.slow
async def test_the_oldest_go_when_there_is_no_room_and_the_room_is_kept(make_rig: MakeRig) -> None:
    rig = await make_rig(pictures_gb=0.1)
    data = picture() + b"\x00" * (12 * MB)
    for number in range(12):
        await rig.shelf.keep(draft(rig, number, days_ago=20 - number), data)
    assert await ids(rig) == [11, 10, 9, 8, 7, 6, 5, 4]
    assert rig.shelf.health().used_bytes <= 100 * MB
    assert sum(path.stat().st_size for path in rig.files()) <= 100 * MB


async def test_what_is_too_old_goes_unless_it_is_marked(rig: PictureRig) -> None:
    old = await rig.shelf.keep(draft(rig, 1, days_ago=29.9), picture())
    await rig.shelf.keep(draft(rig, 2, days_ago=29.9), picture())
    await rig.shelf.marked(old, note=None, is_kept=True)
    rig.clock.advance(86_400)
    await rig.shelf.sweep()
    assert await ids(rig) == [1]


async def test_so_much_cannot_be_marked_that_nothing_new_has_room(make_rig: MakeRig) -> None:
    rig = await make_rig(pictures_gb=0.1)
    data = picture() + b"\x00" * (30 * MB)
    kept = [await rig.shelf.keep(draft(rig, number), data) for number in range(3)]
    for one in kept[:2]:
        await rig.shelf.marked(one, note=None, is_kept=True)
    with pytest.raises(TooMuchMarked):
        await rig.shelf.marked(kept[2], note=None, is_kept=True)


async def test_below_the_floor_nothing_is_kept_and_it_says_so_until_there_is_room_again(rig: PictureRig) -> None:
    rig.free_bytes = 1_900_000_000
    with pytest.raises(PicturesFull):
        await rig.shelf.keep(draft(rig, 1), picture())
    assert (await ids(rig), rig.files()) == ([], [])
    assert not rig.shelf.health().is_ok
    assert [one.code for one in rig.desk.findings()] == ["pictures-stopped"]
    assert rig.desk.health() == {"pictures": {"state": "degraded"}}
    rig.free_bytes = 2_100_000_000
    await rig.shelf.sweep()
    assert rig.desk.findings() == ()
    await rig.shelf.keep(draft(rig, 1), picture())


async def test_a_full_disk_is_noticed_by_the_minute_before_anybody_wants_to_keep_something(rig: PictureRig) -> None:
    rig.free_bytes = 0
    await rig.shelf.sweep()
    assert "0.0 GB free" in rig.shelf.health().text


async def test_a_disk_that_fails_is_said_and_leaves_nothing_half(
    rig: PictureRig, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(_path: Path, _mode: str = "r", *_rest: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("hmi.store.picture_files.open", fail, raising=False)
    with pytest.raises(PicturesFull):
        await rig.shelf.keep(draft(rig, 1), picture())
    assert (await ids(rig), rig.files()) == ([], [])
    assert "No space left" in rig.shelf.health().text


async def test_more_than_the_disk_takes_is_refused_instead_of_filling_the_memory(rig: PictureRig) -> None:
    waiting = [rig.shelf.keep(draft(rig, number), picture()) for number in range(MOST_WAITING + 5)]
    ended = await asyncio.gather(*waiting, return_exceptions=True)
    assert sum(isinstance(one, PicturesBusy) for one in ended) == 5
    assert len(rig.files()) == MOST_WAITING
    await rig.shelf.keep(draft(rig, 99), picture())


async def test_no_id_and_no_name_of_a_camera_leads_out_of_the_folder(rig: PictureRig) -> None:
    at, files = rig.clock.utc(), rig.shelf.files
    for name in ("../../etc/passwd", "..", "a/b", "A" * 32, f"{1:032x}/../x", ""):
        for reach in (
            lambda name=name: files.incoming(name, "image/jpeg"),
            lambda name=name: files.path(FARM, name, "image/jpeg", at),
            lambda name=name: files.path(name, f"{1:032x}", "image/jpeg", at),
            lambda name=name: files.set_newest(FARM, name, NewestFrame(b"", 0.0, is_dated=True)),
            lambda name=name: files.newest(name, "barn"),
        ):
            with pytest.raises(FileNotFoundError):
                reach()


async def test_another_farm_finds_nothing(rig: PictureRig) -> None:
    kept = await rig.shelf.keep(draft(rig, 1), picture())
    with pytest.raises(NotFound):
        await rig.desk.book.get(rig.person(Role.ADMIN, "other-farm"), kept.id)
    with pytest.raises(NotFound):
        await rig.desk.book.remove(rig.person(Role.ADMIN, "other-farm"), kept.id)
    assert (await rig.desk.book.listed(rig.person(Role.ADMIN, "other-farm"), PictureFilter(), 10)).pictures == []
