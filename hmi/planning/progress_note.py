"""How far a plan is, told from one process to another by a small file: it needs no thread and outlives a kill."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path

NOTE_BYTES = 96
NOTE_S = 0.1


class ProgressNote:
    """Writes share and words into a file, ten times a second at most; each is one write of one size.

    The file must exist. Used as a context it gives the function that writes.
    """

    def __init__(self, path: Path) -> None:
        self._path, self._next_s, self._most = path, 0.0, 0.0

    def __enter__(self) -> Callable[[float, str], None]:
        self._file = os.open(self._path, os.O_WRONLY)
        return self._tell

    def __exit__(self, *_error: object) -> None:
        os.close(self._file)

    def _tell(self, share: float, words: str) -> None:
        now_s = time.monotonic()
        if now_s < self._next_s:
            return
        self._next_s, self._most = now_s + NOTE_S, max(self._most, share)
        text = f"{self._most:.3f} {words}".encode()[:NOTE_BYTES]
        os.lseek(self._file, 0, os.SEEK_SET)
        os.write(self._file, text.ljust(NOTE_BYTES))


def read_progress(path: Path) -> tuple[float, str]:
    """Return share and words of a plan under way; nothing yet is 0 and ``Starting``."""
    try:
        share, _, words = path.read_text("utf-8", "replace").strip().partition(" ")
        return min(1.0, max(0.0, float(share))), words
    except (OSError, ValueError):
        return 0.0, "Starting"
