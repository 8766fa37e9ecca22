"""The pictures of ``make screens``: few colours, and those that carry a meaning as they are."""

from __future__ import annotations

from PIL import Image

from bench.screens import signs, with_palette


def test_a_few_pixels_of_a_sign_keep_their_colour_among_many_others() -> None:
    picture = Image.new("RGB", (256, 256))
    picture.putdata([(x, y, (x * y) % 256) for y in range(256) for x in range(256)])
    for number, sign in enumerate(signs()):
        picture.putpixel((number, 0), sign)
    flat = with_palette(picture, 96)
    assert flat.mode == "P"
    assert [flat.convert("RGB").getpixel((number, 0)) for number in range(len(signs()))] == signs()


def test_signs_are_the_priorities_and_the_states_of_stop_in_every_theme() -> None:
    assert {(0xF0, 0x7B, 0x05), (0xF2, 0xC5, 0x00), (0xD4, 0x26, 0x2F), (0xFF, 0xDD, 0x00)} <= set(signs())
    assert len(signs()) + 220 <= 256
