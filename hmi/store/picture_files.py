"""Pictures on disk: finished files by farm and month, what is being written beside them. Blocking.

A file is written and flushed under another name and then moved, so that under its own name it is whole or not there.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import re
import shutil
from collections.abc import Callable, Collection
from datetime import datetime
from pathlib import Path

ENDINGS = {"image/jpeg": "jpg", "image/png": "png", "video/mp4": "mp4"}
_FARM = re.compile(r"[a-z0-9][a-z0-9_-]{0,63}")
_PICTURE = re.compile(r"[0-9a-f]{32}")
_NAMED = re.compile(r"([0-9a-f]{32})\.(?:jpg|png|mp4)")
_CHUNK = 1 << 20

FreeBytes = Callable[[Path], int]


def free_bytes(folder: Path) -> int:
    """Return how much the disk of a folder has left."""
    return shutil.disk_usage(folder).free


class PictureFiles:
    """The folder of pictures.

    Args:
        free: tells what is left on the disk of a folder.
    """

    def __init__(self, folder: Path, free: FreeBytes = free_bytes) -> None:
        self._folder, self._free = folder, free
        self._kept, self._incoming, self._newest = folder / "kept", folder / "incoming", folder / "newest"

    def prepare(self) -> None:
        """Make the folders; throw away what an earlier process was still writing."""
        shutil.rmtree(self._incoming, ignore_errors=True)
        for folder in (self._folder, self._kept, self._incoming, self._newest):
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)

    def free_bytes(self) -> int:
        """Return how much the disk has left; raises ``OSError``."""
        return self._free(self._folder)

    def incoming(self, picture_id: str, media_type: str) -> Path:
        """Return where a file may be written before it is taken."""
        return self._incoming / f"{_checked(picture_id, _PICTURE)}.{ENDINGS[media_type]}"

    def write(self, picture_id: str, media_type: str, data: bytes) -> Path:
        """Write bytes to the place of what is coming in; raises ``OSError``."""
        path = self.incoming(picture_id, media_type)
        with open(path, "xb") as file:
            file.write(data)
        return path

    def take(self, farm_id: str, picture_id: str, media_type: str, at: datetime) -> tuple[int, str]:
        """Flush a file that came in and move it to its place; return its size and SHA-256. Raises ``OSError``."""
        path = self.incoming(picture_id, media_type)
        seen, size = hashlib.sha256(), 0
        with open(path, "rb") as file:
            while chunk := file.read(_CHUNK):
                seen.update(chunk)
                size += len(chunk)
            os.fsync(file.fileno())
        place = self._place(farm_id, picture_id, media_type, at)
        place.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        os.replace(path, place)
        _flush_folder(place.parent)
        return size, seen.hexdigest()

    def drop(self, picture_id: str, media_type: str) -> None:
        """Throw away what came in."""
        self.incoming(picture_id, media_type).unlink(missing_ok=True)

    def path(self, farm_id: str, picture_id: str, media_type: str, at: datetime) -> Path:
        """Return where a picture is; raises ``FileNotFoundError``."""
        place = self._place(farm_id, picture_id, media_type, at)
        if not place.is_file():
            raise FileNotFoundError(place.name)
        return place

    def remove(self, farm_id: str, picture_id: str, media_type: str, at: datetime) -> None:
        """Delete a picture; one that is gone already is no error."""
        place = self._place(farm_id, picture_id, media_type, at)
        place.unlink(missing_ok=True)
        with contextlib.suppress(OSError):  # others are in it
            place.parent.rmdir()

    def strays(self, farm_id: str, known: Collection[str]) -> list[Path]:
        """Return files of a farm that nobody knows of: a crash came between file and record."""
        folder = self._kept / _checked(farm_id, _FARM)
        return [path for path in folder.glob("*/*") if (named := _NAMED.fullmatch(path.name)) and named[1] not in known]

    def set_newest(self, farm_id: str, camera: str, data: bytes, taken_unix_s: float) -> None:
        """Replace the newest frame of a field camera; a power cut may lose it. Raises ``OSError``."""
        place = self._newest_place(farm_id, camera)
        place.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        beside = place.with_suffix(".new")
        beside.write_bytes(data)
        os.utime(beside, (taken_unix_s, taken_unix_s))
        os.replace(beside, place)

    def newest(self, farm_id: str, camera: str) -> tuple[bytes, float] | None:
        """Return the newest frame of a field camera and when it was taken, Unix seconds; ``None`` without one."""
        place = self._newest_place(farm_id, camera)
        try:
            with open(place, "rb") as file:
                return file.read(), os.fstat(file.fileno()).st_mtime
        except FileNotFoundError:
            return None

    def drop_newest(self, farm_id: str, camera: str) -> None:
        """Forget the newest frame of a field camera."""
        self._newest_place(farm_id, camera).unlink(missing_ok=True)

    def _newest_place(self, farm_id: str, camera: str) -> Path:
        return self._newest / _checked(farm_id, _FARM) / f"{_checked(camera, _FARM)}.picture"

    def _place(self, farm_id: str, picture_id: str, media_type: str, at: datetime) -> Path:
        name = f"{_checked(picture_id, _PICTURE)}.{ENDINGS[media_type]}"
        return self._kept / _checked(farm_id, _FARM) / f"{at:%Y-%m}" / name


def _flush_folder(folder: Path) -> None:
    """Make a rename last through a power cut."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _checked(name: str, pattern: re.Pattern[str]) -> str:
    """Refuse a name that could lead out of the folder."""
    if not pattern.fullmatch(name):
        raise FileNotFoundError(name)
    return name
