"""Random features of the farm map, as its own reader lets them in."""

from __future__ import annotations

import math
from datetime import date
from typing import Any

from hypothesis import strategies as st

from hmi.mapping.feature import MapFeature, parse_feature

ids = st.from_regex(r"[a-z0-9][a-z0-9_-]{0,20}", fullmatch=True)
printable = st.characters(exclude_categories=["Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp", "Zs"], include_characters=" ")
names = st.text(printable, max_size=40)
texts = st.one_of(
    st.text(st.characters(exclude_categories=["Cs"]), max_size=60),
    st.sampled_from(["12", "true", "null", '"', "[1]", " a ", "", "\t\n", "\x00", "\x7f\x85", "é" * 200, " " * 300]),
)
scalars = st.one_of(
    texts,
    st.integers(-(10**9), 10**9),
    st.booleans(),
    st.none(),
    st.floats(-1e9, 1e9, allow_nan=False),
)
values = st.one_of(
    scalars, st.lists(st.integers(0, 9), max_size=4), st.dictionaries(st.sampled_from("ab"), st.booleans())
)
keys = st.one_of(
    st.from_regex(r"[a-zA-Z_][a-zA-Z0-9_ .:äß-]{0,28}[a-z0-9]", fullmatch=True),
    st.sampled_from(["soil_moisture_north", "soil_moisture_south", "note", "desc", "description", "x:y", "3d"]),
).filter(lambda key: key not in {"id", "kind", "name"} and key not in OWN)

OWN = {"crop", "species", "soil_type", "status", "seeded", "row_spacing_m", "row_bearing_deg", "headland_m", "category",
       "type", "radius_m", "width_m", "height_m", "speed_mps", "heading_deg", "robot", "parcel_id"}  # fmt: skip
days = st.dates(date(1900, 1, 1), date(2199, 12, 31)).map(str)
widths = st.floats(0.5, 20).map(lambda w: round(w, 3))
heights = st.floats(0.01, 300).map(lambda h: round(h, 2))
words = st.text(printable, max_size=60)
OPTIONAL = {
    "parcel": {"crop": words, "species": words, "soil_type": words, "status": words, "seeded": days,
               "row_spacing_m": widths.map(lambda w: w / 2), "row_bearing_deg": st.integers(0, 360)},
    "road": {"width_m": widths},
    "building": {"category": st.sampled_from(["barn", "greenhouse", "Scheune"]), "height_m": heights},
    "obstacle": {"height_m": heights},
    "home": {"heading_deg": st.integers(-180, 180), "type": st.sampled_from(["home", "garage", "charging"]),
             "robot": ids},
    "gate": {"width_m": widths},
    "slow": {"speed_mps": st.floats(0.1, 5)},
    "treatment": {"dose": st.floats(0, 2)},
    "rows": {"type": st.sampled_from(["a-b", "curve", "recorded"]), "parcel_id": ids},
    "tree": {"width_m": widths, "radius_m": widths, "height_m": heights},
    "hedge": {"width_m": widths, "height_m": heights},
    "water": {"width_m": widths},
}  # fmt: skip
SHAPES = {
    "farm": ["Polygon"], "parcel": ["Polygon"], "obstacle": ["Polygon", "Point"], "road": ["LineString", "Polygon"],
    "building": ["Polygon"], "home": ["Point"], "gate": ["Point"], "no-go": ["Polygon"], "slow": ["Polygon"],
    "treatment": ["Polygon"],
    "rows": ["LineString", "MultiLineString"], "tree": ["Polygon", "LineString", "Point"],
    "hedge": ["Polygon", "LineString"], "water": ["Polygon", "LineString"],
}  # fmt: skip


@st.composite
def rings(draw: st.DrawFn, radius_deg: float, centre: tuple[float, float]) -> list[list[float]]:
    """Return a counter-clockwise ring about a place."""
    n = draw(st.integers(3, 8))
    turn = draw(st.floats(0, 6))
    radii = draw(st.lists(st.floats(0.6, 1.0), min_size=n, max_size=n))
    ring = [
        [centre[0] + radius_deg * r * math.cos(turn + 2 * math.pi * i / n),
         centre[1] + radius_deg * r * math.sin(turn + 2 * math.pi * i / n)]
        for i, r in enumerate(radii)
    ]  # fmt: skip
    return [*ring, list(ring[0])]


@st.composite
def geometries(draw: st.DrawFn, kind: str) -> dict[str, Any]:
    """Return a geometry with proper winding."""
    lon, lat = draw(st.floats(-170, 170)), draw(st.floats(-80, 80))
    if kind == "Point":
        return {"type": kind, "coordinates": [lon, lat]}
    if kind == "Polygon":
        outer = draw(rings(0.01, (lon, lat)))
        holes = [draw(rings(0.0005, (lon, lat)))[::-1]] if draw(st.booleans()) else []
        return {"type": kind, "coordinates": [outer, *holes]}
    lines = [
        [[lon + 0.0001 * (i + 1), lat + 0.001 * j + draw(st.floats(0, 0.0005))] for j in range(draw(st.integers(2, 6)))]
        for i in range(1 if kind == "LineString" else draw(st.integers(2, 3)))
    ]
    return {"type": kind, "coordinates": lines[0] if kind == "LineString" else lines}


@st.composite
def features(draw: st.DrawFn, *, is_plain: bool = False) -> MapFeature:
    """Return one feature; a plain one has no attributes of its own making."""
    kind = draw(st.sampled_from(sorted(SHAPES)))
    shape = draw(st.sampled_from(SHAPES[kind]))
    own = draw(st.fixed_dictionaries({}, optional=OPTIONAL.get(kind, {})))
    if kind == "obstacle" and shape == "Point":
        own["radius_m"] = draw(widths)
    extra = {} if is_plain else draw(st.dictionaries(keys, values, max_size=4))
    head = {"id": draw(ids), "kind": kind, "name": draw(names)}
    return parse_feature(
        {
            "type": "Feature",
            "id": head["id"],
            "properties": {**extra, **own, **head},
            "geometry": draw(geometries(shape)),
        }
    )


maps = st.lists(features(), min_size=1, max_size=5, unique_by=lambda feature: feature.id)
