"""What must reach the cloud stays on disk until it is there, within its bounds."""

from __future__ import annotations

import asyncio
import sqlite3
from collections.abc import Sequence
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hmi.clock import FakeClock
from hmi.cloud.backlog import Backlog
from hmi.cloud.kept_file import OutboxUnusable
from hmi.cloud.outbox import Outbox, Piece, Rank

DAY_S = 86_400.0


def piece(name: str, rank: Rank = Rank.EVENT, at_s: float = 1000.0, size: int = 0) -> Piece:
    """Return a piece whose body is its name, made long if asked."""
    return Piece("weeder-01", rank, at_s, name + " " * size)


def names(pieces: list[Piece]) -> list[str]:
    """Return what the pieces are called."""
    return [one.body.strip() for one in pieces]


def test_pieces_wait_in_order_over_a_restart(tmp_path: Path) -> None:
    box = Outbox(tmp_path / "cloud" / "o.db", 10**6, DAY_S)
    box.add([piece("a"), piece("b")])
    box.add([piece("c")])
    box.close()
    again = Outbox(tmp_path / "cloud" / "o.db", 10**6, DAY_S)
    assert names(again.first(10)) == ["a", "b", "c"]
    again.delivered(again.first(1))
    assert names(again.first(10)) == ["b", "c"]
    assert again.waiting()[0] == 2


def test_events_make_room_for_mission_results_and_the_oldest_goes_first(tmp_path: Path) -> None:
    box = Outbox(tmp_path / "o.db", 20_000, DAY_S)
    box.add([piece(f"m{n}", Rank.MISSION, size=900) for n in range(10)])
    box.add([piece(f"e{n}", Rank.EVENT, size=900) for n in range(40)])
    lost = box.trim(1000.0)
    left = names(box.first(100))
    assert [f"m{n}" for n in range(10)] == left[:10]
    assert left[-1] == "e39"
    assert lost == 50 - len(left)
    assert box.waiting()[1] <= 20_000


def test_what_is_too_old_is_dropped_and_counted(tmp_path: Path) -> None:
    box = Outbox(tmp_path / "o.db", 10**6, DAY_S)
    box.add([piece("old", at_s=0.0), piece("new", at_s=DAY_S)])
    assert box.trim(DAY_S + 1) == 1
    assert names(box.first(10)) == ["new"]


