"""Where audit entries wait on disk while the database cannot take them."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import Any

MAX_BYTES = 64 * 2**20  # some 200,000 entries; a farm makes a few thousand a day


class AuditSpill:
    """A file of JSON lines, used by one thread."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self.is_empty = not (path.exists() and path.stat().st_size)

    def append(self, rows: Sequence[dict[str, Any]]) -> None:
        """Add rows, all or none.

        Raises:
            OSError: nothing was added; also when the file has reached ``MAX_BYTES``.
        """
        text = "".join(json.dumps({**row, "at": row["at"].isoformat()}) + "\n" for row in rows).encode("utf-8")
        self._path.parent.mkdir(parents=True, exist_ok=True)
        descriptor = os.open(self._path, os.O_WRONLY | os.O_CREAT, 0o600)
        try:
            end = os.lseek(descriptor, 0, os.SEEK_END)
            if end + len(text) > MAX_BYTES:
                raise OSError(f"{self._path.name} is full")
            try:
                _write_whole(descriptor, text)
                os.fsync(descriptor)
            except OSError:
                os.ftruncate(descriptor, end)
                raise
        finally:
            os.close(descriptor)
        self.is_empty = False

    def read(self) -> tuple[list[dict[str, Any]], int]:
        """Return the rows in order, and how many lines were torn (a power cut while writing)."""
        rows: list[dict[str, Any]] = []
        torn = 0
        for line in self._path.read_text(encoding="utf-8", errors="replace").splitlines():
            try:
                row = json.loads(line)
                rows.append({**row, "at": datetime.fromisoformat(row["at"])})
            except (ValueError, KeyError, TypeError):
                torn += 1
        return rows, torn

    def clear(self) -> None:
        """Forget the rows; to be called once they are in the database."""
        self._path.unlink(missing_ok=True)
        self.is_empty = True


def _write_whole(descriptor: int, text: bytes) -> None:
    view = memoryview(text)
    while view:
        view = view[os.write(descriptor, view) :]
