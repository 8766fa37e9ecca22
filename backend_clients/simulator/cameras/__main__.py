"""The drawing process: orders come on its standard input, pictures go out on its standard output.

Each message is four bytes of length, little endian, and MessagePack. It ends when its input ends.
"""

from __future__ import annotations

import contextlib
import os
import select
import sys
from typing import BinaryIO

import msgspec

from backend_clients.simulator.cameras.painter import Painter
from backend_clients.simulator.cameras.scene import Order, Picture

NICE = 5  # robots come before their pictures


def serve(given: int, taken: BinaryIO) -> None:
    """Draw until the input ends; ``given`` is its file number."""
    painter, decoder, encoder = Painter(), msgspec.msgpack.Decoder(Order), msgspec.msgpack.Encoder()
    while len(head := _read(given, 4)) == 4:
        order = decoder.decode(_read(given, int.from_bytes(head, "little")))
        picture = _answer(painter, order)
        if picture is None:
            continue
        body = encoder.encode(picture)
        taken.write(len(body).to_bytes(4, "little") + body)
        taken.flush()
        if not select.select([given], [], [], 0)[0]:  # nobody else waits for a first picture
            painter.catch_up()


def _read(given: int, size: int) -> bytes:
    """Return so many bytes, fewer at the end of the input; nothing is read ahead, so that ``select`` knows."""
    data = b""
    while len(data) < size and (more := os.read(given, size - len(data))):
        data += more
    return data


def _answer(painter: Painter, order: Order) -> Picture | None:
    if order.scene is not None:
        painter.keep(order.scene)
    if order.look is None:
        return None
    try:
        return painter.draw(order.number, order.look)
    except Exception as problem:  # noqa: BLE001 - one picture that cannot be drawn must not take the others with it
        return Picture(order.number, problem=f"{type(problem).__name__}: {problem}"[:300])


if __name__ == "__main__":
    with contextlib.suppress(OSError):
        os.nice(NICE)
    with contextlib.suppress(KeyboardInterrupt, BrokenPipeError):
        serve(sys.stdin.fileno(), sys.stdout.buffer)
