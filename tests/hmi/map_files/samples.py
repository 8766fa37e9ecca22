"""Files as other programs write them, and as attackers and bad disks do."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import shapefile
from pyproj import CRS

FILES = Path(__file__).parent / "files"
SQUARE = [[[5.66, 51.98], [5.67, 51.98], [5.67, 51.99], [5.66, 51.99], [5.66, 51.98]]]
UTM_SQUARE = [[[500000, 5800000], [500000, 5800200], [500300, 5800200], [500300, 5800000], [500000, 5800000]]]


def file(name: str) -> bytes:
    """Return a fixture file."""
    return (FILES / name).read_bytes()


def packed(files: Mapping[str, bytes]) -> bytes:
    """Return a zip."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return stream.getvalue()


def layer(
    name: str,
    shapes: list[Any],
    records: list[dict[str, Any]],
    epsg: int | None = None,
    encoding: str = "utf-8",
    size: int = 60,
) -> dict[str, bytes]:
    """Return the files of a layer of polygons; rings run clockwise, as shapefiles want. None is a null shape."""
    streams = {suffix: io.BytesIO() for suffix in ("shp", "shx", "dbf")}
    writer = shapefile.Writer(**streams, shapeType=shapefile.POLYGON, encoding=encoding)
    for key in records[0]:
        writer.field(key, "C", size=size)
    for rings, record in zip(shapes, records, strict=True):
        if rings is None:
            writer.null()
        else:
            writer.poly(rings)
        writer.record(*record.values())
    writer.close()
    files = {f"{name}.{suffix}": stream.getvalue() for suffix, stream in streams.items()}
    if epsg is not None:
        files[f"{name}.prj"] = CRS.from_epsg(epsg).to_wkt("WKT1_ESRI").encode()
    return files


def task_data() -> bytes:
    """Return zipped task data with one external file of two that it names."""
    return packed({f"TASKDATA/{name}": file(name) for name in ("TASKDATA.XML", "PFD00001.XML")})


def good() -> dict[str, bytes]:
    """Return one good file of each format by its name."""
    utm = layer("felder", [UTM_SQUARE], [{"name": "A"}], 25832)
    return {
        "fields.geojson": file("fields-2008.geojson"),
        "fields.ndjson": file("fields.ndjson"),
        "farm.kml": file("farm.kml"),
        "farm.kmz": packed({"doc.kml": file("farm.kml"), "a.png": b"x"}),
        "walk.gpx": file("walk.gpx"),
        "task.zip": task_data(),
        "TASKDATA.XML": file("TASKDATA.XML"),
        "felder.zip": packed(utm),
    }
