"""Bytes from a field are read, never decoded: size, format, and whether the end came."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmi.domain.picture_header import BadPicture, Header, read_picture
from tests.hmi.pictures.jpeg import bomb, picture

WHOLE = picture(640, 480)


@pytest.mark.parametrize(
    "options", [{}, {"progressive": True}, {"quality": 100}, {"exif": b"Exif\x00\x00" + b"x" * 900}]
)
def test_size_and_format_of_a_jpeg_are_read(options: dict[str, object]) -> None:
    assert read_picture(picture(641, 479, **options)) == Header("image/jpeg", 641, 479)


def test_size_and_format_of_a_png_are_read() -> None:
    assert read_picture(picture(320, 200, kind="PNG")) == Header("image/png", 320, 200)


@pytest.mark.parametrize("size", [(16_384, 16_384), (65_535, 65_535), (16_385, 1), (6_400, 6_400)])
def test_a_header_that_promises_too_many_pixels_is_refused_before_anything_is_decoded(size: tuple[int, int]) -> None:
    with pytest.raises(BadPicture) as refused:
        read_picture(bomb(*size))
    assert refused.value.code == "too_large"


@given(st.integers(0, len(WHOLE) - 2))
def test_a_picture_cut_off_anywhere_is_refused(length: int) -> None:
    with pytest.raises(BadPicture):
        read_picture(WHOLE[:length])


@given(st.binary(max_size=300))
def test_garbage_is_refused_and_nothing_else_happens(data: bytes) -> None:
    for start in (b"", b"\xff\xd8\xff\xe0", b"\x89PNG\r\n\x1a\n"):
        with pytest.raises(BadPicture):
            read_picture(start + data)


@given(st.integers(0, len(WHOLE) - 1), st.integers(0, 255))
def test_a_flipped_byte_gives_a_size_within_limits_or_a_refusal(at: int, value: int) -> None:
    data = bytearray(WHOLE)
    data[at] = value
    try:
        header = read_picture(bytes(data))
    except BadPicture:
        return
    assert 0 < header.width_px * header.height_px <= 40_000_000


@pytest.mark.parametrize(
    "data", [b"", b"GIF89a...", b"<svg/>", b"\xff\xd8\xff\xda", b"\xff\xd8\xff\xe0\x00\x01", bomb(0, 5)]
)
def test_what_is_no_picture_is_named_so(data: bytes) -> None:
    with pytest.raises(BadPicture) as refused:
        read_picture(data)
    assert refused.value.code == "not_a_picture"
