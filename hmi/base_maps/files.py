"""Base maps on disk: finished archives by farm and hash, uploads in folders of their own. Blocking."""

from __future__ import annotations

import contextlib
import os
import re
import shutil
from collections import OrderedDict
from pathlib import Path
from threading import Lock

from hmi.base_maps.archive import TileArchive
from hmi.base_maps.errors import BadBaseMap

OPEN_ARCHIVES = 16  # whose directories stay in memory
RESERVE_BYTES = 1_000_000_000  # the database and the audit log live on the same disk
_SHA256 = re.compile(r"[0-9a-f]{64}")
_NAME = re.compile(r"[a-z0-9][a-z0-9_-]{0,63}")


class BaseMapFiles:
    """The folder of base maps."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._incoming = folder / "incoming"
        self._open: OrderedDict[Path, TileArchive] = OrderedDict()
        self._lock = Lock()

    def prepare(self) -> None:
        """Throw away what an earlier process was still working on."""
        shutil.rmtree(self._incoming, ignore_errors=True)

    def begin(self, work_id: str) -> Path:
        """Return a fresh folder for one upload."""
        folder = self._incoming / _checked(work_id, _NAME)
        folder.mkdir(mode=0o700, parents=True)
        return folder

    def end(self, work_id: str) -> None:
        """Remove the folder of an upload with all that is in it."""
        shutil.rmtree(self._incoming / _checked(work_id, _NAME), ignore_errors=True)

    def free_bytes(self) -> int:
        """Return how much may still be written to this disk."""
        self._folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        return max(0, shutil.disk_usage(self._folder).free - RESERVE_BYTES)

    def keep(self, made: Path, farm_id: str, sha256: str) -> None:
        """Move a finished archive to its place."""
        place = self._place(farm_id, sha256)
        place.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        os.replace(made, place)

    def remove(self, farm_id: str, sha256: str) -> None:
        """Delete an archive; one that is gone already is no error."""
        place = self._place(farm_id, sha256)
        with self._lock:
            self._open.pop(place, None)
        with contextlib.suppress(FileNotFoundError):
            place.unlink()

    def is_there(self, farm_id: str, sha256: str) -> bool:
        """Say whether the archive is where it should be."""
        return self._place(farm_id, sha256).is_file()

    def archive(self, farm_id: str, sha256: str) -> TileArchive:
        """Return an archive; raises ``BadBaseMap`` and ``OSError``."""
        place = self._place(farm_id, sha256)
        with self._lock:
            found = self._open.get(place)
            if found is not None:
                self._open.move_to_end(place)
                return found
        made = TileArchive(place)
        with self._lock:
            self._open[place] = made
            while len(self._open) > OPEN_ARCHIVES:
                self._open.popitem(last=False)
        return made

    def _place(self, farm_id: str, sha256: str) -> Path:
        return self._folder / _checked(farm_id, _NAME) / f"{_checked(sha256, _SHA256)}.pmtiles"


def _checked(name: str, pattern: re.Pattern[str]) -> str:
    """Refuse a name that could lead out of the folder; all of them are made here, so this never happens."""
    if not pattern.fullmatch(name) or name == "incoming":
        raise BadBaseMap("name", "This base map has no proper name.")
    return name
