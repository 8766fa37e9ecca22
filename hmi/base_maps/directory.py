"""Directories of a PMTiles archive, unpacked with a bound: a stranger's file must not fill the memory.

Source: PMTiles specification 3, section 4 (directories).
"""

from __future__ import annotations

import zlib

from pmtiles.tile import Compression, Entry

from hmi.base_maps import limits
from hmi.base_maps.errors import BadBaseMap

_GZIP = 16 + zlib.MAX_WBITS
DAMAGED = "The file is damaged: its list of tiles cannot be read. Copy it again, or write it anew."


def unpacked(data: bytes, compression: Compression, most: int) -> bytes:
    """Return ``data`` as it was before it was packed.

    Raises:
        BadBaseMap: it is packed in a way that is not read here, damaged, or larger than ``most`` bytes.
    """
    if compression is Compression.NONE:
        return data
    if compression is not Compression.GZIP:
        name = compression.name.lower()
        raise BadBaseMap("packing", f"The file is packed with {name}. Write it with gzip, which every program can.")
    packer = zlib.decompressobj(_GZIP)
    try:
        plain = packer.decompress(data, most)
    except zlib.error as error:
        raise BadBaseMap("damaged", DAMAGED) from error
    if packer.unconsumed_tail:
        raise BadBaseMap("too_large", "The list of tiles unpacks to far more than it should. The file is refused.")
    if not packer.eof:
        raise BadBaseMap("damaged", DAMAGED)
    return plain


def directory(data: bytes, compression: Compression) -> list[Entry]:
    """Return the entries of one directory, ascending; raises ``BadBaseMap``."""
    numbers = _varints(unpacked(data, compression, limits.DIRECTORY_BYTES))
    count = numbers[0] if numbers else 0
    if not 0 < count <= limits.DIRECTORY_ENTRIES or len(numbers) != 1 + 4 * count:
        raise BadBaseMap("damaged", DAMAGED)
    steps, runs, lengths, offsets = (numbers[1 + i * count : 1 + (i + 1) * count] for i in range(4))
    entries: list[Entry] = []
    tile_id, end = 0, 0
    for i, (step, run, length, offset) in enumerate(zip(steps, runs, lengths, offsets, strict=True)):
        tile_id += step
        start = end if i and offset == 0 else offset - 1
        if start < 0 or length == 0 or (i and step == 0):
            raise BadBaseMap("damaged", DAMAGED)
        entries.append(Entry(tile_id, start, length, run))
        end = start + length
    return entries


def _varints(data: bytes) -> list[int]:
    numbers: list[int] = []
    value = shift = 0
    for byte in data:
        value |= (byte & 0x7F) << shift
        if byte & 0x80:
            shift += 7
            if shift > 63:
                raise BadBaseMap("damaged", DAMAGED)
        else:
            numbers.append(value)
            value = shift = 0
    if shift:
        raise BadBaseMap("damaged", DAMAGED)
    return numbers
