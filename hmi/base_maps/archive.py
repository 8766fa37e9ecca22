"""Tiles out of a PMTiles 3 archive on disk.

No file is held open between tiles, so that a map can be deleted while somebody looks at it.
Blocking; call it off the event loop. Safe to use from several threads.
"""

from __future__ import annotations

import json
from collections import OrderedDict
from pathlib import Path
from threading import Lock
from typing import Any

from pmtiles.tile import (
    Compression,
    Entry,
    HeaderDict,
    MagicNumberNotFound,
    SpecVersionUnsupported,
    TileType,
    deserialize_header,
    find_tile,
    tileid_to_zxy,
    zxy_to_tileid,
)

from hmi.base_maps import limits
from hmi.base_maps.directory import DAMAGED, directory, unpacked
from hmi.base_maps.errors import BadBaseMap

HEADER_BYTES = 127
LEAVES_KEPT = 64  # of at most some thousand entries each, a few MB
MEDIA_TYPES = {
    TileType.MVT: "application/vnd.mapbox-vector-tile",
    TileType.PNG: "image/png",
    TileType.JPEG: "image/jpeg",
    TileType.WEBP: "image/webp",
}
_NOT_PMTILES = "This is no PMTiles file. Take one that ends in .pmtiles, or an aerial photo as GeoTIFF."


