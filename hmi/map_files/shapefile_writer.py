"""The farm map as zipped shapefiles, one layer a geometry type (Esri "Shapefile Technical Description", 1998).

A column of a .dbf has 10 letters and 254 bytes. So beside each layer lies ``LAYER.fields.json``:
``{"attributes": {NAME: [COLUMN, ...]}}``. NAME is the attribute of the farm map; a text too long for one column goes
on in the next one. Values are written as ``attribute_text`` says. Programs that do not know the file see the columns.
"""

from __future__ import annotations

import io
import json
import re
from collections.abc import Sequence
from typing import Any

import shapefile

from hmi.map_files.attribute_text import encode
from hmi.map_files.errors import BadMapFile
from hmi.map_files.exported import MapFile, json_bytes, packed, stem
from hmi.map_files.shapefile_reader import FIELDS_SUFFIX
from hmi.mapping.coordinates import paths
from hmi.mapping.feature import MapFeature

COLUMN_CHARS = 10
COLUMN_BYTES = 254
_CUT_BYTES = 200  # of each piece of a text that is cut
COLUMNS = 250  # a .dbf has room for 255
_TYPES = {
    "polygons": (shapefile.POLYGON, ("Polygon",)),
    "lines": (shapefile.POLYLINE, ("LineString", "MultiLineString")),
    "points": (shapefile.POINT, ("Point",)),
}
_WGS84 = (
    'GEOGCS["GCS_WGS_1984",DATUM["D_WGS_1984",SPHEROID["WGS_1984",6378137.0,298.257223563]],'
    'PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]]'
)


def write(features: Sequence[MapFeature], farm_id: str, _farm_name: str) -> MapFile:
    """Return a zip; layers without features are left out, and so are attributes beyond 250 columns.

    Raises:
        BadMapFile: there is nothing to write.
    """
    if not features:
        raise BadMapFile("nothing_in_it", "The map is empty. Draw or import something first.")
    files: dict[str, bytes] = {}
    cut: list[str] = []
    for layer, (shape_type, geometries) in _TYPES.items():
        of_layer = [feature for feature in features if feature.geometry["type"] in geometries]
        if of_layer:
            columns = _columns([_pieces(feature) for feature in of_layer])
            files |= _layer(f"{stem(farm_id)}-{layer}", shape_type, of_layer, columns)
            told = dict.fromkeys(key for feature in of_layer for key in feature.properties)
            cut += [f"{key} of {layer}: there is no column left for it" for key in told if key not in columns]
    return MapFile(packed(files), "application/zip", f"{stem(farm_id)}-shapefile.zip", cut=tuple(cut))


def _layer(name: str, shape_type: int, features: list[MapFeature], columns: dict[str, list[str]]) -> dict[str, bytes]:
    rows = [_pieces(feature) for feature in features]
    streams = {suffix: io.BytesIO() for suffix in (".shp", ".shx", ".dbf")}
    writer = shapefile.Writer(
        shp=streams[".shp"], shx=streams[".shx"], dbf=streams[".dbf"], shapeType=shape_type, encoding="utf-8"
    )
    for key, names in columns.items():
        for i, column in enumerate(names):
            size = max(len(row[key][i].encode()) for row in rows if len(row.get(key, ())) > i)
            writer.field(column, "C", size=size)
    for feature, row in zip(features, rows, strict=True):
        _shape(writer, feature)
        writer.record(*[_cell(row.get(key, ()), i) for key, names in columns.items() for i in range(len(names))])
    writer.close()
    files = {f"{name}{suffix}": _dated(stream.getvalue(), suffix) for suffix, stream in streams.items()}
    texts = {".prj": _WGS84.encode(), ".cpg": b"UTF-8", FIELDS_SUFFIX: json_bytes({"attributes": columns})}
    return files | {f"{name}{suffix}": data for suffix, data in texts.items()}


def _shape(writer: Any, feature: MapFeature) -> None:
    lines = paths(feature.geometry)
    if feature.geometry["type"] == "Point":
        writer.point(*lines[0][0])
    elif feature.geometry["type"] == "Polygon":
        writer.poly([ring[::-1] for ring in lines])  # outer rings of a shapefile run clockwise
    else:
        writer.line(lines)


def _pieces(feature: MapFeature) -> dict[str, list[str]]:
    values = {"id": feature.id, "kind": feature.kind, "name": feature.name, **dict(sorted(feature.properties.items()))}
    return {key: _cut(value) for key, value in values.items()}


def _cut(value: Any) -> list[str]:
    """Return the text of a value in pieces that fit into a column and neither begin nor end with a blank."""
    text = encode(value)
    if len(text.encode()) <= COLUMN_BYTES:
        return [text]
    text = json.dumps(value, sort_keys=True, allow_nan=False, separators=(",", ":")).replace(" ", "\\u0020")
    return [text[i : i + _CUT_BYTES] for i in range(0, len(text), _CUT_BYTES)]


def _cell(pieces: Sequence[str], i: int) -> str:
    return pieces[i] if i < len(pieces) else ""


def _columns(rows: list[dict[str, list[str]]]) -> dict[str, list[str]]:
    """Return a name of at most 10 letters for each piece of each attribute, unlike all others in any case."""
    taken: set[str] = set()
    columns: dict[str, list[str]] = {}
    for key in dict.fromkeys(key for row in rows for key in row):
        n = max(len(row.get(key, ())) for row in rows)
        if len(taken) + n <= COLUMNS:
            columns[key] = [_column(key, taken) for _ in range(n)]
    return columns


def _column(key: str, taken: set[str]) -> str:
    base = re.sub(r"[^A-Za-z0-9_]", "_", key) or "attribute"
    if not base[0].isalpha():
        base = f"a{base}"
    n = 1
    name = base[:COLUMN_CHARS]
    while name.lower() in taken:
        n += 1
        name = f"{base[: COLUMN_CHARS - len(str(n)) - 1]}_{n}"
    taken.add(name.lower())
    return name


def _dated(data: bytes, suffix: str) -> bytes:
    """Set the day of the last change in a .dbf to a fixed one: the same map is the same file."""
    return data[:1] + bytes((95, 7, 26)) + data[4:] if suffix == ".dbf" else data
