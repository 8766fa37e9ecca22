"""Fill an empty installation with the demo farm. Everything here may run again: what is there stays as it is."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, replace
from pathlib import Path

from hmi.clock import Clock
from hmi.demo.catalogue import CATALOGUE, PAST, DemoMission, plan
from hmi.demo.farm import features
from hmi.demo.fleet import demo_robots, read_demo_fleet, robot
from hmi.demo.past import PAST_RUNS, PastRun, RunOutcome
from hmi.demo.work import planned_work, task_of
from hmi.domain.mission import MissionStatus, Mover
from hmi.domain.mission_document import renamed
from hmi.domain.mission_plan import PlannedMission
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
        await self._parts.database.run(self._work)

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
        if parts.features.all(parts.farm_id):
            return  # what people made of the map stays
        parts.features.put(
            Feature(one.id, parts.farm_id, one.kind, one.name, one.geometry, one.properties) for one in features()
        )

    def _robots(self) -> None:
        """Register the robots; their address changes with each start, what an administrator set stays."""
        parts = self._parts
        rows = read_demo_fleet(parts.data)
        self._unregister({row["id"] for row in rows})
        for row in rows:
            one = robot(row["id"])
            url, token = row["http_url"], row["token"]
            known = parts.robots.get(one.id)
            if known is None:
                parts.robots.add(
                    RegisteredRobot(
                        id=one.id,
                        farm_id=parts.farm_id,
                        name=one.name,
                        family=one.family,
                        added_by=BY,
                        added_at=parts.clock.utc(),
                        http_url=url,
                        http_token=token,
                        is_unattended_allowed=bool(row.get("task")) and task_of(one.id) is not None,
                        contact_name=one.contact[0],
                        contact_phone=one.contact[1],
                    )
                )
            elif (known.http_url, known.http_token) != (url, token):
                parts.robots.change(replace(known, http_url=url, http_token=token))

    def _unregister(self, running: set[str]) -> None:
        """Take out what another size of the demo left behind: silent for ever, each would need somebody."""
        own = {one.id for one in demo_robots("full")}
        for known in self._parts.robots.all():
            if known.id in own and known.added_by == BY and known.id not in running:
                self._parts.robots.remove(known.id)

    async def _mission(self, mission: DemoMission, planning: Planning) -> None:
        if self._parts.missions.known(mission.id) is None:
            planned = await planning(mission)
            stored = self._stored(mission, planned)
            await self._parts.database.run(self._parts.missions.add, stored, planned.document, "Comes with the demo.")

    def _work(self) -> None:
        """Store what the robots are busy with, so that it is known when they report it."""
        parts = self._parts
        for row in read_demo_fleet(parts.data):
            task = task_of(row["id"]) if row.get("task") else None
            if task is None or parts.missions.known(task.mission_id) is not None:
                continue
            planned = planned_work()[task.mission_id]
            name = planned.document["name"]
            mission = DemoMission(task.mission_id, name, task.field_id, task.robot_id, task.width_m)
            stored = replace(self._stored(mission, planned), is_supervised=False)
            parts.missions.add(stored, planned.document, "Comes with the demo.")

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
        mission = {one.id: one for one in (*CATALOGUE, *PAST)}[run.mission_id]
        template = await self._process.run(plan, mission)
        document = renamed(template.document, mission_id=run.id)
        started = parts.clock.utc() - run.ago
        url = parts.database.url.render_as_string(hide_password=False)
        from hmi.demo.history import record_run  # brings the simulator, which a farm with its past does not need

        outcome = await self._process.run(record_run, url, parts.farm_id, document, started, run.seed)
        planned = PlannedMission(document, template.sha256, dict(template.statistics))
        await parts.database.run(self._finished_mission, run, mission, planned, outcome)

    def _finished_mission(
        self, run: PastRun, mission: DemoMission, planned: PlannedMission, outcome: RunOutcome
    ) -> None:
        """Store a mission with the life it had: sent, accepted, run, ended."""
        missions, farm = self._parts.missions, self._parts.farm_id
        stored = replace(self._stored(mission, planned), id=run.id)
        missions.add(stored, planned.document, "Simulated at the first start of the demo.", at=outcome.started)
        name = robot(mission.robot_id).name
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
            (MissionStatus.ACCEPTED, Mover.ROBOT, name, outcome.started, nothing),
            (MissionStatus.RUNNING, Mover.ROBOT, name, outcome.started, nothing),
            (end, Mover.ROBOT, name, outcome.ended, data),
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
