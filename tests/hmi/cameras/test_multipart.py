"""The reader of picture streams: the same parts however the bytes arrive, and nothing that breaks it."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmi.cameras.multipart import MultipartReader, Refused, boundary_of

BODIES = st.lists(st.binary(max_size=300).filter(lambda body: b"--frame" not in body), max_size=6)


def stream_of(bodies: list[bytes], *, has_length: bool = True) -> bytes:
    """Return a stream as cameras send it."""
    out = b""
    for body in bodies:
        length = f"Content-Length: {len(body)}\r\n" if has_length else ""
        out += f"--frame\r\nContent-Type: image/jpeg\r\n{length}X-Age-Ms: 4\r\n\r\n".encode() + body + b"\r\n"
    return out


def cut(data: bytes, sizes: list[int]) -> list[bytes]:
    """Return ``data`` in pieces."""
    pieces, at = [], 0
    for size in sizes:
        pieces.append(data[at : at + size])
        at += size
    return [*pieces, data[at:]]


@given(BODIES, st.lists(st.integers(1, 60), max_size=60))
def test_parts_with_a_length_come_out_whole_however_they_arrive(bodies: list[bytes], sizes: list[int]) -> None:
    reader = MultipartReader(b"--frame")
    found = [part for piece in cut(stream_of(bodies), sizes) for part in reader.feed(piece, 1.0)]
    assert [part.body for part in found] == bodies
    assert all(part.headers["x-age-ms"] == "4" for part in found)
    assert (reader.garbage, reader.too_large) == (0, 0)


@given(BODIES, st.lists(st.integers(1, 60), max_size=60))
def test_parts_without_a_length_end_where_the_next_begins(bodies: list[bytes], sizes: list[int]) -> None:
    reader = MultipartReader(b"--frame")
    data = stream_of([*bodies, b"next"], has_length=False)
    found = [part for piece in cut(data, sizes) for part in reader.feed(piece, 1.0)]
    assert [part.body.removesuffix(b"\r\n") for part in found[: len(bodies)]] == bodies


@given(st.lists(st.binary(max_size=200), max_size=30))
def test_garbage_never_raises_and_never_piles_up(pieces: list[bytes]) -> None:
    reader = MultipartReader(b"--frame", max_bytes=500)
    for piece in pieces:
        for part in reader.feed(piece, 0.0):
            assert len(part.body) <= 500 + 200
    assert len(reader._buffer) <= 500 + 8 * 1024 + 400


@given(st.binary(max_size=300).filter(lambda data: b"--frame" not in data and not data.endswith((b"-", b"--"))))
def test_after_garbage_the_next_picture_is_found(garbage: bytes) -> None:
    reader = MultipartReader(b"--frame")
    found = reader.feed(garbage + b"\r\n" + stream_of([b"picture"]), 2.0)
    assert [part.body for part in found] == [b"picture"]


def test_a_part_that_is_too_long_is_skipped_and_counted_and_the_next_is_read() -> None:
    reader = MultipartReader(b"--frame", max_bytes=1000)
    data = stream_of([bytes(5000), b"small"])
    found = [part for piece in cut(data, [700] * 9) for part in reader.feed(piece, 0.0)]
    assert [part.body for part in found] == [b"small"]
    assert reader.too_large == 1


def test_the_time_of_a_part_is_when_its_head_came_and_not_the_boundary_before() -> None:
    reader = MultipartReader(b"--frame")
    first, second = stream_of([b"one"]) + b"--frame\r\n", stream_of([b"two"])[len(b"--frame\r\n") :]
    assert [part.began_ms for part in reader.feed(first, 10.0)] == [10.0]
    assert [part.began_ms for part in reader.feed(second, 77.0)] == [77.0]


@pytest.mark.parametrize(
    ("said", "boundary"),
    [
        ("multipart/x-mixed-replace; boundary=frame", b"--frame"),
        ('multipart/x-mixed-replace;boundary="--myboundary"', b"--myboundary"),
        ("multipart/x-mixed-replace; charset=x; BOUNDARY=a1; q=2", b"--a1"),
    ],
)
def test_the_boundary_is_read_as_cameras_write_it(said: str, boundary: bytes) -> None:
    assert boundary_of(said) == boundary


@pytest.mark.parametrize("said", ["", "text/html", "image/jpeg; boundary=frame", "multipart/x-mixed-replace"])
def test_what_is_no_stream_is_refused_in_words(said: str) -> None:
    with pytest.raises(Refused, match="instead of a stream of pictures"):
        boundary_of(said)
