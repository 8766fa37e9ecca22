"""Zip archives from strangers: read in memory only, and only what a map needs."""

from __future__ import annotations

import io
import stat
import struct
import zipfile
import zlib

from hmi.map_files import limits
from hmi.map_files.errors import BadMapFile

MAGIC = b"PK\x03\x04"
EMPTY_MAGIC = b"PK\x05\x06"
PACKED = (".zip", ".kmz", ".7z", ".rar", ".gz", ".tgz", ".bz2", ".xz", ".tar")
_BROKEN = (zipfile.BadZipFile, zipfile.LargeZipFile, zlib.error, struct.error, EOFError, OSError, ValueError,
           NotImplementedError, RuntimeError, IndexError, OverflowError)  # fmt: skip


class Archive:
    """An opened archive whose directory has been checked.

    Raises:
        BadMapFile: damaged, locked, too large, too many entries, packed too well, archives inside, or paths that
            lead out of it.
    """

    def __init__(self, data: bytes) -> None:
        try:
            self._zip = zipfile.ZipFile(io.BytesIO(data))
        except _BROKEN as error:
            text = "The archive is damaged or cut off. Copy or download it once more."
            raise BadMapFile("damaged_archive", text) from error
        self._entries = {info.filename: info for info in self._checked(self._zip.infolist())}

    @property
    def names(self) -> list[str]:
        """Return the paths of the files inside, sorted; folders and what Finder adds left out."""
        return sorted(self._entries)

    def ending(self, *suffixes: str) -> list[str]:
        """Return the paths that end with one of ``suffixes``, in any case."""
        return [name for name in self.names if name.lower().endswith(suffixes)]

    def read(self, name: str) -> bytes:
        """Return the content of one file.

        Raises:
            BadMapFile: it is damaged, locked, or an archive itself.
        """
        info = self._entries[name]
        try:
            with self._zip.open(info) as entry:
                data = entry.read(info.file_size + 1)
        except _BROKEN as error:
            text = f"{_short(name)} in the archive is damaged. Copy or download the file once more."
            raise BadMapFile("damaged_archive", text) from error
        if len(data) > info.file_size:
            raise BadMapFile("archive_bomb", f"{_short(name)} in the archive is larger than it says. It is refused.")
        if data.startswith(MAGIC):
            raise _nested(name)
        return data

    def _checked(self, infos: list[zipfile.ZipInfo]) -> list[zipfile.ZipInfo]:
        if len(infos) > limits.ENTRIES:
            text = f"The archive holds {len(infos):,} files; {limits.ENTRIES:,} are the limit. Pack only the map."
            raise BadMapFile("too_many_files", text)
        if sum(info.file_size for info in infos) > limits.UNPACKED_BYTES:
            text = f"The archive holds more than {limits.UNPACKED_BYTES // 1_000_000} MB. Pack only the map."
            raise BadMapFile("archive_bomb", text)
        for info in infos:
            _check_path(info)
            _check_packing(info)
        return [info for info in infos if not info.is_dir() and not _is_clutter(info.filename)]


def _check_path(info: zipfile.ZipInfo) -> None:
    parts = info.filename.replace("\\", "/").split("/")
    is_absolute = parts[0] == "" or parts[0].endswith(":")
    if is_absolute or ".." in parts or "\0" in info.orig_filename:
        text = f"The archive holds a path that leads out of it: {_short(info.filename)}. It is refused."
        raise BadMapFile("unsafe_path", text)
    if stat.S_ISLNK(info.external_attr >> 16):
        text = f"The archive holds a link ({_short(info.filename)}) in place of a file. Pack the file itself."
        raise BadMapFile("unsafe_path", text)


def _check_packing(info: zipfile.ZipInfo) -> None:
    if info.flag_bits & 0x1:
        raise BadMapFile("locked_archive", "The archive is locked with a password. Pack it without one.")
    if info.compress_type not in {zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED}:
        raise BadMapFile("odd_archive", "The archive is packed in an unusual way. Pack it as an ordinary zip.")
    if info.file_size > limits.RATIO_FROM_BYTES and info.file_size > limits.RATIO * max(1, info.compress_size):
        text = f"{_short(info.filename)} unpacks to more than {limits.RATIO} times its size. The archive is refused."
        raise BadMapFile("archive_bomb", text)
    if info.filename.lower().endswith(PACKED) and not _is_clutter(info.filename):
        raise _nested(info.filename)


def _nested(name: str) -> BadMapFile:
    text = f"The archive holds another archive ({_short(name)}). Unpack it and import what is inside."
    return BadMapFile("nested_archive", text)


def _is_clutter(name: str) -> bool:
    return name.startswith("__MACOSX/") or name.rsplit("/", 1)[-1].startswith(".")


def _short(name: str) -> str:
    return "".join(c if c.isprintable() else "?" for c in name)[:60]
