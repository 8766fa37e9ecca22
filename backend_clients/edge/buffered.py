"""paho, reading the network in large pieces.

paho asks the socket for one byte, then one more, then the rest, and waits in ``select`` before every packet: five
system calls a message. Between it and the socket this puts a buffer, and reads on while the buffer holds packets.
"""

from __future__ import annotations

import socket
from typing import Any

import paho.mqtt.client as paho
from paho.mqtt.enums import MQTTErrorCode

READ_BYTES = 64 * 1024
PACKETS_A_TURN = 200  # then writes and keep-alive have their turn, however much comes in


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

    def __getattr__(self, name: str) -> Any:
        return getattr(self._sock, name)


class BufferedClient(paho.Client):
    """``paho.Client`` over a ``BufferedSocket``."""

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
            result = super().loop_read(max_packets)
        return result
