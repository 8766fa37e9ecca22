"""The map of the demo farm: two real sites, with roads, yards and obstacles placed around them for the demo."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).parent / "fields"
POLDER, SITE = "polder", "experimental-site"
WEATHER_MAST = (51.785767, 4.260901)  # latitude and longitude of the obstacle of that name
SEEDED = {"Triticum aestivum L.": "2025-11-12", "Zea mays": "2026-04-20"}
CROPS = {"Triticum aestivum L.": "Wheat", "Zea mays": "Maize"}


@dataclass(frozen=True, slots=True)
class DemoFeature:
    """One map feature; geometry as in GeoJSON, degrees."""

    id: str
    kind: str
    name: str
    properties: dict[str, Any]
    geometry: dict[str, Any]


@cache
def features() -> tuple[DemoFeature, ...]:
    """Return every feature of the demo farm; parcels last, so that a list of fields begins with the large one."""
    polder = (one for name in ("surroundings", "polder-farm", "kromme-akker") for one in _placed(f"{name}.geojson"))
    return (*polder, _parcel(), *_sections())


def feature(feature_id: str) -> DemoFeature:
    """Return one feature.

    Raises:
        KeyError: there is none of this id.
    """
    return {one.id: one for one in features()}[feature_id]


def _placed(name: str) -> tuple[DemoFeature, ...]:
    return tuple(
        DemoFeature(p["id"], p["kind"], p["name"], {k: v for k, v in p.items() if k not in ("id", "kind", "name")}, g)
        for p, g in _read(name)
    )


def _parcel() -> DemoFeature:
    [(properties, geometry)] = _read("nl-parcel.geojson")
    source = properties["source"]
    kept = {"site": POLDER, "crop": "Sugar beet", "soil_type": "Clay", "seeded": "2026-04-08", "source": source}
    return DemoFeature("polder-17", "parcel", "Polder 17", kept, geometry)


def _sections() -> tuple[DemoFeature, ...]:
    found = []
    for properties, geometry in _read("es-experimental-site.geojson"):
        if properties["kind"] != "parcel":
            continue  # its home is in the surroundings, with a heading
        kept = {
            "site": SITE,
            "crop": CROPS[properties["crop"]],
            "species": properties["crop"],
            "soil_type": "Loam",
            "seeded": SEEDED[properties["crop"]],
            "row_spacing_m": properties["row_spacing_m"],
            "row_bearing_deg": properties["row_bearing_deg"],
        }
        name = properties["name"].capitalize()
        found.append(DemoFeature(f"site-{name.lower().replace(' ', '-')}", "parcel", name, kept, geometry))
    return tuple(found)


def _read(name: str) -> list[tuple[dict[str, Any], dict[str, Any]]]:
    collection = json.loads((FOLDER / name).read_text("utf-8"))
    return [(one["properties"], one["geometry"]) for one in collection["features"]]
