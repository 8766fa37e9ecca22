"""A picture is judged by its header, before anybody decodes it."""

from __future__ import annotations

import contextlib
import io
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from hmi.cameras.jpeg_header import MAX_BYTES, BadPicture, checked_size
from tests.hmi.cameras.fake_camera import jpeg


@given(st.integers(1, 300), st.integers(1, 300), st.booleans(), st.sampled_from(["L", "RGB", "CMYK"]))
def test_the_size_is_the_one_another_reader_finds(width: int, height: int, progressive: bool, mode: str) -> None:
    out = io.BytesIO()
    Image.new(mode, (width, height)).save(out, "JPEG", progressive=progressive, comment=b"\xff\xc0 not a frame")
    assert checked_size(out.getvalue()) == (width, height)


def test_16_k_by_16_k_is_refused_from_a_few_hundred_bytes() -> None:
    small = jpeg(64, 64)
    at = small.index(b"\xff\xc0") + 5
    huge = small[:at] + struct.pack(">HH", 16_384, 16_384) + small[at + 4 :]
    with pytest.raises(BadPicture, match="16384 x 16384 pixels are too many"):
        checked_size(huge)


@pytest.mark.parametrize("share", [0.0, 0.01, 0.3, 0.9, 0.99])
def test_a_picture_that_is_cut_off_is_refused(share: float) -> None:
    whole = jpeg()
    with pytest.raises(BadPicture):
        checked_size(whole[: int(len(whole) * share)])


def test_padding_after_the_picture_does_no_harm() -> None:
    assert checked_size(jpeg(64, 48) + bytes(30)) == (64, 48)


def test_more_bytes_than_allowed_are_refused() -> None:
    with pytest.raises(BadPicture, match="larger than 8 MB"):
        checked_size(jpeg() + bytes(MAX_BYTES))


@given(st.binary(max_size=400))
def test_garbage_is_refused_and_nothing_else_happens(data: bytes) -> None:
    for given_bytes in (data, b"\xff\xd8" + data, b"\xff\xd8\xff\xe0" + data):
        with contextlib.suppress(BadPicture):
            checked_size(given_bytes)
