"""Zipped shapefiles (Esri white paper "Shapefile Technical Description", 1998), one or several layers in a zip."""

from __future__ import annotations

import codecs
import io
import json
import math
import struct
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import shapefile

from hmi.map_files import limits
from hmi.map_files.archive import Archive
from hmi.map_files.attribute_text import decode
from hmi.map_files.attributes import usable_id
from hmi.map_files.coordinate_system import CoordinateSystem, UnknownSystem, from_wkt
from hmi.map_files.errors import BadMapFile
from hmi.map_files.imported import Skipped
from hmi.map_files.kind_guess import ALL_KINDS
from hmi.map_files.source import Source, SourceFeature, SourceLayer

MAGIC = b"\x00\x00\x27\x0a"  # file code 9994
FIELDS_SUFFIX = ".fields.json"  # true names of the columns; written by this program, see shapefile_writer
_ERRORS = (shapefile.ShapefileException, struct.error, ValueError, IndexError, KeyError, TypeError, AssertionError,
           AttributeError, OverflowError, EOFError, OSError, RuntimeError, ArithmeticError)  # fmt: skip
_CODE_PAGES = {"65001": "utf-8", "utf8": "utf-8", "1252": "cp1252", "ansi 1252": "cp1252", "ansi": "cp1252",
               "28591": "latin-1", "88591": "latin-1", "iso88591": "latin-1", "system": "cp1252"}  # fmt: skip
# byte 29 of a .dbf, the language driver (dBase, Esri)
_DRIVERS = {0x01: "cp437", 0x02: "cp850", 0x13: "cp932", 0x1F: "cp852", 0x22: "cp852", 0x23: "cp852", 0x26: "cp866",
            0x4D: "cp936", 0x4E: "cp949", 0x4F: "cp950", 0x50: "cp874", 0x64: "cp852", 0x65: "cp866", 0x66: "cp865",
            0x67: "cp861", 0x6A: "cp737", 0x6B: "cp857", 0x6C: "cp863", 0x78: "cp950", 0x79: "cp949", 0x7A: "cp936",
            0x7B: "cp932", 0x7C: "cp874", 0x7D: "cp1255", 0x7E: "cp1256", 0xC8: "cp1250", 0xC9: "cp1251",
            0xCA: "cp1254", 0xCB: "cp1253", 0xCC: "cp1257"}  # fmt: skip
CUT_LETTERS = 10  # so many whole letters beyond ASCII for each that is cut: it is UTF-8


@dataclass(frozen=True, slots=True)
class _Files:
    """The bytes of one layer by suffix; only ``.shp`` is always there."""

    name: str
    of: dict[str, bytes]


def read(archive: Archive) -> Source:
    """Return the layers of a zip.

    Raises:
        BadMapFile: not one of them can be read, or the only one has no coordinate system.
    """
    source = Source("shapefile", [])
    reasons: list[BadMapFile] = []
    for path in archive.ending(".shp"):
        files = _files(archive, path)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # what is wrong is told to the operator, not to the log
                source.layers.append(_layer(files, source.skipped))
        except BadMapFile as error:
            reasons.append(error)
            source.skipped.append(Skipped(files.name, error.text, "Export this layer once more."))
    if not source.layers and reasons:
        raise reasons[0]
    return source


def _files(archive: Archive, path: str) -> _Files:
    stem = path[: -len(".shp")]
    found = {}
    for suffix in (".shp", ".shx", ".dbf", ".prj", ".cpg", FIELDS_SUFFIX):
        same = [name for name in archive.ending(suffix) if name[: -len(suffix)].lower() == stem.lower()]
        if same:
            found[suffix] = archive.read(path if suffix == ".shp" else same[0])
    return _Files(stem.replace("\\", "/").rsplit("/", 1)[-1][:80], found)


def _layer(files: _Files, skipped: list[Skipped]) -> SourceLayer:
    crs = _system(files)
    table, notes = _opened(files)
    has_records = not notes
    fields = _fields(files)
    layer = SourceLayer(files.name, crs, [])
    with table:
        for i, feature in _features(table, files, skipped, has_records=has_records):
            feature.problems += notes
            _name_fields(feature, fields)
            feature.which = f"shape {i + 1}"
            layer.features.append(feature)
    return layer


def _system(files: _Files) -> CoordinateSystem | None:
    if ".prj" not in files.of:
        return None
    try:
        return from_wkt(files.of[".prj"].decode("utf-8", "replace").strip("\ufeff\0 \r\n"))
    except UnknownSystem as error:
        text = f"{files.name}: {error} Export the layer in WGS84 (EPSG:4326)."
        raise BadMapFile("no_coordinate_system", text) from error


