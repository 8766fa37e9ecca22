"""Between pulling and encoding: the newest picture wins, and H.264 is never torn."""

from __future__ import annotations

from hmi.cameras.inbox import MOST_UNITS, Inbox, Shot, Unit


def test_a_newer_picture_replaces_one_that_nobody_took() -> None:
    box = Inbox()
    for number in range(5):
        box.put(Shot(bytes([number]), float(number), True))
    taken = box.take(0)
    assert isinstance(taken, Shot)
    assert taken.captured_ms == 4
    assert (box.pictures, box.skipped) == (5, 4)
    assert box.take(0) is None


def test_h264_keeps_its_order_and_a_row_that_grows_too_long_begins_again_with_a_key() -> None:
    box = Inbox()
    for number in range(MOST_UNITS + 10):
        box.put_unit(Unit(b"p", float(number), number == 0))
    assert box.take(0) is None, "half a row would show nothing but grey"
    box.put_unit(Unit(b"k", 500.0, True))
    box.put_unit(Unit(b"p", 501.0, False))
    assert [unit.captured_ms for unit in (box.take(0), box.take(0)) if isinstance(unit, Unit)] == [500.0, 501.0]
    assert box.skipped == MOST_UNITS + 10


def test_the_first_reason_to_end_is_the_one_that_counts() -> None:
    box = Inbox()
    box.end("the camera ended its stream")
    box.end("later")
    assert box.take(5.0) is None
    assert box.ended == "the camera ended its stream"
