"""The map of the demo farm as the simulator's cameras show it."""

from __future__ import annotations

from backend_clients.simulator.cameras.map_feature import MapFeature
from hmi.demo.farm import features


def map_features() -> tuple[MapFeature, ...]:
    """Return every feature of the farm."""
    return tuple(MapFeature(one.kind, one.name, one.properties, one.geometry) for one in features())
