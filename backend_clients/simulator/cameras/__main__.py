"""The drawing process: orders come on its standard input, pictures go out on its standard output.

Each message is four bytes of length, little endian, and MessagePack. It ends when its input ends.
"""

from __future__ import annotations

import contextlib
import os
import sys
from typing import BinaryIO

import msgspec

from backend_clients.simulator.cameras.painter import Painter
from backend_clients.simulator.cameras.scene import Order, Picture

NICE = 5  # robots come before their pictures


def serve(given: BinaryIO, taken: BinaryIO) -> None:
    """Draw until the input ends."""
    painter, decoder, encoder = Painter(), msgspec.msgpack.Decoder(Order), msgspec.msgpack.Encoder()
    while len(head := given.read(4)) == 4:
        order = decoder.decode(given.read(int.from_bytes(head, "little")))
        picture = _answer(painter, order)
        if picture is None:
            continue
        body = encoder.encode(picture)
        taken.write(len(body).to_bytes(4, "little") + body)
        taken.flush()
        painter.catch_up()  # whoever waited has a picture; the next one is as fine as all others


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
        serve(sys.stdin.buffer, sys.stdout.buffer)