def _opened(files: _Files) -> tuple[Any, list[str]]:
    """Return a reader with what is whole: without its index or its attributes if need be, and says so."""
    kinds = {"shp": ".shp", "shx": ".shx", "dbf": ".dbf"}
    notes: list[str] = []
    for without in ((), ("shx",), ("shx", "dbf")):
        streams = {k: io.BytesIO(files.of[s]) for k, s in kinds.items() if s in files.of and k not in without}
        if "dbf" not in streams:
            notes = ["Its attributes are missing: there is no readable .dbf file beside it."]
        try:
            reader = shapefile.Reader(**streams, encoding=_encoding(files), encodingErrors="replace")
            _check_length(reader, streams)
        except _ERRORS:
            continue
        return reader, notes
    text = f"{files.name}.shp is damaged or cut off. Export it once more, with its .shx and .dbf files."
    raise BadMapFile("damaged_shapefile", text)


def _check_length(reader: Any, streams: dict[str, io.BytesIO]) -> None:
    if len(reader) > limits.FEATURES:
        raise BadMapFile("too_many_features", f"The layer has more than {limits.FEATURES:,} shapes. Split it.")
    if "dbf" in streams and reader.numRecords != len(reader):
        raise ValueError("shapes and records do not match")
    if reader.shapeType == shapefile.MULTIPATCH:
        raise BadMapFile("not_a_map", "The layer holds three-dimensional bodies. Export outlines.")


def _features(
    reader: Any, files: _Files, skipped: list[Skipped], *, has_records: bool
) -> Iterator[tuple[int, SourceFeature]]:
    for i in range(len(reader)):
        try:
            feature = SourceFeature("", _geometry(reader.shape(i)))
            if has_records:
                feature.properties = _record(reader, i)
        except _ERRORS:
            which = f"{files.name}: shape {i + 1}"
            skipped.append(Skipped(which, "The shape is damaged or cut off.", "Export the layer once more."))
            continue
        yield i, feature


def _record(reader: Any, i: int) -> dict[str, Any]:
    record = reader.record(i)
    return {} if record is None else record.as_dict()


def _geometry(shape: Any) -> Any:
    if shape is None or shape.shapeType == shapefile.NULL:
        return None
    points = [[float(x), float(y)] for x, y, *_ in shape.points]
    if not all(math.isfinite(n) for place in points for n in place):
        return {"type": "Point", "coordinates": [math.nan, math.nan]}  # is refused with the right words
    geometry = shape.__geo_interface__
    return {"type": geometry["type"], "coordinates": _lists(geometry["coordinates"])}


def _lists(coordinates: Any) -> Any:
    if coordinates and isinstance(coordinates[0], (int, float)):
        return list(coordinates[:2])
    return [_lists(part) for part in coordinates]


def _encoding(files: _Files) -> str:
    """Return how the texts of the attributes are written: as the .cpg says, as UTF-8 if they are, as the .dbf says."""
    told = files.of.get(".cpg", b"").decode("ascii", "ignore").strip().lower()
    told = _CODE_PAGES.get(told.replace("-", ""), told.removeprefix("ansi ").removeprefix("oem "))
    try:
        return codecs.lookup(told).name
    except (LookupError, ValueError):
        pass
    table = files.of.get(".dbf", b"")
    head = int.from_bytes(table[8:10], "little")  # before it stand the columns, whose lengths are no text
    text = table[head:].decode("utf-8", "replace")
    broken = text.count("\ufffd")  # a letter that the end of its column cuts in two
    if CUT_LETTERS * broken <= sum(letter > "\x7f" for letter in text) - broken:
        return "utf-8"
    return _DRIVERS.get(int.from_bytes(table[29:30], "little"), "cp1252")


def _fields(files: _Files) -> dict[str, list[str]]:
    """Return the columns of each attribute of a file of ours: true name to column names; empty for others."""
    try:
        told = json.loads(files.of.get(FIELDS_SUFFIX, b"{}"))
        fields = told["attributes"]
        is_ours = all(isinstance(n, str) and isinstance(c, list) for n, c in fields.items())
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return {}
    return fields if is_ours else {}


def _name_fields(feature: SourceFeature, fields: dict[str, list[str]]) -> None:
    """Make a feature of ours exact: its columns joined, named and decoded."""
    texts = {}
    for name, columns in fields.items():
        text = "".join(str(feature.properties.get(str(column)) or "") for column in columns)
        if text:
            texts[name] = decode(text)
    kind, own_id, name = texts.pop("kind", None), usable_id(texts.pop("id", None)), texts.pop("name", "")
    if isinstance(kind, str) and kind in ALL_KINDS and own_id and isinstance(name, str):
        feature.is_exact, feature.kind, feature.id, feature.name = True, kind, own_id, name
        feature.properties = texts
