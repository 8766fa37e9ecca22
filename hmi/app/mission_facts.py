"""What the start checks need of stored missions, in memory: read once for each document and map version."""

from __future__ import annotations

import asyncio
import logging
from typing import Any, NamedTuple

from hmi.commands.map_watch import MapWatch, flown_of
from hmi.commands.ports import FleetReader
from hmi.commands.refusal import OrderRefused
from hmi.domain.mission_rest import kept_behind, kept_of
from hmi.domain.planned_machine import battery_share_on
from hmi.domain.robot import Factsheet
from hmi.presenters.start_checks import BATTERY_RESERVE, MissionFacts, Place
from hmi.store.database import Database
from hmi.store.errors import NotFound, StoreError
from hmi.store.features import Features
from hmi.store.missions import Mission, Missions

log = logging.getLogger(__name__)


_Key = tuple[str, int, Any]
"""Of a document, the round of maps, and how high its robot flies."""


class _Around(NamedTuple):
    """What does not stand in memory: of one document on one map."""

    key: _Key
    start: Place
    fences: tuple[tuple[Place, ...], ...]
    map_number: int | None
    map_text: str | None
    flight_text: str | None
    flown: int | None
    kept: int

    def is_from(self, flown: int | None) -> bool:
        """Say whether its path was looked at from there: beyond what a rest kept, all of the path is, always."""
        return kept_behind(self.kept, flown) == kept_behind(self.kept, self.flown)


class MissionFactsBook:
    """Answers at once; what it does not know yet it reads beside, for the next time it is asked."""

    def __init__(
        self, missions: Missions, features: Features, watch: MapWatch, database: Database, fleet: FleetReader
    ) -> None:
        self._fleet = fleet
        self._missions, self._features, self._watch, self._database = missions, features, watch, database
        self._around: dict[str, _Around] = {}
        self._reading: dict[str, asyncio.Task[None]] = {}
        self._round = 0

    def of(self, mission_id: str) -> MissionFacts | None:
        """Return what is known of a mission, ``None`` if it is not stored here."""
        mission = self._missions.known(mission_id)
        if mission is None:
            return None
        robot = self._fleet.robot(mission.robot_id or "")
        sheet = None if robot is None else robot.factsheet
        around, key, flown = self._around.get(mission_id), self._key(mission, sheet), flown_of(mission, robot)
        is_known = around is not None and around.key == key and around.is_from(flown)
        if not is_known and mission_id not in self._reading:
            task = asyncio.get_running_loop().create_task(self._read(mission, sheet, flown), name="mission facts")
            self._reading[mission_id] = task
        figures = mission.statistics
        return MissionFacts(
            mission.sha256,
            mission.name,
            mission.revision,
            battery_share_on(figures, sheet),
            figures.get("duration_s"),
            None if around is None else around.map_number,
            None if around is None else around.map_text,
            None if around is None else around.start,
            () if around is None else around.fences,
            bool(mission.pending_sha256),
            figures.get("reserve_share") or BATTERY_RESERVE,
            # what was looked at on another map, or for another height, clears nothing
            around.flight_text if around is not None and is_known else None,
        )

    def in_flight(self, mission_id: str) -> str | None:
        """Return what stands in the path of a mission that is flown, ``None`` if that is not known yet."""
        facts = self.of(mission_id)
        return None if facts is None else facts.flight_text

    def _key(self, mission: Mission, sheet: Factsheet | None) -> _Key:
        return mission.sha256, self._round, None if sheet is None else (sheet.family, sheet.path_height_m)

    def map_published(self) -> None:
        """Look again at every mission: the map is another one."""
        self._round += 1

    async def close(self) -> None:
        """End what is being read."""
        for task in self._reading.values():
            task.cancel()
        await asyncio.gather(*self._reading.values(), return_exceptions=True)

    async def _read(self, mission: Mission, sheet: Factsheet | None, flown: int | None) -> None:
        key = self._key(mission, sheet)
        try:
            document = await self._database.run(self._missions.document, mission.farm_id, mission.id)
            farms = await self._database.run(self._features.all, mission.farm_id, ("farm",))
            fences = tuple(_ring(one.geometry) for one in farms)
            start = await asyncio.to_thread(_start, document)  # the first one loads the geometry
            number = mission.planned_on(document)
            text = await self._map_text(mission.farm_id, number, document)
            in_flight = await self._flight_text(mission.farm_id, document, sheet, flown)
            kept = kept_of(document)
            self._around[mission.id] = _Around(key, start, fences, number, text, in_flight, flown, kept)
        except (NotFound, StoreError) as error:
            log.info("nothing is known around mission %s: %s", mission.id, error)
        finally:
            self._reading.pop(mission.id, None)

    async def _flight_text(
        self, farm_id: str, document: dict[str, Any], sheet: Factsheet | None, flown: int | None
    ) -> str:
        try:
            await self._watch.check_flight(farm_id, document, sheet, flown)
        except OrderRefused as refused:
            return refused.text
        return ""

    async def _map_text(self, farm_id: str, number: int | None, document: dict[str, Any]) -> str | None:
        if number is None:
            return None
        try:
            await self._watch.check(farm_id, number, document)
        except OrderRefused as refused:
            return refused.text[0].upper() + refused.text[1:]
        return ""


def _start(document: dict[str, Any]) -> Place:
    from hmi.planning.projection import LocalFrame  # numpy and pyproj: not for a console's start

    frame = LocalFrame(document["datum"]["lat_deg"], document["datum"]["lon_deg"])
    lon, lat = frame.to_lon_lat([document["segments"][0]["points"][0]])[0]
    return float(lon), float(lat)


def _ring(geometry: dict[str, Any]) -> tuple[Place, ...]:
    rings = geometry["coordinates"] if geometry["type"] == "Polygon" else geometry["coordinates"][0]
    return tuple((float(p[0]), float(p[1])) for p in rings[0])
