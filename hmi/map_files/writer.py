"""Writing the farm map for other programs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType

from hmi.map_files import (
    fiware_writer,
    geojson_writer,
    gpx_writer,
    isoxml_writer,
    kml_writer,
    shapefile_writer,
)
from hmi.map_files.errors import BadMapFile
from hmi.map_files.exported import MapFile
from hmi.mapping.feature import MapFeature

Write = Callable[[Sequence[MapFeature], str, str], MapFile]

FORMATS: Mapping[str, Write] = MappingProxyType(
    {
        "geojson": geojson_writer.write,
        "kml": kml_writer.write,
        "kmz": kml_writer.write_kmz,
        "shapefile": shapefile_writer.write,
        "isoxml": isoxml_writer.write,
        "gpx": gpx_writer.write,
        "fiware": fiware_writer.write,
    }
)


def write_map(features: Sequence[MapFeature], format: str, farm_id: str, farm_name: str) -> MapFile:
    """Return the map as a file; the same map gives the same bytes.

    Args:
        format: a key of ``FORMATS``.

    Raises:
        BadMapFile: ``unknown_format``, or nothing to write where the format cannot be empty.
    """
    write = FORMATS.get(format)
    if write is None:
        raise BadMapFile("unknown_format", f"{format[:20]!r} is not known. Choose {', '.join(FORMATS)}.")
    return write(features, farm_id, farm_name)
