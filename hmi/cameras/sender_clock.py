"""When an RTSP camera took what it sends, by its own clock: told by the reports that it sends beside its pictures.

Pictures by TCP can wait in the camera's send buffer for seconds, and arrival says nothing of that. Each RTP packet has
a time stamp, and sender reports (RTCP) say now and then what the camera's clock showed at one of them.
"""

from __future__ import annotations

from hmi.cameras.transit import Transit

FRAME, HEAD_BYTES = 0x24, 4  # "$", channel, length: RTP between the words of RTSP (RFC 2326, 10.12)
REPORT, REPORT_BYTES = 200, 20
RTCP = range(200, 208)
CLOCK_PER_MS = 90.0
REORDERED_MS = 2000.0  # pictures between two others (B) come after the later one and tell nothing of the way
MOST_WORDS = 64 * 1024
_WORDS_END = b"\r\n\r\n"


class SenderClock:
    """Reads what a camera says after it was asked to play. Times in ms.

    ``waited_ms`` is how much longer than the quickest the newest picture was under way; 0 without reports.
    """

    def __init__(self) -> None:
        self.waited_ms = 0.0
        self._transit = Transit()
        self._buffer = bytearray()
        self._is_lost = False
        self._report: tuple[bytes, float, int] | None = None
        self._newest: tuple[bytes, int] | None = None  # source and time stamp

    def feed(self, data: bytes, came_ms: float) -> None:
        """Take what came next; after anything that is not understood it says nothing any more."""
        if self._is_lost:
            return
        self._buffer += data
        while self._buffer and (length := self._next_length()):
            if self._buffer[0] == FRAME:
                self._frame(bytes(self._buffer[HEAD_BYTES : min(length, HEAD_BYTES + REPORT_BYTES)]), came_ms)
            del self._buffer[:length]
        if len(self._buffer) > 2 * MOST_WORDS:
            self._give_up()

    def _next_length(self) -> int:
        """Return how many bytes the next frame or answer has, 0 while it is not whole."""
        if self._buffer[0] == FRAME:
            length = HEAD_BYTES + int.from_bytes(self._buffer[2:4], "big")
            return length if len(self._buffer) >= max(HEAD_BYTES, length) else 0
        if not b"RTSP/".startswith(self._buffer[:5]):
            self._give_up()
            return 0
        end = self._buffer.find(_WORDS_END)
        if end < 0:
            return 0
        length = end + len(_WORDS_END) + _body_bytes(bytes(self._buffer[:end]))
        return length if len(self._buffer) >= length else 0

    def _frame(self, packet: bytes, came_ms: float) -> None:
        if len(packet) < 12 or packet[0] >> 6 != 2:
            return
        if packet[1] in RTCP:
            if packet[1] == REPORT and len(packet) >= REPORT_BYTES:
                ntp_ms = int.from_bytes(packet[8:16], "big") * 1000 / 2**32
                self._report = packet[4:8], ntp_ms, int.from_bytes(packet[16:20], "big")
            return
        source, stamp = packet[8:12], int.from_bytes(packet[4:8], "big")
        if self._report is None or self._report[0] != source or (source, stamp) == self._newest:
            return
        if self._newest is not None and self._newest[0] == source:
            before_ms = -_apart(stamp, self._newest[1]) / CLOCK_PER_MS
            if 0 < before_ms < REORDERED_MS:
                return
        self._newest = source, stamp
        taken_ms = self._report[1] + _apart(stamp, self._report[2]) / CLOCK_PER_MS
        self.waited_ms = self._transit.waited_ms(taken_ms, came_ms)

    def _give_up(self) -> None:
        self._is_lost, self.waited_ms = True, 0.0
        self._buffer.clear()


def _apart(stamp: int, other: int) -> int:
    """Return how much later one time stamp is than another; they begin again at 0."""
    ticks = (stamp - other) & 0xFFFFFFFF
    return ticks - (ticks >> 31 << 32)


def _body_bytes(head: bytes) -> int:
    for line in head.decode("latin-1").lower().split("\r\n"):
        name, _, value = line.partition(":")
        if name == "content-length" and value.strip().isdigit() and len(value) < 9:
            return int(value)
    return 0
