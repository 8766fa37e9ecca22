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
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

ENDINGS = {"image/jpeg": "jpg", "image/png": "png", "video/mp4": "mp4"}
_FARM = re.compile(r"[a-z0-9][a-z0-9_-]{0,63}")
_PICTURE = re.compile(r"[0-9a-f]{32}")
_NAMED = re.compile(r"([0-9a-f]{32})\.(?:jpg|png|mp4)")
_CHUNK = 1 << 20

FreeBytes = Callable[[Path], int]


@dataclass(frozen=True, slots=True)
class NewestFrame:
    """What a field camera sent last; ``taken_unix_s`` is when it came where the camera told no age (not dated)."""

    data: bytes
    taken_unix_s: float
    is_dated: bool


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

    def set_newest(self, farm_id: str, camera: str, frame: NewestFrame) -> None:
        """Replace the newest frame of a field camera; a power cut may lose it. Raises ``OSError``."""
        place, other = self._newest_places(farm_id, camera, is_dated=frame.is_dated)
        place.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        beside = place.with_suffix(".new")
        beside.write_bytes(frame.data)
        os.utime(beside, (frame.taken_unix_s, frame.taken_unix_s))
        os.replace(beside, place)
        other.unlink(missing_ok=True)

    def newest(self, farm_id: str, camera: str) -> NewestFrame | None:
        """Return the newest frame of a field camera; ``None`` without one."""
        found = None
        for is_dated in (True, False):
            place, _other = self._newest_places(farm_id, camera, is_dated=is_dated)
            with contextlib.suppress(FileNotFoundError), open(place, "rb") as file:
                taken_unix_s = os.fstat(file.fileno()).st_mtime
                if found is None or taken_unix_s > found.taken_unix_s:
                    found = NewestFrame(file.read(), taken_unix_s, is_dated)
        return found

    def newest_taken_unix_s(self, farm_id: str, camera: str) -> float:
        """Return when the newest frame of a field camera was taken; long ago without one."""
        taken = [float("-inf")]
        for place in self._newest_places(farm_id, camera, is_dated=True):
            with contextlib.suppress(FileNotFoundError):
                taken.append(place.stat().st_mtime)
        return max(taken)

    def drop_newest(self, farm_id: str, camera: str) -> None:
        """Forget the newest frame of a field camera."""
        for place in self._newest_places(farm_id, camera, is_dated=True):
            place.unlink(missing_ok=True)

    def _newest_places(self, farm_id: str, camera: str, *, is_dated: bool) -> tuple[Path, Path]:
        """Return where a frame is, and where the one would be of which the opposite is known about its time."""
        folder, name = self._newest / _checked(farm_id, _FARM), _checked(camera, _FARM)
        dated, undated = folder / f"{name}.picture", folder / f"{name}.undated.picture"
        return (dated, undated) if is_dated else (undated, dated)

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
