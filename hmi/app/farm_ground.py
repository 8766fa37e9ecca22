"""The farm's edge and its keep-out zones in memory, for the fence: read at the start and after each published map."""

from __future__ import annotations

import asyncio
import logging

from hmi.ingest.supervision.fence import Ground, Rings
from hmi.store.database import Database
from hmi.store.errors import StoreError
from hmi.store.features import Feature, Features

log = logging.getLogger(__name__)


class FarmGround:
    """Answers at once with what was read last; ``now`` is ``None`` for a map without an edge and zones."""

    def __init__(self, features: Features, database: Database, farm_id: str) -> None:
        self._features, self._database, self._farm_id = features, database, farm_id
        self._reading: asyncio.Task[None] | None = None
        self.now: Ground | None = None

    async def load(self) -> None:
        """Read it."""
        try:
            found = await self._database.run(self._features.all, self._farm_id, ("farm", "no-go"))
        except StoreError as error:
            log.warning("the farm's edge could not be read: %s", error)
            return
        farms = [rings for one in found if one.kind == "farm" for rings in _polygons(one)]
        zones = [(_called(one), rings) for one in found if one.kind == "no-go" for rings in _polygons(one)]
        self.now = await asyncio.to_thread(Ground.of, farms, zones)

    def map_published(self) -> None:
        """Read it again, beside."""
        self._reading = asyncio.get_running_loop().create_task(self.load(), name="farm ground")

    async def close(self) -> None:
        """End what is being read."""
        if self._reading is not None:
            self._reading.cancel()
            await asyncio.gather(self._reading, return_exceptions=True)


def _called(zone: Feature) -> str:
    return f"keep-out zone {zone.name}" if zone.name else "a keep-out zone"


def _polygons(feature: Feature) -> list[Rings]:
    geometry = feature.geometry
    polygons = [geometry["coordinates"]] if geometry["type"] == "Polygon" else geometry["coordinates"]
    return [[[(float(p[0]), float(p[1])) for p in ring] for ring in rings] for rings in polygons]
