"""Which map a mission was planned on, and what changed around it since."""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import msgspec

from hmi.commands.plan_wish import is_flying, surroundings_of
from hmi.commands.refusal import IN_FLIGHT_PATH, MAP_CHANGED, OrderRefused
from hmi.domain.map_log import MapFeatures
from hmi.domain.mission_rest import Progress
from hmi.domain.robot import Factsheet, Robot
from hmi.mapping.errors import BadFeature
from hmi.mapping.feature import MapFeature, parse_feature
from hmi.mapping.jobs import compare
from hmi.store.database import Database
from hmi.store.errors import NotFound
from hmi.store.features import Feature
from hmi.store.maps import Maps
from hmi.store.missions import Mission

if TYPE_CHECKING:
    from hmi.mapping.diff import Difference

TOLD = 3  # changes named in the sentence; the map builder shows all


@dataclass(frozen=True, slots=True)
class MapStamp:
    """Number and hash of a published map; number 0 is a farm that has none."""

    number: int
    sha256: str

    def as_json(self) -> dict[str, Any]:
        """Return ``map_version`` of the edge contract."""
        return {"number": self.number, "sha256": self.sha256}


class MapWatch:
    """Compares the published map with the one a mission was planned on."""

    def __init__(self, maps: Maps, database: Database) -> None:
        self._maps, self._run = maps, database.run
        self._stamps: dict[tuple[str, int], MapStamp] = {}

    async def now(self, farm_id: str) -> MapStamp:
        """Return the published map."""
        version = await self._run(self._maps.published, farm_id)
        key = (farm_id, version.number)
        if key not in self._stamps:
            features = await self._run(self._maps.features_of, farm_id, version.number)
            self._stamps[key] = MapStamp(version.number, await asyncio.to_thread(_digest, features))
        return self._stamps[key]

    async def features_of(self, farm_id: str, number: int | None) -> list[Feature] | None:
        """Return the map as it was in a version, ``None`` if that is not known any more."""
        if number is None:
            return None
        try:
            known = await self._run(self._maps.features_of, farm_id, number)
        except NotFound:
            return None
        return await asyncio.to_thread(lambda: [_feature(farm_id, raw) for raw in known.values()])

    async def check(self, farm_id: str, planned_on: int | None, document: Mapping[str, Any]) -> str:
        """Return a note about a newer map that changes nothing around this mission, empty if there is none.

        Raises:
            OrderRefused: it changed where this mission drives.
        """
        if planned_on is None:
            return ""
        now = await self.now(farm_id)
        if now.number == planned_on:
            return ""
        changed = await self.changes(farm_id, planned_on, now.number, document)
        if not changed:
            return f"The map is v{now.number} now; nothing changed around this field since v{planned_on}."
        told = "; ".join(f"{one.name or one.kind}: {one.text}" for one in changed[:TOLD])
        more = f" and {len(changed) - TOLD} more" if len(changed) > TOLD else ""
        text = f"map is v{now.number} now, plan uses v{planned_on}. Plan again. {told}{more}."
        raise OrderRefused(MAP_CHANGED, text)

    async def check_flight(
        self, farm_id: str, document: Mapping[str, Any], sheet: Factsheet | None, flown: int | None = None
    ) -> None:
        """Return if nothing on the map as it is now stands in the path of what flies; at once for what does not.

        Asked of each path, not of what changed since it was planned: the robot may fly lower now, and plans of before
        knew no heights.

        Args:
            flown: segments that are behind the robot, see ``flown_of``.

        Raises:
            OrderRefused: something does, or may.
        """
        if not is_flying(sheet):
            return
        features = await self.features_of(farm_id, (await self.now(farm_id)).number)
        text = await asyncio.to_thread(_met_in_flight, document, features or [], sheet, flown)
        if text:
            raise OrderRefused(IN_FLIGHT_PATH, text)

    async def changes(self, farm_id: str, old: int, new: int, document: Mapping[str, Any]) -> list[Difference]:
        """Return what changed from one version to another near a mission's field and its ways."""
        try:
            before = await self._run(self._maps.features_of, farm_id, old)
        except NotFound:
            return []
        after = await self._run(self._maps.features_of, farm_id, new)
        return await asyncio.to_thread(_near, before, after, document)


def flown_of(mission: Mission, robot: Robot | None) -> int | None:
    """Return how many segments of a mission are behind its robot, ``None`` if nobody knows.

    What the robot says now goes before what it said last; the segments that a rest kept have the same numbers in both.
    """
    order = None if robot is None or robot.state is None else robot.state.order
    if order is not None and order.mission_id == mission.id and order.sha256 == mission.sha256:
        return order.segment
    progress = Progress.from_json(mission.progress)
    return None if progress is None else progress.segment


def _near(before: MapFeatures, after: MapFeatures, document: Mapping[str, Any]) -> list[Difference]:
    from hmi.mapping.near_path import NearPath  # geometry: only a newer map needs it

    near = NearPath(document)
    return compare(near.of(_parsed(before)), near.of(_parsed(after)))


def _met_in_flight(
    document: Mapping[str, Any], features: list[Feature], sheet: Factsheet | None, flown: int | None
) -> str:
    from hmi.mapping.flight_path import met_in_flight

    parcel = {"type": "Polygon", "coordinates": document["parcel"]}
    return met_in_flight(document, surroundings_of(features, parcel, None, sheet), flown)


def _parsed(features: MapFeatures) -> Iterator[MapFeature]:
    for raw in features.values():
        with contextlib.suppress(BadFeature):
            yield parse_feature(raw)


def _feature(farm_id: str, raw: Mapping[str, Any]) -> Feature:
    own = raw["properties"]
    return Feature(raw["id"], farm_id, own["kind"], own.get("name", ""), raw["geometry"], dict(own))


def _digest(features: MapFeatures) -> str:
    return hashlib.sha256(msgspec.json.encode(features, order="sorted")).hexdigest()
