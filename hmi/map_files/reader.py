"""Reading a map file: what it is by its content, by its name only where the content leaves it open."""

from __future__ import annotations

import codecs
from xml.etree.ElementTree import Element

from hmi.map_files import (
    archive as archives,
)
from hmi.map_files import (
    geojson_reader,
    gpx_reader,
    isoxml_reader,
    kml_reader,
    limits,
    shapefile_reader,
)
from hmi.map_files.archive import Archive
from hmi.map_files.errors import BadMapFile
from hmi.map_files.harvest import harvest
from hmi.map_files.imported import Imported
from hmi.map_files.progress import Progress, Report
from hmi.map_files.source import Source
from hmi.map_files.xml_tree import local, parse

KNOWN = "GeoJSON, KML, KMZ, shapefile (zip), ISOXML or GPX"
_READ = 0.3  # share of the work until the shapes are known
_UTF16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
_OTHERS = {
    b"\x1f\x8b": "This is a gzip archive. Unpack it and import what is inside.",
    b"7z\xbc\xaf": "This is a 7z archive. Pack it as zip.",
    b"Rar!": "This is a RAR archive. Pack it as zip.",
    b"%PDF": f"This is a PDF. Export the map as {KNOWN}.",
    b"SQLite format 3": "This is a database, perhaps GeoPackage. Export the layer as GeoJSON.",
    shapefile_reader.MAGIC: "This is one file of a shapefile. Pack .shp, .shx, .dbf and .prj into one zip.",
}
_BY_SUFFIX = {".kmz": "kmz", ".kml": "kmz"}


def read_map(data: bytes, name: str, report: Report | None = None) -> Imported:
    """Return what a map file holds.

    Args:
        name: of the file; it decides where the content leaves open what it is.
        report: is told how far it is.

    Raises:
        BadMapFile: nothing of it can be taken; says why and what to do.
    """
    tell = report or (lambda progress: None)
    if len(data) > limits.FILE_BYTES:
        raise BadMapFile("too_large", f"The file is larger than {limits.FILE_BYTES // 1_000_000} MB. Split it.")
    tell(Progress(0.05))
    source = _read(data, name)
    imported = harvest(source, lambda shapes, of: tell(Progress(_READ + (1 - _READ) * shapes / max(of, 1), shapes)))
    tell(Progress(1.0, len(imported.items)))
    return imported


def _read(data: bytes, name: str) -> Source:
    if not data.strip(b"\x00 \t\r\n"):
        raise BadMapFile("empty", "The file is empty. Export or download it once more.")
    if data.startswith((archives.MAGIC, archives.EMPTY_MAGIC)):
        return _of_archive(Archive(data), name)
    for magic, text in _OTHERS.items():
        if data.startswith(magic):
            raise BadMapFile("not_a_map", text)
    start = data[:400].replace(b"\0", b"").lstrip(b"\xef\xbb\xbf\xff\xfe\x1e \t\r\n")
    if start.startswith(b"<"):
        return _of_xml(parse(data if data.startswith(_UTF16) else data.lstrip()), None, "")
    if start.startswith((b"{", b"[")):
        return geojson_reader.read(data)
    raise BadMapFile("not_a_map", f"This is not a map that is known here. Export it as {KNOWN}.")


def _of_archive(archive: Archive, name: str) -> Source:
    found = {
        "shapefile": bool(archive.ending(".shp")),
        "isoxml": isoxml_reader.task_data_path(archive) is not None,
        "kmz": bool(archive.ending(".kml")),
    }
    suffix = name[name.rfind(".") :].lower() if "." in name else ""
    wanted = _BY_SUFFIX.get(suffix, "")
    kind = wanted if found.get(wanted) else next((kind for kind, is_there in found.items() if is_there), None)
    if kind == "shapefile":
        return shapefile_reader.read(archive)
    if kind == "kmz":
        return kml_reader.read_kmz(archive)
    path = isoxml_reader.task_data_path(archive)
    if path is not None:
        return _of_xml(parse(archive.read(path)), archive, path)
    plain = archive.ending(".geojson", ".json", ".gpx", ".ndjson", ".geojsonl")
    if len(plain) == 1:
        return _read(archive.read(plain[0]), plain[0])
    what = "several maps" if plain else "no map that is known here"
    raise BadMapFile("not_a_map", f"The archive holds {what}. Import one file: {KNOWN}.")


def _of_xml(root: Element, archive: Archive | None, path: str) -> Source:
    kind = local(root)
    if kind == "kml":
        return kml_reader.read(root)
    if kind == "gpx":
        return gpx_reader.read(root)
    if kind in {isoxml_reader.ROOT, isoxml_reader.EXTERNAL_ROOT}:
        source = isoxml_reader.read(root, archive, path)
        if not source.layers and not source.skipped:
            raise BadMapFile("nothing_in_it", "The task data holds no fields (PFD). Export it with the fields in it.")
        return source
    text = f"This XML ({kind[:40]}) is not a map that is known here. Export it as {KNOWN}."
    raise BadMapFile("not_a_map", text)
