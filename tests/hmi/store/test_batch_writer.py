"""The writer thread: batches, trouble, and never in anybody's way."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Sequence

import pytest

from hmi.store.batch_writer import BatchWriter
from hmi.store.errors import DatabaseUnavailable

WAIT_S = 10.0


class Disk:
    """A place to write to that can be blocked, broken or picky."""

    def __init__(self) -> None:
        self.batches: list[list[int]] = []
        self.is_free = threading.Event()
        self.is_free.set()
        self.is_entered = threading.Event()
        self.is_broken = False
        self.refused: set[int] = set()

    def write(self, items: Sequence[int]) -> None:
        """Take a batch."""
        self.is_entered.set()
        assert self.is_free.wait(WAIT_S)
        if self.is_broken:
            raise DatabaseUnavailable("disk full")
        if self.refused & set(items):
            raise ValueError("cannot be written")
        self.batches.append(list(items))

    @property
    def items(self) -> list[int]:
        """Everything that was written, in order."""
        return [item for batch in self.batches for item in batch]


@pytest.fixture
def disk() -> Disk:
    """Return a disk that works."""
    return Disk()


@pytest.fixture
def writer(disk: Disk) -> Iterator[BatchWriter[int]]:
    """Return a running writer with room for ten."""
    writer = BatchWriter("test", disk.write, capacity=10, batch_size=4, retry_s=0.01)
    writer.start()
    yield writer
    disk.is_free.set()
    writer.close(WAIT_S)


def test_items_are_written_in_order(writer: BatchWriter[int], disk: Disk) -> None:
    for item in range(9):
        assert writer.put(item)
    assert writer.flush(WAIT_S)
    assert disk.items == list(range(9))
    assert writer.health().is_ok


def test_what_does_not_fit_is_dropped_and_counted_without_waiting(writer: BatchWriter[int], disk: Disk) -> None:
    disk.is_free.clear()
    taken = [writer.put(item) for item in range(25)]
    assert taken.count(True) == 10
    assert writer.health().dropped == 15
    disk.is_free.set()
    assert writer.flush(WAIT_S)
    assert disk.items == list(range(10))


def test_a_full_disk_is_tried_again_until_it_has_room(writer: BatchWriter[int], disk: Disk) -> None:
    disk.is_broken = True
    writer.put(1)
    assert not writer.flush(0.1)
    assert not writer.health().is_ok
    assert writer.health().last_error == "disk full"
    disk.is_broken = False
    assert writer.flush(WAIT_S)
    assert disk.items == [1]
    assert writer.health().is_ok


def test_one_item_that_cannot_be_written_does_not_take_others_with_it(writer: BatchWriter[int], disk: Disk) -> None:
    disk.refused = {2}
    disk.is_free.clear()
    for item in range(4):
        writer.put(item)
    disk.is_free.set()
    assert writer.flush(WAIT_S)
    assert disk.items == [0, 1, 3]
    assert (writer.health().written, writer.health().dropped) == (3, 1)


def test_closing_writes_what_waits(disk: Disk) -> None:
    writer = BatchWriter("test", disk.write, capacity=10, linger_s=60)
    writer.start()
    writer.put(1)
    assert writer.close(WAIT_S)
    assert disk.items == [1]
    assert not writer.put(2)


def test_closing_with_a_full_disk_does_not_hang(disk: Disk) -> None:
    disk.is_broken = True
    writer = BatchWriter("test", disk.write, capacity=10, retry_s=60)
    writer.start()
    writer.put(1)
    assert disk.is_entered.wait(WAIT_S)
    assert not writer.close(WAIT_S)


def test_lingering_gathers_one_batch(disk: Disk) -> None:
    writer = BatchWriter("test", disk.write, capacity=100, batch_size=50, linger_s=60)
    writer.start()
    for item in range(20):
        writer.put(item)
    assert writer.flush(WAIT_S)
    assert len(disk.batches) == 1
    writer.close(WAIT_S)
