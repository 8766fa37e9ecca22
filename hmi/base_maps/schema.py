"""Which vector base maps can be drawn: those whose layers have the names of a common schema."""

from __future__ import annotations

from typing import Any

from hmi.base_maps.errors import BadBaseMap

SCHEMAS = {
    "protomaps": frozenset({"earth", "water", "landuse", "roads", "buildings"}),
    "openmaptiles": frozenset({"water", "landcover", "landuse", "transportation", "building"}),
}
"""Layers by which a schema is known; the drawing of both is in ``static/js/map/base_vector.js``."""

LEAST_SHARED = 3  # a clip of the country may lack buildings or water
SHOWN_NAMES = 6


def schema_of(metadata: dict[str, Any]) -> str:
    """Return the schema of vector tiles; raises ``BadBaseMap`` for one that nobody here can draw."""
    layers = metadata.get("vector_layers")
    known_layers = layers if isinstance(layers, list) else []
    found = {str(one["id"]) for one in known_layers if isinstance(one, dict) and "id" in one}
    shared = {name: len(known & found) for name, known in SCHEMAS.items()}
    best = max(shared, key=lambda name: shared[name])
    if shared[best] >= LEAST_SHARED:
        return best
    names = ", ".join(sorted(found)[:SHOWN_NAMES]) or "none"
    text = (
        f"Headland cannot draw these vector layers: {names}. It draws base maps with the layers of Protomaps or "
        "OpenMapTiles. Take one of those, or a picture (raster) of this map."
    )
    raise BadBaseMap("schema", text[:400])
