"""What a shape most likely is: first what the file says, then what its names say, then its geometry."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any

KINDS_OF = {  # docs/protocols/map.md, Features; likeliest first
    "Polygon": (
        "parcel",
        "no-go",
        "obstacle",
        "building",
        "road",
        "water",
        "hedge",
        "tree",
        "slow",
        "farm",
        "treatment",
    ),
    "LineString": ("road", "rows", "hedge", "water", "tree"),
    "MultiLineString": ("rows",),
    "Point": ("obstacle", "tree", "home", "gate"),
}
ALL_KINDS = frozenset(kind for kinds in KINDS_OF.values() for kind in kinds)

# attributes that say what a shape is, in files of others; OpenStreetMap's keys among them
TELLING = ("kind", "type", "typ", "class", "category", "feature", "feature_type", "featuretype", "layer", "fclass",
           "amenity", "barrier", "building", "highway", "landuse", "natural", "waterway")  # fmt: skip

_WORDS = {
    "rows": "rows row ab abline ablinie abline guidance guideline swath swaths rij rijen reihe reihen spur crop_row "
    "a-b a_b ab_line",
    "no-go": "nogo no-go no_go keepout keep-out exclusion exclude forbidden verboten sperrzone sperrflaeche buffer "
    "geofence prohibited",
    "treatment": "treatment treatment_area treatment_zone behandlung behandlungszone spritzzone",
    "slow": "slow slowzone speed_zone langsam",
    "obstacle": "obstacle obstacles hindernis hindernisse obstakel obstaculo pylon pole mast stone rock boulder well "
    "manhole hydrant tower",
    "building": "building buildings barn shed greenhouse gebaeude gebäude gebouw stall schuur edificio house silo",
    "gate": "gate gates entrance access fieldaccess zufahrt einfahrt tor hek dam entry",
    "home": "home homebase base dock charging charger charging_station garage ladestation station",
    "hedge": "hedge hedges hedgerow windbreak hecke haag heg fence seto",
    "tree": "tree trees wood forest baum bäume boom bomen arbol wald scrub orchard_tree tree_row",
    "water": "water pond ditch drain drainage river stream canal lake graben sloot wasser teich vijver rio basin "
    "reservoir waterway",
    "road": "road roads track tracks path way lane street weg wege pad camino residential service unclassified "
    "tertiary secondary primary yard tramline",
    "farm": "farm farmyard betrieb boerderij finca farm_boundary holding",
    "parcel": "parcel parcels field fields plot boundary boundaries perceel percelen parcela parcelas schlag schläge "
    "feld flurstück paddock farmland meadow arable cropland orchard vineyard partfield acker gewas",
}
_KIND_OF_WORD = {word: kind for kind, words in _WORDS.items() for word in words.split()}
_SPLIT = re.compile(r"[^\w-]+|_+|\d+")


def possible(geometry_type: str) -> tuple[str, ...]:
    """Return what a shape of a GeoJSON geometry type can be, likeliest first; empty for unknown types."""
    return KINDS_OF.get(geometry_type, ())


def guess(geometry_type: str, told: str | None, attributes: Mapping[str, Any], names: Iterable[str]) -> str:
    """Return the likeliest kind of those that the geometry allows.

    Args:
        told: what the format itself says, if it does.
        names: of layer and feature, the most telling first.
    """
    allowed = possible(geometry_type)
    if told in allowed:
        return str(told)
    return named(geometry_type, attributes, names) or allowed[0]


def named(geometry_type: str, attributes: Mapping[str, Any], names: Iterable[str]) -> str | None:
    """Return the kind that attributes and names tell, of those that the geometry allows; ``None`` if they do not."""
    allowed = possible(geometry_type)
    lowered = {key.lower(): value for key, value in attributes.items()}
    clues = [lowered[key] for key in TELLING if isinstance(lowered.get(key), str)]
    clues += [key for key in ("highway", "building", "waterway") if lowered.get(key)]
    for clue in [*clues, *names]:
        kind = _named(str(clue), allowed)
        if kind is not None:
            return kind
    return None


def kind_named(text: str) -> str | None:
    """Return the kind that a word of a file means, as ``no_go`` means ``no-go``."""
    word = text.strip().lower()
    return word if word in ALL_KINDS else _KIND_OF_WORD.get(word)


def _named(clue: str, allowed: tuple[str, ...]) -> str | None:
    for word in (clue.strip(), *_SPLIT.split(clue)):
        kind = kind_named(word)
        if kind in allowed:
            return kind
    return None
