"""Reads ``multipart/x-mixed-replace``: pictures out of a stream of bytes, whatever the bytes are."""

from __future__ import annotations

import re
from dataclasses import dataclass

from hmi.cameras.jpeg_header import MAX_BYTES

MAX_HEAD_BYTES = 8 * 1024
_BOUNDARY = re.compile(r'boundary\s*=\s*(?:"([^"]{1,80})"|([^\s;"]{1,80}))', re.IGNORECASE)
_END_OF_HEAD = re.compile(rb"\r?\n\r?\n")


@dataclass(frozen=True, slots=True)
class Part:
    """One body with its headers (names in lower case); ``began_ms`` is when its first byte came, on the own clock."""

    body: bytes
    headers: dict[str, str]
    began_ms: float


class Refused(Exception):
    """The stream is not of this kind."""


def boundary_of(content_type: str) -> bytes:
    """Return the line that parts begin with; raises ``Refused``."""
    found = _BOUNDARY.search(content_type)
    if not content_type.lower().startswith("multipart/") or found is None:
        raise Refused(f"it sends {content_type[:60] or 'nothing with a name'} instead of a stream of pictures")
    name = (found[1] or found[2]).encode("latin-1", "replace")
    return name if name.startswith(b"--") else b"--" + name


class MultipartReader:
    """Bytes in, parts out. Keeps at most one part; what is too long or makes no sense is skipped and counted.

    Args:
        boundary: with its two dashes.
    """

    def __init__(self, boundary: bytes, max_bytes: int = MAX_BYTES) -> None:
        self._boundary, self._max_bytes = boundary, max_bytes
        self._buffer = bytearray()
        self._searched = 0
        self._began_ms = 0.0
        self._head: dict[str, str] | None = None
        self._length: int | None = None
        self._skip = 0
        self.too_large = 0
        self.garbage = 0

    def feed(self, data: bytes, at_ms: float) -> list[Part]:
        """Take what came at ``at_ms``; return the parts that are whole now, oldest first."""
        if self._skip:
            skipped = min(self._skip, len(data))
            self._skip -= skipped
            data = data[skipped:]
        self._buffer += data
        parts: list[Part] = []
        while self._step(parts, at_ms):
            pass
        return parts

    def _step(self, parts: list[Part], at_ms: float) -> bool:
        if self._head is None:
            return self._find_head(at_ms)
        if self._length is None:
            return self._find_end(parts)
        if len(self._buffer) < self._length:
            return False
        self._finish(parts, self._length)
        return True

    def _find_head(self, at_ms: float) -> bool:
        start = self._buffer.find(self._boundary)
        if start < 0:
            self._drop_garbage(max(0, len(self._buffer) - len(self._boundary)))
            return False
        if start > 2:  # a line end belongs to the boundary
            self.garbage += 1
        if start:
            del self._buffer[:start]
        end = _END_OF_HEAD.search(self._buffer, len(self._boundary), MAX_HEAD_BYTES)
        if end is None:
            if len(self._buffer) >= MAX_HEAD_BYTES:
                self.garbage += 1
                del self._buffer[: len(self._boundary)]
                return True
            return False
        self._head = _headers(bytes(self._buffer[len(self._boundary) : end.start()]))
        self._began_ms = at_ms  # not when its boundary came: many servers send that with the picture before
        del self._buffer[: end.end()]
        self._searched = 0
        return self._take_length()

    def _take_length(self) -> bool:
        said = (self._head or {}).get("content-length", "")
        self._length = int(said) if said.isascii() and said.isdigit() and len(said) <= 12 else None
        if self._length is not None and self._length > self._max_bytes:
            self.too_large += 1
            self._skip = max(0, self._length - len(self._buffer))
            del self._buffer[: self._length]
            self._reset()
            return self._skip == 0
        return True

    def _find_end(self, parts: list[Part]) -> bool:
        """Without a length a part ends where the next begins."""
        end = self._buffer.find(self._boundary, self._searched)
        if end >= 0:
            self._finish(parts, end)
            return True
        self._searched = max(0, len(self._buffer) - len(self._boundary))
        if len(self._buffer) > self._max_bytes:
            self.too_large += 1
            self._buffer.clear()
            self._reset()
        return False

    def _finish(self, parts: list[Part], length: int) -> None:
        body = bytes(self._buffer[:length])
        del self._buffer[:length]
        parts.append(Part(body, self._head or {}, self._began_ms))
        self._reset()

    def _reset(self) -> None:
        self._head, self._length, self._searched, self._began_ms = None, None, 0, 0.0

    def _drop_garbage(self, count: int) -> None:
        if count > 2:
            self.garbage += 1
            del self._buffer[:count]


def _headers(raw: bytes) -> dict[str, str]:
    found: dict[str, str] = {}
    for line in raw.decode("latin-1").splitlines():
        name, colon, value = line.partition(":")
        if colon:
            found[name.strip().lower()] = value.strip()
    return found
