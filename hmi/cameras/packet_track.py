"""A track of packets that are encoded already: aiortc packs and sends them, and encodes nothing."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import lru_cache
from typing import Any

import av
from aiortc import MediaStreamTrack
from aiortc.mediastreams import MediaStreamError

from hmi.cameras.picture_wire import Piece

CLOCK = Fraction(1, 90_000)
MOST_WAITING = 60  # a viewer that is so many pictures behind begins again with a key picture


@lru_cache(maxsize=8)  # one copy for all viewers of a picture
def packet_of(piece: Piece) -> av.Packet[Any]:
    """Return the packet of a picture."""
    packet: av.Packet[Any] = av.Packet(piece.data)
    packet.pts, packet.time_base = piece.pts, CLOCK
    return packet


class PacketTrack(MediaStreamTrack):
    """One viewer's pictures, oldest first.

    Args:
        on_begin: called when the viewer can be sent to, before the first picture.
        on_sent: called with each picture when it was sent.
        ask_key: asks the camera for a picture that can be decoded alone.
    """

    kind = "video"

    def __init__(
        self, on_begin: Callable[[], None], on_sent: Callable[[Piece], None], ask_key: Callable[[], None]
    ) -> None:
        super().__init__()
        self._on_begin, self._on_sent, self._ask_key = on_begin, on_sent, ask_key
        self._row: deque[tuple[Piece, av.Packet[Any]]] = deque()
        self._came = asyncio.Event()
        self._late = 0  # how many of the row were there before the viewer was
        self._sending: Piece | None = None
        self._has_begun, self._needs_key = False, True

    def begin_with(self, pieces: Sequence[Piece]) -> None:
        """Hand over what leads up to the next picture, the first a key picture; all of it, however much it is."""
        self._row.extend((piece, packet_of(piece)) for piece in pieces)
        self._late = len(self._row)
        self._needs_key = not pieces
        self._came.set()

    def put(self, piece: Piece, packet: av.Packet[Any]) -> None:
        """Hand over the next picture; ``packet`` is shared by all viewers."""
        if not self._has_begun:
            return
        if self._needs_key and not piece.is_key:
            return
        self._needs_key = False
        if len(self._row) - self._late >= MOST_WAITING:
            self._row.clear()
            self._late = 0
            if not piece.is_key:
                self._needs_key = True
                self._ask_key()
                return
        self._row.append((piece, packet))
        self._came.set()

    async def recv(self) -> av.Packet[Any]:
        """See ``MediaStreamTrack``."""
        if self._sending is not None:
            self._on_sent(self._sending)
            self._sending = None
        if not self._has_begun:
            self._has_begun = True
            self._on_begin()
        while not self._row:
            self._came.clear()
            await self._came.wait()
            if self.readyState != "live":
                raise MediaStreamError
        self._sending, packet = self._row.popleft()
        self._late = max(0, self._late - 1)
        return packet

    def stop(self) -> None:
        """See ``MediaStreamTrack``."""
        super().stop()
        self._came.set()