class TileArchive:
    """One archive.

    Raises (constructor):
        BadBaseMap: it is no PMTiles 3 archive of a kind that is shown here.
        OSError: it cannot be read.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._size = path.stat().st_size
        self.header = checked_header(self._read(0, min(HEADER_BYTES, self._size)), self._size)
        self._leaves: OrderedDict[int, list[Entry]] = OrderedDict()
        self._lock = Lock()
        header = self.header
        self._root = self._directory(header["root_offset"], header["root_length"])

    @property
    def is_packed(self) -> bool:
        """Whether its tiles are gzip streams."""
        return self.header["tile_compression"] is Compression.GZIP

    @property
    def media_type(self) -> str:
        """Media type of an unpacked tile."""
        return MEDIA_TYPES[self.header["tile_type"]]

    def metadata(self) -> dict[str, Any]:
        """Return what the writer of the archive says of it; raises ``BadBaseMap``."""
        header = self.header
        raw = self._read(header["metadata_offset"], header["metadata_length"])
        if not raw:
            return {}
        try:
            value = json.loads(unpacked(raw, header["internal_compression"], limits.METADATA_BYTES))
        except (ValueError, RecursionError) as error:
            raise BadBaseMap("damaged", "The description inside the file cannot be read. Write it anew.") from error
        return value if isinstance(value, dict) else {}

    def tile(self, z: int, x: int, y: int) -> bytes | None:
        """Return a tile as it is stored, ``None`` where there is none.

        Raises:
            BadBaseMap: the archive is damaged at this place.
            OSError: it cannot be read any more.
        """
        if not 0 <= z <= limits.MOST_ZOOM or not (0 <= x < 1 << z and 0 <= y < 1 << z):
            return None
        wanted = zxy_to_tileid(z, x, y)
        entries = self._root
        for _ in range(limits.DIRECTORIES_DEEP + 1):
            entry = find_tile(entries, wanted)
            if entry is None:
                return None
            if entry.run_length > 0:
                return self._tile_bytes(entry)
            entries = self._leaf(entry)
        raise BadBaseMap("damaged", DAMAGED)

    def some_tile(self) -> tuple[tuple[int, int, int], bytes]:
        """Return the first tile there is with its (z, x, y); raises ``BadBaseMap``."""
        entries = self._root
        for _ in range(limits.DIRECTORIES_DEEP + 1):
            first = entries[0]
            if first.run_length > 0:
                if first.tile_id >= zxy_to_tileid(limits.MOST_ZOOM + 1, 0, 0):
                    raise BadBaseMap("damaged", DAMAGED)
                return tileid_to_zxy(first.tile_id), self._tile_bytes(first)
            entries = self._leaf(first)
        raise BadBaseMap("damaged", DAMAGED)

    def _tile_bytes(self, entry: Entry) -> bytes:
        header = self.header
        if entry.length > limits.TILE_BYTES or entry.offset + entry.length > header["tile_data_length"]:
            raise BadBaseMap("damaged", DAMAGED)
        return self._read(header["tile_data_offset"] + entry.offset, entry.length)

    def _leaf(self, entry: Entry) -> list[Entry]:
        header = self.header
        if entry.offset + entry.length > header["leaf_directory_length"]:
            raise BadBaseMap("damaged", DAMAGED)
        with self._lock:
            kept = self._leaves.get(entry.offset)
            if kept is not None:
                self._leaves.move_to_end(entry.offset)
                return kept
        made = self._directory(header["leaf_directory_offset"] + entry.offset, entry.length)
        with self._lock:
            self._leaves[entry.offset] = made
            while len(self._leaves) > LEAVES_KEPT:
                self._leaves.popitem(last=False)
        return made

    def _directory(self, offset: int, length: int) -> list[Entry]:
        if length > limits.DIRECTORY_BYTES:
            raise BadBaseMap("damaged", DAMAGED)
        return directory(self._read(offset, length), self.header["internal_compression"])

    def _read(self, offset: int, length: int) -> bytes:
        with self._path.open("rb") as file:
            file.seek(offset)
            data = file.read(length)
        if len(data) != length:
            raise BadBaseMap("damaged", "The file is cut off: part of it is missing. Copy it again.")
        return data


def checked_header(data: bytes, size: int) -> HeaderDict:
    """Return the header of an archive of ``size`` bytes if it makes sense; raises ``BadBaseMap``."""
    try:
        header = deserialize_header(data.ljust(HEADER_BYTES, b"\0"))
    except (MagicNumberNotFound, UnicodeDecodeError) as error:
        raise BadBaseMap("not_pmtiles", _NOT_PMTILES) from error
    except SpecVersionUnsupported as error:
        text = "This PMTiles file is of an old version. Make version 3 of it: pmtiles convert old.pmtiles new.pmtiles"
        raise BadBaseMap("old_version", text) from error
    except ValueError as error:
        raise BadBaseMap("damaged", "The head of the file makes no sense. Write it anew.") from error
    if len(data) < HEADER_BYTES:
        raise BadBaseMap("damaged", "The file is cut off: part of it is missing. Copy it again.")
    _check_type(header)
    _check_places(header, size)
    _check_view(header)
    return header


def _check_type(header: HeaderDict) -> None:
    kind, packing = header["tile_type"], header["tile_compression"]
    if kind not in MEDIA_TYPES:
        text = f"Its tiles are {kind.name.lower()}. Browsers here show png, jpeg, webp and mvt: convert it."
        raise BadBaseMap("tile_type", text)
    allowed = {Compression.NONE, Compression.GZIP} if kind is TileType.MVT else {Compression.NONE, Compression.UNKNOWN}
    if packing not in allowed:
        raise BadBaseMap("packing", f"Its tiles are packed with {packing.name.lower()}. Write them with gzip or plain.")


def _check_places(header: HeaderDict, size: int) -> None:
    for part in ("root", "metadata", "leaf_directory", "tile_data"):
        offset, length = int(header[f"{part}_offset"]), int(header[f"{part}_length"])  # type: ignore[literal-required]
        if length and (offset < HEADER_BYTES or offset + length > size):
            raise BadBaseMap("damaged", "The file is cut off: part of it is missing. Copy it again.")
    if not header["root_length"] or not header["tile_data_length"]:
        raise BadBaseMap("empty", "There are no tiles in this file.")


def _check_view(header: HeaderDict) -> None:
    if not header["min_zoom"] <= header["max_zoom"] <= limits.MOST_ZOOM:
        raise BadBaseMap("zooms", "Its zooms make no sense. Write the file anew with zooms from 0 to 24.")
    west, east, south, north = (header[f"{key}_e7"] / 1e7 for key in ("min_lon", "max_lon", "min_lat", "max_lat"))  # type: ignore[literal-required]
    if not (-180 <= west < east <= 180 and -90 <= south < north <= 90):
        raise BadBaseMap("bounds", "It does not say where on Earth it lies. Write the file anew with its bounds.")