@given(sizes=st.lists(st.integers(0, 3000), max_size=30))
@settings(max_examples=10, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_what_is_counted_is_what_is_there(tmp_path: Path, sizes: list[int]) -> None:
    path = tmp_path / f"{len(list(tmp_path.iterdir()))}.db"
    box = Outbox(path, 10_000, DAY_S)
    box.add([piece(str(n), size=size) for n, size in enumerate(sizes)])
    box.trim(1000.0)
    box.delivered(box.first(3))
    count, size, _ = box.waiting()
    left = box.first(100)
    assert (count, size) == (len(left), sum(one.size for one in left))
    assert size <= 10_000
    again = Outbox(path, 10_000, DAY_S)
    again.first(1)
    assert again.waiting()[:2] == (count, size)
    again.close()
    box.close()


def test_a_file_that_is_no_outbox_is_said_so_and_does_not_end_the_console(tmp_path: Path) -> None:
    (tmp_path / "o.db").write_bytes(b"not a database" * 1000)
    with pytest.raises(OutboxUnusable):
        Outbox(tmp_path / "o.db", 10**6, DAY_S).add([piece("a")])


class FullDisk(Outbox):
    """Takes nothing while it is full, and lets nothing be deleted: that needs room, too."""

    is_full = False
    is_unreadable = False

    def _write(self, statement: str, rows: Sequence[tuple[object, ...]]) -> int:
        if self.is_full:
            raise self._unusable(sqlite3.OperationalError("database or disk is full"))
        return super()._write(statement, rows)

    def _opened(self) -> sqlite3.Connection:
        if self.is_unreadable:
            raise sqlite3.OperationalError("disk I/O error")
        return super()._opened()


def test_a_full_disk_keeps_new_pieces_in_memory_and_they_are_delivered_from_there(tmp_path: Path) -> None:
    async def story() -> None:
        box = FullDisk(tmp_path / "o.db", 10**6, DAY_S)
        backlog = Backlog(box, FakeClock(), memory=3)
        box.is_full = True
        now_s = FakeClock().utc().timestamp()
        for n, rank in enumerate([Rank.EVENT, Rank.MISSION, Rank.EVENT, Rank.EVENT, Rank.EVENT]):
            backlog.put(piece(f"p{n}", rank, now_s))
        await backlog.settle()
        assert "full" in backlog.waiting.trouble
        assert backlog.total == 3  # bounded in memory too
        found = await backlog.first(10)
        assert names(found) == ["p1", "p3", "p4"]  # the oldest events made room, the mission did not
        await backlog.delivered(found[:1])
        box.is_full = False
        await backlog.settle()
        assert backlog.waiting.trouble == ""
        assert (backlog.waiting.count, backlog.waiting.lost) == (2, 2)
        assert names(box.first(10)) == ["p3", "p4"]
        await backlog.close()

    asyncio.run(story())


async def test_what_was_delivered_while_the_disk_is_full_does_not_come_again(tmp_path: Path) -> None:
    box, clock = FullDisk(tmp_path / "o.db", 10**6, DAY_S), FakeClock()
    backlog, now_s = Backlog(box, clock), clock.utc().timestamp()
    for n in range(300):
        backlog.put(piece(f"p{n}", at_s=now_s))
    await backlog.settle()
    box.is_full = True
    backlog.put(piece("new", at_s=now_s))
    sent: list[str] = []
    for _ in range(5):
        await backlog.settle()
        found = await backlog.first(100)
        sent += names(found)
        await backlog.delivered(found[1:] + found[:1] if len(sent) < 200 else found)
    assert sent == [*(f"p{n}" for n in range(300)), "new"]
    assert (backlog.total, backlog.waiting.bytes) == (0, 0)
    assert "full" in backlog.waiting.trouble
    box.is_full = False
    await backlog.settle()
    assert (box.waiting(), box.first(10), backlog.waiting.lost) == ((0, 0, None), [], 0)
    backlog.put(piece("later", at_s=now_s))
    await backlog.settle()
    assert names(await backlog.first(10)) == ["later"]
    await backlog.close()


async def test_pieces_that_did_not_arrive_are_returned_again_between_those_that_did(tmp_path: Path) -> None:
    box, clock = FullDisk(tmp_path / "o.db", 10**6, DAY_S), FakeClock()
    backlog = Backlog(box, clock)
    for n in range(5):
        backlog.put(piece(f"p{n}", at_s=clock.utc().timestamp()))
    await backlog.settle()
    box.is_full = True
    found = await backlog.first(3)
    await backlog.delivered([found[0], found[2]])
    assert names(await backlog.first(10)) == ["p1", "p3", "p4"]
    await backlog.close()


@pytest.mark.parametrize("is_unreadable", [False, True])
async def test_nothing_overtakes_what_an_earlier_run_left_on_a_disk_that_is_full_now(
    tmp_path: Path, is_unreadable: bool
) -> None:
    clock = FakeClock()
    first = Backlog(Outbox(tmp_path / "o.db", 10**6, DAY_S), clock)
    first.put(piece("running", Rank.MISSION, clock.utc().timestamp()))
    await first.close()
    box = FullDisk(tmp_path / "o.db", 10**6, DAY_S)
    box.is_full, box.is_unreadable = True, is_unreadable
    backlog = Backlog(box, clock)
    backlog.put(piece("done", Rank.MISSION, clock.utc().timestamp()))
    await backlog.settle()
    found = await backlog.first(10)
    assert names(found) == ([] if is_unreadable else ["running"])
    box.is_unreadable = False
    await backlog.delivered(await backlog.first(1))
    assert names(await backlog.first(10)) == ["done"]
    await backlog.close()


@pytest.mark.parametrize("left", [b"", b"not a database" * 1000])
async def test_where_nothing_older_can_be_read_ever_new_pieces_go_from_memory(tmp_path: Path, left: bytes) -> None:
    (tmp_path / "o.db").write_bytes(left)
    box = FullDisk(tmp_path / "o.db", 10**6, DAY_S)
    box.is_full, box.is_unreadable = True, not left
    backlog = Backlog(box, FakeClock())
    backlog.put(piece("new", at_s=FakeClock().utc().timestamp()))
    await backlog.settle()
    assert names(await backlog.first(10)) == ["new"]
    assert backlog.waiting.trouble
