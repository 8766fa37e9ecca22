"""Fill an empty installation with the demo farm. Everything here may run again: what is there stays as it is."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, replace
from pathlib import Path

from hmi.clock import Clock
from hmi.demo.catalogue import CATALOGUE, DemoMission, plan
from hmi.demo.farm import features
from hmi.demo.fleet import ROBOTS, read_demo_fleet
from hmi.demo.history import PAST_RUNS, PastRun, RunOutcome, record_run
from hmi.domain.mission import MissionStatus, Mover
from hmi.domain.mission_document import renamed
from hmi.domain.mission_plan import PlannedMission
from hmi.domain.robot import Family
from hmi.planning.side_process import SideProcess
from hmi.store.database import Database
from hmi.store.features import Feature, Features
from hmi.store.missions import Mission, Missions
from hmi.store.robots import RegisteredRobot, Robots

BY = "Headland demo"
AT_ONCE = 2  # missions planned before the first page is served: the whole parcel takes a second or more
Planning = Callable[[DemoMission], Awaitable[PlannedMission]]
log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class SeedParts:
    """Where the demo farm goes."""

    database: Database
    features: Features
    missions: Missions
    robots: Robots
    clock: Clock
    farm_id: str
    data: Path


class DemoSeed:
    """Seeds once: ``at_once`` before serving, ``in_background`` while serving, ``close`` at the end."""

    def __init__(self, parts: SeedParts) -> None:
        self._parts = parts
        self._task: asyncio.Task[None] | None = None
        self._process = SideProcess()

    async def at_once(self) -> None:
        """Store map, robots and the first missions; a second or two at the first start, nothing later."""
        await self._parts.database.run(self._parts.missions.load)
        await self._parts.database.run(self._map)
        await self._parts.database.run(self._robots)
        for mission in CATALOGUE[:AT_ONCE]:
            await self._mission(mission, lambda one: asyncio.to_thread(plan, one))

    def in_background(self) -> None:
        """Begin with the remaining missions and the history."""
        if self._task is None:
            self._task = asyncio.create_task(self._rest(), name="demo-seed")

    async def finished(self) -> None:
        """Wait until the background part is done."""
        if self._task is not None:
            await self._task

    async def close(self) -> None:
        """End; what is not done is done at the next start."""
        if self._task is not None:
            self._task.cancel()
            await asyncio.gather(self._task, return_exceptions=True)
            self._task = None
        await asyncio.to_thread(self._process.close)

    def _map(self) -> None:
        parts = self._parts
        known = {one.id for one in parts.features.all(parts.farm_id)}
        parts.features.put(
            Feature(one.id, parts.farm_id, one.kind, one.name, one.geometry, one.properties)
            for one in features()
            if one.id not in known
        )

    def _robots(self) -> None:
        """Register the robots; their address changes with each start, what an administrator set stays."""
        parts = self._parts
        rows = {row["id"]: row for row in read_demo_fleet(parts.data)}
        for one in ROBOTS:
            row = rows.get(one.id)
            if row is None:
                continue
            url, token = row["http_url"], row["token"]
            known = parts.robots.get(one.id)
            if known is None:
                parts.robots.add(
                    RegisteredRobot(
                        id=one.id,
                        farm_id=parts.farm_id,
                        name=one.name,
                        family=Family.WEEDER,
                        added_by=BY,
                        added_at=parts.clock.utc(),
                        http_url=url,
                        http_token=token,
                        contact_name=one.contact_name,
                        contact_phone=one.contact_phone,
                    )
                )
            elif (known.http_url, known.http_token) != (url, token):
                parts.robots.change(replace(known, http_url=url, http_token=token))

    async def _mission(self, mission: DemoMission, planning: Planning) -> None:
        if self._parts.missions.known(mission.id) is None:
            planned = await planning(mission)
            stored = self._stored(mission, planned)
            await self._parts.database.run(self._parts.missions.add, stored, planned.document, "Comes with the demo.")

    async def _rest(self) -> None:
        try:
            for mission in CATALOGUE[AT_ONCE:]:
                await self._mission(mission, lambda one: self._process.run(plan, one))
            for run in PAST_RUNS:
                if self._parts.missions.known(run.id) is None:
                    await self._past(run)
        except Exception:  # the demo works without its past; the next start tries again
            log.exception("the demo's history could not be made")
        finally:
            await asyncio.to_thread(self._process.close)

    async def _past(self, run: PastRun) -> None:
        parts = self._parts
        mission = {one.id: one for one in CATALOGUE}[run.mission_id]
        document = await parts.database.run(parts.missions.document, parts.farm_id, mission.id)
        document = renamed(document, mission_id=run.id)
        started = parts.clock.utc() - run.ago
        url = parts.database.url.render_as_string(hide_password=False)
        outcome = await self._process.run(record_run, url, parts.farm_id, document, started, run.seed)
        template = parts.missions.known(mission.id)
        assert template is not None
        planned = PlannedMission(document, template.sha256, dict(template.statistics))
        await parts.database.run(self._finished_mission, run, mission, planned, outcome)

    def _finished_mission(
        self, run: PastRun, mission: DemoMission, planned: PlannedMission, outcome: RunOutcome
    ) -> None:
        """Store a mission with the life it had: sent, accepted, run, ended."""
        missions, farm = self._parts.missions, self._parts.farm_id
        stored = replace(self._stored(mission, planned), id=run.id)
        missions.add(stored, planned.document, "Simulated at the first start of the demo.", at=outcome.started)
        robot = next(one.name for one in ROBOTS if one.id == mission.robot_id)
        end = {"done": MissionStatus.DONE, "aborted": MissionStatus.ABORTED}.get(outcome.status, MissionStatus.FAILED)
        data = {
            "row": outcome.row,
            "rows": outcome.rows,
            "area_done_m2": outcome.area_done_m2,
            "distance_m": outcome.distance_m,
            "duration_s": (outcome.ended - outcome.started).total_seconds(),
        }
        nothing: dict[str, float] = {}
        steps = (
            (MissionStatus.SENT, Mover.PERSON, BY, outcome.started, nothing),
            (MissionStatus.ACCEPTED, Mover.ROBOT, robot, outcome.started, nothing),
            (MissionStatus.RUNNING, Mover.ROBOT, robot, outcome.started, nothing),
            (end, Mover.ROBOT, robot, outcome.ended, data),
        )
        for status, mover, by, at, facts in steps:
            missions.move(farm, run.id, status, mover, by, "Simulated.", at=at, data=facts)

    def _stored(self, mission: DemoMission, planned: PlannedMission) -> Mission:
        now = self._parts.clock.utc()
        return Mission(
            id=mission.id,
            farm_id=self._parts.farm_id,
            name=mission.name,
            field_name=planned.document["field_name"],
            status=MissionStatus.VALIDATED,
            sha256=planned.sha256,
            created_by=BY,
            created_at=now,
            updated_at=now,
            robot_id=mission.robot_id,
            field_id=mission.field_id,
            statistics=planned.statistics,
            map_version=1,  # the map the demo comes with
        )
