"""Coordinate systems of map files, and the way from them to WGS84.

Axes are always x (east) before y (north), whatever the authority says: files keep to that order, also for
`urn:ogc:def:crs:EPSG::4326` (GeoJSON 2008, section 3).
Nothing is fetched: grids that are not installed are done without.
"""

from __future__ import annotations

import math
import re
from functools import lru_cache
from typing import Any

from pyproj import CRS, Transformer
from pyproj.exceptions import ProjError
from pyproj.network import set_network_enabled  # type: ignore[attr-defined]

set_network_enabled(False)

WKT_CHARS = 20_000
UNKNOWN_ERROR_M = 200  # what national datums are off WGS84, in most of Europe
NOTABLE_ERROR_M = 1.0  # ETRS89 against WGS84 counts as 1 m, and everybody lives with that
_BALLPARK = "Ballpark"  # in the name of an operation of PROJ: datums are taken for the same, which are not
_WITHIN_DECIMETRES = frozenset({"China 2000"})  # datums of PROJ's names: no operation is known, none is needed
_EPSG = re.compile(r"^(?:urn:(?:x-)?ogc:def:crs:)?EPSG:(?:[0-9.]*:)?([0-9]{4,6})$", re.IGNORECASE)
_LON_LAT = re.compile(r"(CRS84h?$|^WGS ?84$)", re.IGNORECASE)


class UnknownSystem(Exception):
    """The description of a coordinate system is not understood; the message is a sentence."""


class CoordinateSystem:
    """A coordinate system of a file.

    Attributes:
        label: for the operator.
    """

    def __init__(self, crs: CRS | None, label: str) -> None:
        self.label = label
        self._crs = crs
        self._transformer: Transformer | None = None  # takes longer to make than to use

    def to_wgs84(self, xs: list[float], ys: list[float]) -> tuple[list[float], list[float], float]:
        """Return longitudes and latitudes in degrees (infinite where there are none) and the likely error in metres.

        The error is infinite where PROJ knows no way from the system's datum to WGS84 and takes the one for the other.
        """
        if self._crs is None or not xs:
            return xs, ys, 0.0
        try:
            if self._transformer is None:
                self._transformer = Transformer.from_crs(self._crs, "EPSG:4326", always_xy=True)
            lons, lats = self._transformer.transform(xs, ys)
        except ProjError as error:
            raise UnknownSystem(f"Positions in {self.label} cannot be converted.") from error
        return list(lons), list(lats), _error_m(self._transformer, _datum_of(self._crs))

    @property
    def is_wgs84(self) -> bool:
        """Say whether positions stand as they are."""
        return self._crs is None


WGS84 = CoordinateSystem(None, "WGS84")


@lru_cache(maxsize=16)  # finding the code of a description takes half a second
def from_wkt(text: str) -> CoordinateSystem:
    """Return the system that a .prj file describes (WKT 1 as Esri writes it, or WKT 2, ISO 19162).

    Raises:
        UnknownSystem: it is not understood.
    """
    if not text.strip() or len(text) > WKT_CHARS:
        raise UnknownSystem("The .prj file is empty or too long.")
    try:
        crs = CRS.from_wkt(text)
    except (ProjError, ValueError) as error:
        raise UnknownSystem("The coordinate system in the .prj file is not understood.") from error
    return _of(crs)


@lru_cache(maxsize=16)
def from_name(name: str) -> CoordinateSystem:
    """Return the system of a name such as ``EPSG:25832`` or ``urn:ogc:def:crs:OGC:1.3:CRS84``.

    Raises:
        UnknownSystem: the name is not known.
    """
    if _LON_LAT.search(name.strip()):
        return WGS84
    match = _EPSG.match(name.strip())
    if match is None:
        raise UnknownSystem(f"The coordinate system {name[:60]!r} is not known.")
    try:
        return _of(CRS.from_epsg(int(match.group(1))))
    except (ProjError, ValueError) as error:
        raise UnknownSystem(f"The coordinate system {name[:60]!r} is not known.") from error


def from_member(crs: Any) -> CoordinateSystem | None:
    """Return the system of a ``crs`` member (GeoJSON 2008, section 3), or None where it says that nobody knows.

    Raises:
        UnknownSystem: it is a link, or not known.
    """
    if crs is None:
        return None
    properties = crs.get("properties") if isinstance(crs, dict) else None
    name = properties.get("name") if isinstance(properties, dict) else None
    if isinstance(crs, dict) and str(crs.get("type")).lower() == "link":
        raise UnknownSystem("The file links to its coordinate system elsewhere, and nothing is fetched.")
    if isinstance(name, str):
        return from_name(name)
    raise UnknownSystem("The crs member of the file is not understood.")


def _of(crs: CRS) -> CoordinateSystem:
    if not (crs.is_geographic or crs.is_projected) or crs.is_geocentric:
        raise UnknownSystem(f"{crs.name} is not a coordinate system of maps.")
    code = crs.to_epsg(min_confidence=70)
    if code == 4326:
        return WGS84
    return CoordinateSystem(crs, f"{crs.name} (EPSG:{code})" if code else crs.name)


def _datum_of(crs: CRS) -> str:
    geodetic = crs.geodetic_crs
    return geodetic.datum.name if geodetic is not None and geodetic.datum is not None else ""


def _error_m(transformer: Transformer, datum: str) -> float:
    try:
        used = transformer.get_last_used_operation()
    except ProjError:
        used = transformer
    if _BALLPARK in used.description:
        return NOTABLE_ERROR_M if datum in _WITHIN_DECIMETRES else math.inf
    return max(0.0, float(used.accuracy))  # -1 for parameters that the file itself brings
