"""RTP packets of H.264 to access units, as soon as the last packet of one came."""

from __future__ import annotations

from aiortc.codecs.h264 import h264_depayload
from aiortc.rtp import RtpPacket

_START = b"\x00\x00\x00\x01"
_KEY, _PARAMETERS = 5, 7
MAX_UNIT_BYTES = 4 * 1024 * 1024


class Depacketizer:
    """Puts units together; one that lost a packet is left out, with all that follow up to a key picture."""

    def __init__(self) -> None:
        self._data = bytearray()
        self._timestamp: int | None = None
        self._next: int | None = None
        self._is_broken = True
        self.lost = 0

    @property
    def needs_key(self) -> bool:
        """Whether only a key picture helps."""
        return self._is_broken

    def add(self, packet: RtpPacket) -> tuple[bytes, bool] | None:
        """Return a unit (Annex B) and whether it is a key picture, when ``packet`` is its last."""
        if self._next is not None and packet.sequence_number != self._next:
            if (packet.sequence_number - self._next) & 0x8000:
                return None  # late or twice
            self.lost += 1
            self._is_broken = True
            self._data.clear()
        self._next = (packet.sequence_number + 1) & 0xFFFF
        if packet.timestamp != self._timestamp:
            self._timestamp = packet.timestamp
            self._data.clear()
        try:
            self._data += h264_depayload(packet.payload)
        except (ValueError, IndexError):
            self._is_broken = True
            return None
        if len(self._data) > MAX_UNIT_BYTES:
            self._is_broken = True
            self._data.clear()
        return self._whole() if packet.marker else None

    def _whole(self) -> tuple[bytes, bool] | None:
        data = bytes(self._data)
        self._data.clear()
        is_key = is_key_unit(data)
        if not data or (self._is_broken and not is_key):
            return None
        self._is_broken = False
        return data, is_key


def is_key_unit(data: bytes) -> bool:
    """Say whether an access unit can be decoded alone."""
    kinds = {part[0] & 0x1F for part in data.split(_START)[1:] if part}
    return _KEY in kinds and _PARAMETERS in kinds
