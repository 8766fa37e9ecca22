"""Documents of a rest, or of the whole mission again, on their way to a robot."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from hmi.clock import Clock
from hmi.commands.gate import Gate
from hmi.commands.lease_service import LeaseService
from hmi.commands.map_watch import MapWatch
from hmi.commands.mission_book import FRESH
from hmi.commands.mission_send import MissionSender
from hmi.commands.ports import FleetReader, StoredMission
from hmi.commands.rest_words import DRAWN, drawn_on, drawn_words, forgotten_words, rest_words
from hmi.commands.service import CommandService
from hmi.domain.mission import ENDED, BadMove, MissionStatus, Mover
from hmi.domain.mission_document import for_robot, mission_sha256
from hmi.domain.mission_rest import DrawnArea, PlannedRest, Progress, RestPlanner
from hmi.security.authorization import Authorize
from hmi.store.database import Database
from hmi.store.features import Features
from hmi.store.maps import Maps
from hmi.store.mission_revisions import MissionRevisions
from hmi.store.missions import Mission, Missions

LATER = "later"


@dataclass(frozen=True, slots=True)
class RestParts:
    """What the rest book is wired to."""

    missions: Missions
    revisions: MissionRevisions
    features: Features
    maps: Maps
    database: Database
    fleet: FleetReader
    planner: RestPlanner
    gate: Gate
    leases: LeaseService
    sender: MissionSender
    commands: CommandService
    authorize: Authorize
    clock: Clock


class RestSource:
    """The document of a rest on its way to the robot."""

    def __init__(
        self,
        parts: RestParts,
        mission: Mission,
        kind: str,
        planned: PlannedRest,
        watch: MapWatch,
        areas: tuple[DrawnArea, ...] = (),
    ) -> None:
        self._parts, self._mission, self._kind = parts, mission, kind
        self._planned, self._map, self._areas = planned, watch, areas
        self._why = rest_words(kind, planned.difference, areas)

    async def stored(self, farm_id: str, mission_id: str, robot_id: str, by: str) -> StoredMission | None:
        """Keep the document as sent, not confirmed; raises ``OrderRefused`` if the map changed since it was shown."""
        planned, mission = self._planned, self._mission
        stamp = planned.document.get("map_version")
        note = await self._map.check(farm_id, stamp["number"] if stamp else None, planned.document)
        statistics = _merged(mission.statistics, planned.statistics)
        statistics[DRAWN] = [one.as_json() for one in self._areas]
        await self._parts.database.run(
            self._parts.revisions.propose,
            farm_id,
            mission_id,
            planned.document,
            statistics,
            by,
            self._why,
        )
        return StoredMission(mission_id, mission.name, planned.document, planned.sha256, note)

    async def sent(self, farm_id: str, mission_id: str, robot_id: str, by: str) -> None:
        """The robot has read it back: it is the mission's own now."""
        run = self._parts.database.run
        await run(self._parts.revisions.take, farm_id, mission_id, self._planned.sha256, by, self._why)
        known = self._parts.missions.known(mission_id)
        if self._kind == LATER and known is not None and known.status in ENDED:
            paused = MissionStatus.PAUSED
            with contextlib.suppress(BadMove):  # the robot's report was faster
                await run(self._parts.missions.move, farm_id, mission_id, paused, Mover.PERSON, by, self._why)


class FreshSource:
    """The whole mission on its way to the robot again."""

    def __init__(self, parts: RestParts, mission: Mission, watch: MapWatch) -> None:
        self._parts, self._mission, self._map = parts, mission, watch
        self._sha256 = ""

    async def stored(self, farm_id: str, mission_id: str, robot_id: str, by: str) -> StoredMission | None:
        """Keep the whole document as sent, not confirmed."""
        run = self._parts.database.run
        document, statistics = await run(self._parts.revisions.whole, farm_id, mission_id)
        document = for_robot(document, robot_id)
        robot = self._parts.fleet.robot(robot_id)
        if robot is not None:
            await self._map.check_flight(farm_id, document, robot.factsheet)
        note = await self._map.check(farm_id, self._mission.planned_on(document), document)
        areas = drawn_on(self._mission)
        if areas:  # nothing moves yet: whoever starts it can still look
            note = " ".join(filter(None, (note, f"It knows nothing of what was drawn: {drawn_words(areas)}.")))
        self._sha256 = mission_sha256(document)
        await run(self._parts.revisions.propose, farm_id, mission_id, document, statistics, by, self._why())
        return StoredMission(mission_id, self._mission.name, document, self._sha256, note)

    async def sent(self, farm_id: str, mission_id: str, robot_id: str, by: str) -> None:
        """The robot has it, from its first row."""
        run, missions = self._parts.database.run, self._parts.missions
        await run(self._parts.revisions.take, farm_id, mission_id, self._sha256, by, self._why())
        known = missions.known(mission_id)
        if known is not None and known.status is not MissionStatus.ACCEPTED:
            with contextlib.suppress(BadMove):  # the end of what ran before is not stored yet; the report moves it on
                await run(missions.move, farm_id, mission_id, MissionStatus.SENT, Mover.PERSON, by, self._why())

    def _why(self) -> str:
        forgotten = forgotten_words(self._mission, Progress.from_json(self._mission.progress))
        return f"{FRESH} Forgotten: {forgotten}." if forgotten else FRESH


def _merged(before: Mapping[str, Any], now: Mapping[str, Any]) -> dict[str, Any]:
    """Return a mission's figures after its rest changed; the area goes with the length of its rows."""
    covered = {"covered_m2": before["covered_m2"] * now["covered_share"]} if "covered_m2" in before else {}
    return {**before, **{key: value for key, value in now.items() if key != "covered_share"}, **covered}
