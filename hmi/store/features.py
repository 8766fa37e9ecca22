"""The published map of a farm: parcels, roads, buildings, homes, obstacles."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

from sqlalchemy import select

from hmi.clock import Clock
from hmi.store.database import Database
from hmi.store.errors import NotFound
from hmi.store.tables import FeatureRow


@dataclass(frozen=True, slots=True)
class Feature:
    """One map feature; ``geometry`` is GeoJSON, longitude and latitude in degrees."""

    id: str
    farm_id: str
    kind: str
    name: str
    geometry: dict[str, Any]
    properties: dict[str, Any] = field(default_factory=dict)
    map_version: int = 1

    @property
    def title(self) -> str:
        """Return the name, or what to call a feature that nobody named."""
        return self.name or f"Unnamed {self.kind}"


class Features:
    """The map features of every farm. Blocking; call through ``Database.run``."""

    def __init__(self, database: Database, clock: Clock) -> None:
        self._database = database
        self._clock = clock

    def all(self, farm_id: str, kinds: Sequence[str] = ()) -> list[Feature]:
        """Return a farm's features by kind and name, all kinds if none is named."""
        query = select(FeatureRow).filter_by(farm_id=farm_id).order_by(FeatureRow.kind, FeatureRow.name, FeatureRow.id)
        query = query.where(FeatureRow.kind.in_(kinds)) if kinds else query
        with self._database.read() as session:
            return [_feature(row) for row in session.scalars(query)]

    def get(self, farm_id: str, feature_id: str) -> Feature:
        """Return one feature.

        Raises:
            NotFound: there is none of this id in this farm.
        """
        with self._database.read() as session:
            row = session.get(FeatureRow, (farm_id, feature_id))
            if row is None:
                raise NotFound(f"there is no map feature {feature_id!r}")
            return _feature(row)

    def put(self, features: Iterable[Feature]) -> None:
        """Store features, replacing those of the same farm and id, in one transaction."""
        with self._database.write() as session:
            for one in features:
                row = session.get(FeatureRow, (one.farm_id, one.id))
                if row is None:
                    row = FeatureRow(id=one.id, farm_id=one.farm_id, created_at=self._clock.utc())
                    session.add(row)
                row.kind, row.name, row.geometry = one.kind, one.name, one.geometry
                row.properties, row.map_version = one.properties, one.map_version


def feature_collection(features: Iterable[Feature]) -> dict[str, Any]:
    """Return features as GeoJSON; kind, name and id stand among the properties."""
    return {
        "type": "FeatureCollection",
        "features": [
            {
                "type": "Feature",
                "id": one.id,
                "properties": {**one.properties, "id": one.id, "kind": one.kind, "name": one.name},
                "geometry": one.geometry,
            }
            for one in features
        ],
    }


def _feature(row: FeatureRow) -> Feature:
    return Feature(
        row.id, row.farm_id, row.kind, row.name, dict(row.geometry), dict(row.properties or {}), row.map_version
    )
