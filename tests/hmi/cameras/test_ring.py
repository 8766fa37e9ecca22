"""The last minute of a camera."""

from __future__ import annotations

from hmi.cameras.picture_wire import Kind, Piece
from hmi.cameras.ring import Row


def piece(at_s: float, *, is_key: bool = False, size: int = 10) -> Piece:
    """Return a picture taken at a moment."""
    return Piece(Kind.H264, bytes(size), at_s * 1000, 1, 640, 480, is_key)


def filled(seconds: float, most_bytes: int = 10_000_000) -> Row:
    """Return a row of 10 pictures a second, a key picture each two seconds."""
    row = Row(most_bytes)
    for number in range(int(seconds * 10)):
        row.add(piece(number / 10, is_key=number % 20 == 0))
    return row


def test_a_clip_begins_with_the_key_picture_before_its_beginning() -> None:
    found = filled(30).between(5_000, 8_000).pieces
    assert found[0].is_key
    assert (found[0].captured_ms, found[-1].captured_ms) == (4_000, 8_000)


def test_no_more_is_kept_than_a_clip_may_hold() -> None:
    found = filled(150).between(0, 200_000).pieces
    assert found[0].captured_ms >= (149.9 - 110) * 1000


def test_bytes_are_bounded_whatever_the_camera_sends() -> None:
    row = Row(1000)
    for number in range(50):
        row.add(piece(number / 10, is_key=True, size=100))
    assert len(row.between(0, 1e9).pieces) == 10


def test_a_span_of_which_nothing_was_kept_gives_nothing() -> None:
    row = filled(10)
    assert row.between(60_000, 70_000).pieces == []
    assert row.between(-9_000, -1_000).pieces == []
    assert Row(100).between(0, 1).pieces == []


def test_the_nearest_still_is_found() -> None:
    nearest = filled(10).nearest(3_140)
    assert nearest is not None
    assert nearest.captured_ms == 3_100


def test_pictures_of_two_sources_are_two_spans_the_last_first() -> None:
    row = Row(10_000_000)
    for number in range(300):
        row.add(piece(number / 10, is_key=number % 20 == 0), "mjpeg http://a" if number < 150 else "mjpeg http://b")
    last = row.between(5_000, 25_000)
    assert (last.pieces[0].captured_ms, last.pieces[-1].captured_ms, last.has_before) == (16_000, 25_000, True)
    before = row.between(5_000, 16_000 - 1)
    assert (before.pieces[0].captured_ms, before.pieces[-1].captured_ms) == (4_000, 14_900)
    assert not before.has_before


def test_a_source_that_was_changed_before_the_span_is_no_part_of_it() -> None:
    row = Row(10_000_000)
    for number in range(300):
        row.add(piece(number / 10, is_key=number % 20 == 0), "a" if number < 100 else "b")
    assert not row.between(15_000, 25_000).has_before
