"""paho, reading the network in large pieces.

paho asks the socket for one byte, then one more, then the rest, and waits in ``select`` before every packet: five
system calls a message. Between it and the socket this puts a buffer, and reads on while the buffer holds packets.
A QoS 0 PUBLISH that is in the buffer as a whole needs no state of the protocol and is handed on at once; everything
else is paho's.
"""

from __future__ import annotations

import socket
from collections.abc import Callable
from typing import Any, NamedTuple

import paho.mqtt.client as paho
from paho.mqtt.enums import MQTTErrorCode

READ_BYTES = 64 * 1024
PACKETS_A_TURN = 200  # then writes and keep-alive have their turn, however much comes in
PUBLISH_QOS_0 = (0x30, 0x31)  # first byte, without and with the retain flag (MQTT 3.1.1, 3.3.1)
LENGTH_BYTES = 4  # the most that a remaining length may have (2.2.3)


class Publication(NamedTuple):
    """A QoS 0 message as it came: the topic is not decoded yet."""

    topic: bytes
    payload: bytes
    is_retained: bool


class BufferedSocket:
    """A connected socket whose ``recv`` is served from one large read."""

    def __init__(self, sock: socket.socket) -> None:
        self._sock = sock
        self._held = b""
        self._at = 0

    def recv(self, size: int) -> bytes:
        """Return up to ``size`` bytes, ``b""`` at the end; raises ``BlockingIOError`` if there are none yet."""
        if self._at >= len(self._held):
            self._held, self._at = b"", 0
            self._held = self._sock.recv(READ_BYTES)
        piece = self._held[self._at : self._at + size]
        self._at += len(piece)
        return piece

    def pending(self) -> int:
        """Return how many bytes can be had without waiting, here or inside TLS."""
        held = len(self._held) - self._at
        return held if held else int(getattr(self._sock, "pending", lambda: 0)())

    def take_publication(self) -> Publication | None:
        """Return the QoS 0 PUBLISH that begins here, ``None`` if it is something else or not all here yet."""
        held, at = self._held, self._at
        if at >= len(held) or held[at] not in PUBLISH_QOS_0:
            return None
        length, begin = _remaining_length(held, at + 1)
        end = begin + length
        if length < 2 or end > len(held):
            return None
        body = begin + 2 + int.from_bytes(held[begin : begin + 2], "big")
        if body > end:
            return None  # malformed: paho says what that means
        self._at = end
        return Publication(held[begin + 2 : body], held[body:end], held[at] == PUBLISH_QOS_0[1])

    def __getattr__(self, name: str) -> Any:
        return getattr(self._sock, name)


def _remaining_length(held: bytes, at: int) -> tuple[int, int]:
    """Return the value and where the packet's body begins; (0, ``at``) if it is not all here or malformed."""
    value = 0
    for place in range(min(LENGTH_BYTES, len(held) - at)):
        digit = held[at + place]
        value |= (digit & 0x7F) << (7 * place)
        if digit < 0x80:
            return value, at + place + 1
    return 0, at


class BufferedClient(paho.Client):
    """``paho.Client`` over a ``BufferedSocket``; with ``on_publication`` most QoS 0 messages come there."""

    on_publication: Callable[[Publication], None] | None = None

    def _create_socket(self) -> Any:
        # Private in paho, and the place where its own websocket wrapper is put in; paho is pinned and this is tested.
        return BufferedSocket(super()._create_socket())  # type: ignore[arg-type]

    def loop_read(self, max_packets: int = 1) -> MQTTErrorCode:
        """Read what the buffer holds, not one packet."""
        result = super().loop_read(max_packets)
        for _ in range(PACKETS_A_TURN):
            sock: Any = self.socket()
            if result != MQTTErrorCode.MQTT_ERR_SUCCESS or sock is None or not sock.pending():
                break
            # paho leaves bytes in the buffer only between packets: within one it reads on until there are none
            publication = sock.take_publication() if self.on_publication else None
            if publication is not None and self.on_publication:
                self.on_publication(publication)
            else:
                result = super().loop_read(max_packets)
        return result
