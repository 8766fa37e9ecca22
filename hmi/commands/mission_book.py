"""The farm's missions for screens and programs: list, plan, copy, rename, delete, and hand over for sending."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncGenerator, AsyncIterator, Callable, Sequence
from contextlib import aclosing
from dataclasses import dataclass, replace
from typing import Any

from hmi.clock import Clock
from hmi.commands.audit_line import audit_line
from hmi.commands.map_watch import MapStamp, MapWatch, flown_of
from hmi.commands.mission_machine import misfit, planned_machine
from hmi.commands.plan_wish import FAR_M, PlanOrder, metres, wish_for
from hmi.commands.ports import AuditSink, FleetReader, StoredMission
from hmi.commands.refusal import IN_QUEUE, IS_DRAFT, OTHER_MACHINE, OrderRefused
from hmi.commands.rest_words import forgotten_words
from hmi.domain.ids import new_id
from hmi.domain.mission import ENDED, UNDER_WAY, BadMove, MissionStatus, Mover
from hmi.domain.mission_document import Document, for_robot, mission_sha256, renamed
from hmi.domain.mission_plan import Candidate, MissionRefused, Pattern, PlannedMission, Planner, PlanRefused, PlanWish
from hmi.domain.mission_rest import Progress
from hmi.domain.planned_machine import MACHINE
from hmi.domain.robot import Robot
from hmi.domain.role import Permission
from hmi.security.authorization import Authorize
from hmi.security.session_info import SessionInfo
from hmi.store.database import Database
from hmi.store.errors import NotFound
from hmi.store.features import Feature, Features
from hmi.store.maps import Maps
from hmi.store.mission_drafts import MissionDrafts, refuse_draft, refuse_planned
from hmi.store.mission_revisions import MissionRevisions
from hmi.store.missions import Mission, MissionLogEntry, Missions

FRESH = "The whole mission again, from its first row."
INTERRUPTED = (MissionStatus.PAUSED, MissionStatus.ABORTED, MissionStatus.FAILED)
log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class MissionParts:
    """What the book is wired to."""

    missions: Missions
    features: Features
    database: Database
    fleet: FleetReader
    planner: Planner
    audit: AuditSink
    authorize: Authorize
    clock: Clock
    maps: Maps


@dataclass(frozen=True, slots=True)
class CandidateAnswer:
    """One pattern of a comparison: how far it is, then the plan, or why there is none.

    Args:
        same_as: names a pattern with the same path.
        progress: of a planner that tells it, a share from 0 to 1 and words; the answer itself is still to come.
    """

    pattern: Pattern
    candidate: Candidate | None = None
    refusal: PlanRefused | None = None
    same_as: Pattern | None = None
    progress: tuple[float, str] | None = None


class MissionBook:
    """Answers everything about stored missions; each method asks the person's rights first.

    Raises (every method with a session): ``NotSignedIn``, ``NotAllowed``, ``StoreError`` and what it names itself.
    Also the ``MissionSource`` of the sending service.
    """

    def __init__(self, parts: MissionParts) -> None:
        self._parts = parts
        self._missions, self._database = parts.missions, parts.database
        self.revisions = MissionRevisions(parts.missions, parts.database, parts.clock)
        self._drafts = MissionDrafts(parts.missions)
        self._map = MapWatch(parts.maps, parts.database)
        self.queue_of: Callable[[str], str | None] = lambda _mission_id: None
        """Tells in which robot's queue a mission stands, once there are queues; from memory."""

    async def load(self) -> None:
        """Read the missions into memory; at start."""
        await self._database.run(self._missions.load)

    def title(self, mission_id: str) -> tuple[str, str] | None:
        """Return name and field of a mission from memory, for the live lane."""
        mission = self._missions.known(mission_id)
        return None if mission is None else (mission.name, mission.field_name)

    def list(self, session: SessionInfo) -> list[Mission]:
        """Return the farm's missions from memory, the one that changed last first."""
        self._parts.authorize(session, Permission.WATCH)
        return self._missions.all_known(session.farm_id)

    async def log(self, session: SessionInfo, mission_id: str) -> Sequence[MissionLogEntry]:
        """Return who moved a mission on, when and why."""
        self._parts.authorize(session, Permission.WATCH)
        return await self._database.run(self._missions.log, session.farm_id, mission_id)

    async def document(self, session: SessionInfo, mission_id: str) -> Document:
        """Return a mission's wire document; raises ``NotFound``, ``MissionRefused`` for a draft."""
        self._parts.authorize(session, Permission.WATCH)
        known = self._missions.known(mission_id)
        if known is not None and known.farm_id == session.farm_id:
            refuse_draft(known)
        return await self._database.run(self._missions.document, session.farm_id, mission_id)

    async def document_read_back(self, session: SessionInfo, mission_id: str, sha256: str) -> Document | None:
        """Return the document of this hash if a robot was sent it, e.g. one that is just being read back."""
        self._parts.authorize(session, Permission.WATCH)
        return await self._database.run(self.revisions.document, session.farm_id, mission_id, sha256)

    async def features(self, session: SessionInfo, kinds: Sequence[str] = ()) -> Sequence[Feature]:
        """Return the farm's map."""
        self._parts.authorize(session, Permission.WATCH)
        return await self._database.run(self._parts.features.all, session.farm_id, kinds)

    async def preview(self, session: SessionInfo, order: PlanOrder) -> PlannedMission:
        """Plan without storing; raises ``PlanRefused`` and ``NotFound`` (field or home)."""
        self._parts.authorize(session, Permission.EDIT_MISSION, order.robot_id)
        return await self._parts.planner.plan(await self._wish(session, order, "preview"))

    async def candidates(self, session: SessionInfo, order: PlanOrder) -> AsyncIterator[CandidateAnswer]:
        """Return the same wish in one pattern after another, the wished one first, each as soon as it is planned.

        A pattern that cannot be planned says so; the others come all the same. Ending the iteration frees the planner.

        Raises:
            NotFound: field, home or a treatment area; before anything is planned.
        """
        self._parts.authorize(session, Permission.EDIT_MISSION, order.robot_id)
        return self._compared(await self._wish(session, order, "preview"))

    async def _compared(self, wish: PlanWish) -> AsyncIterator[CandidateAnswer]:
        patterns = sorted(Pattern, key=lambda pattern: (pattern is not wish.pattern, pattern is Pattern.SHORTEST))
        paths: dict[tuple[float, ...], Pattern] = {}
        for pattern in patterns:
            try:
                async with aclosing(told_while(self._parts.planner, replace(wish, pattern=pattern))) as steps:
                    async for step in steps:
                        if not isinstance(step, Candidate):
                            yield CandidateAnswer(pattern, progress=step)
                            continue
                        same = paths.setdefault(_fingerprint(step), pattern)
                        yield CandidateAnswer(pattern, step, same_as=None if same is pattern else same)
            except PlanRefused as refusal:
                yield CandidateAnswer(pattern, refusal=refusal)

    async def plan(
        self, session: SessionInfo, order: PlanOrder, draft_id: str | None = None, draft_revision: int = 0
    ) -> Mission:
        """Plan and store a mission; raises as ``preview``.

        Args:
            draft_id: of the draft that becomes this mission, as it was when it was saved ``draft_revision`` times.

        Raises:
            MissionRefused: it is no draft any more, or somebody else saved it since.
        """
        self._parts.authorize(session, Permission.EDIT_MISSION, order.robot_id)
        mission_id = draft_id or f"m-{new_id()[:12]}"
        if draft_id is not None:
            order = self._of_draft(session, draft_id, order)
        version = await self._map.now(session.farm_id)  # first: what is published meanwhile makes the plan look old
        wish = await self._wish(session, order, mission_id)
        planned = _on_map(await self._parts.planner.plan(wish), version)
        now = self._parts.clock.utc()
        mission = Mission(
            id=mission_id,
            farm_id=session.farm_id,
            name=wish.name,
            field_name=wish.field_name,
            status=MissionStatus.VALIDATED,
            sha256=planned.sha256,
            created_by=session.user_name,
            created_at=now,
            updated_at=now,
            robot_id=order.robot_id,
            field_id=order.field_id,
            is_supervised=order.is_supervised,
            statistics=planned.statistics,
            map_version=version.number,
        )
        place = planned.statistics.get("planned_at") or {}
        why, run = place.get("text") or "Planned.", self._database.run
        if draft_id is None:
            stored = await run(self._missions.add, mission, planned.document, why)
        else:
            complete = self._drafts.complete
            stored = await run(complete, mission, planned.document, draft_revision, session.user_name, why)
        about = {"width_m": order.width_m, "field_id": order.field_id}
        self._audit(session, stored, "planned", {**about, "planned_at": place["where"]} if place else about)
        return stored

    def _of_draft(self, session: SessionInfo, draft_id: str, order: PlanOrder) -> PlanOrder:
        """Return the order of a draft, which has a name already."""
        known = self._missions.known(draft_id)
        if known is None or known.farm_id != session.farm_id:
            raise NotFound(f"there is no draft {draft_id!r}")
        refuse_planned(known)
        return replace(order, name=order.name or known.name)

    async def rename(self, session: SessionInfo, mission_id: str, name: str) -> Mission:
        """Give a mission another name; raises ``NotFound``, ``MissionRefused``."""
        self._parts.authorize(session, Permission.EDIT_MISSION)
        stored = await self._database.run(self._missions.rename, session.farm_id, mission_id, name, session.user_name)
        self._audit(session, stored, "renamed", {"name": name})
        return stored

    async def copy(self, session: SessionInfo, mission_id: str, name: str = "") -> Mission:
        """Store a copy that has not run; raises ``NotFound``."""
        self._parts.authorize(session, Permission.EDIT_MISSION)
        stored = await self._database.run(self._copy, session.farm_id, session.user_name, mission_id, name)
        self._audit(session, stored, "copied", {"from": mission_id})
        return stored

    async def delete(self, session: SessionInfo, mission_id: str) -> None:
        """Delete a mission that never ran; raises ``NotFound``, ``MissionRefused``."""
        self._parts.authorize(session, Permission.EDIT_MISSION)
        mission = self._missions.known(mission_id)
        await self._database.run(self._missions.delete, session.farm_id, mission_id)
        if mission is not None:
            self._audit(session, mission, "deleted", {})

    def forgets(self, farm_id: str, mission_id: str) -> str:
        """Say what of interrupted work sending the whole mission would forget; from memory."""
        mission = self._missions.known(mission_id)
        if mission is None or mission.farm_id != farm_id or mission.status not in INTERRUPTED:
            return ""
        return forgotten_words(mission, Progress.from_json(mission.progress))

    async def stored(self, farm_id: str, mission_id: str, robot_id: str, by: str = "") -> StoredMission | None:
        """Return a mission as ``by`` sends it to this robot, ``None`` if there is none.

        Raises:
            OrderRefused: another robot works on it or has it in its queue, it was planned for a machine that can more,
                the robot is at another site, or the map changed around it.
        """
        mission = self._missions.known(mission_id)
        if mission is None or mission.farm_id != farm_id:
            return None
        if mission.status is MissionStatus.DRAFT:
            raise OrderRefused(IS_DRAFT, f"{mission.name} is a draft. Open it and plan it first.")
        if mission.status in UNDER_WAY and mission.robot_id != robot_id:
            text = f"{mission.name} is {mission.status.value} on {mission.robot_id}. Copy it for another robot."
            raise OrderRefused("in_use", text)
        if mission.status is MissionStatus.PAUSED and self.forgets(farm_id, mission_id):
            # the bytes it has already would begin nothing anew
            raise OrderRefused("paused", f"{mission.name} is paused. Start it fresh from there, which ends it first.")
        is_fresh = mission.status in ENDED
        if is_fresh:
            document, statistics = await self._database.run(self.revisions.whole, farm_id, mission_id)
        else:
            document, statistics = await self._database.run(self._missions.document, farm_id, mission_id), {}
        self.refuse_other_robot(mission, robot_id)
        document = for_robot(document, robot_id)
        robot = self._parts.fleet.robot(robot_id)
        if robot is not None:
            _refuse_if_far(robot, mission, document)
            await self._map.check_flight(farm_id, document, robot.factsheet, flown_of(mission, robot))
        note = await self._map.check(farm_id, mission.planned_on(document), document)
        if is_fresh:  # the same bytes again would be no new beginning for a robot that has them
            statistics = self._with_machine(mission, statistics)
            await self._database.run(self.revisions.propose, farm_id, mission_id, document, statistics, by, FRESH)
        return StoredMission(mission_id, mission.name, document, mission_sha256(document), note)

    def machine_of(self, mission: Mission) -> dict[str, Any] | None:
        """Return the machine a mission was planned for as it is stored, ``None`` if it is not known."""
        machine = planned_machine(mission, self._parts.fleet)
        return None if machine is None else machine.as_json()

    def _with_machine(self, mission: Mission, statistics: dict[str, Any]) -> dict[str, Any]:
        """Return figures that say which machine they are of, also those of missions from before that was kept."""
        machine = self.machine_of(mission)
        return statistics if machine is None else {MACHINE: machine, **statistics}

    def refuse_other_robot(self, mission: Mission, robot_id: str) -> None:
        """Return if a mission may go to this robot.

        Raises:
            OrderRefused: it stands in the queue of another one, or was planned for a machine that can more.
        """
        queue = None if mission.status in ENDED else self.queue_of(mission.id)
        if queue is not None and queue != robot_id:
            robot = self._parts.fleet.robot(queue)
            name = queue if robot is None else robot.name
            raise OrderRefused(IN_QUEUE, f"It stands in the queue of {name}. Take it out there, or copy it.")
        why = misfit(mission, robot_id, self._parts.fleet)
        if why:
            raise OrderRefused(OTHER_MACHINE, why)

    async def sent(self, farm_id: str, mission_id: str, robot_id: str, by: str) -> None:
        """Note that the robot holds this mission now."""
        await self._database.run(self._sent, farm_id, mission_id, robot_id, by)

    async def refused(self, farm_id: str, mission_id: str, sha256: str, by: str, why: str) -> None:
        """Wait no longer for a document that was proposed: no robot holds it; one without an answer is not meant."""
        mission = self._missions.known(mission_id)
        if mission is not None and mission.pending_sha256 == sha256:
            await self._database.run(self.revisions.drop, farm_id, mission_id, by, f"Not changed: {why}")

    def _sent(self, farm_id: str, mission_id: str, robot_id: str, by: str) -> None:
        robot = self._parts.fleet.robot(robot_id)
        why = f"Sent to {robot.name if robot is not None else robot_id}, read back whole."
        known = self._missions.known(mission_id)
        if known is not None and known.pending_sha256:
            self.revisions.take(farm_id, mission_id, known.pending_sha256, by, FRESH)
        known = self._missions.known(mission_id)
        if known is not None and known.robot_id == robot_id and known.status is MissionStatus.ACCEPTED:
            # the robot's report was faster than its answer to the sending
            self._missions.note(farm_id, mission_id, by, why)
            return
        # a queued mission is moved on by the console, whoever sent it: it stays in its queue
        is_queued = known is not None and known.status in (MissionStatus.QUEUED, MissionStatus.WAITING)
        mover = Mover.CONSOLE if is_queued else Mover.PERSON
        try:
            machine = None if known is None else self.machine_of(known)
            self._missions.move(
                farm_id, mission_id, MissionStatus.SENT, mover, by, why, robot_id=robot_id, machine=machine
            )
        except BadMove as error:
            log.warning("mission %s was sent to %s but stays as it is: %s", mission_id, robot_id, error)

    async def again(self, farm_id: str, mission_id: str, name: str, by: str) -> Mission:
        """Store a copy for the next day of a repeating job, which a person with the right to do so ordered before.

        Raises:
            NotFound: there is no such mission.
        """
        return await self._database.run(self._copy, farm_id, by, mission_id, name)

    async def change(
        self, session: SessionInfo, mission_id: str, *, is_supervised: bool | None = None, robot_id: str | None = None
    ) -> Mission:
        """Mark a mission attended or not, or give it to another robot; what is left out stays.

        Raises:
            NotFound: there is no such mission.
            MissionRefused: a robot holds it, a queue waits for it, another robot could not resume it, or not drive it.
        """
        self._parts.authorize(session, Permission.EDIT_MISSION, robot_id)
        known = self._missions.known(mission_id)
        is_here = known is not None and known.farm_id == session.farm_id
        if known is not None and is_here and known.status is not MissionStatus.DRAFT and robot_id is not None:
            try:
                self.refuse_other_robot(known, robot_id)
            except OrderRefused as refused:
                raise MissionRefused(refused.code, refused.text) from refused
        stored = await self._database.run(
            self._missions.adjust,
            session.farm_id,
            mission_id,
            session.user_name,
            is_supervised=is_supervised,
            robot_id=robot_id,
            machine=None if known is None else self.machine_of(known),
        )
        self._audit(session, stored, "changed", {"is_supervised": is_supervised, "robot_id": robot_id})
        return stored

    def _copy(self, farm_id: str, by: str, mission_id: str, name: str) -> Mission:
        known = self._missions.known(mission_id)
        if known is None or known.farm_id != farm_id:
            raise NotFound(f"there is no mission {mission_id!r}")
        copy_id, name = f"m-{new_id()[:12]}", name or f"{known.name[:73]}, copy"
        if known.status is MissionStatus.DRAFT:
            draft = replace(known, id=copy_id, name=name, created_by=by, revision=1)
            return self._missions.add(draft, {}, f"Copy of {known.name}.")
        document, statistics = self.revisions.whole(farm_id, mission_id)
        document = {**document, "revision": 1}
        copy = replace(
            known,
            id=copy_id,
            name=name,
            status=MissionStatus.VALIDATED,
            created_by=by,
            statistics=statistics,
            revision=1,
            map_version=known.planned_on(document),
            progress=None,
            pending_sha256="",
        )
        return self._missions.add(copy, renamed(document, mission_id=copy_id, name=name), f"Copy of {known.name}.")

    async def _wish(self, session: SessionInfo, order: PlanOrder, mission_id: str) -> PlanWish:
        features = await self._database.run(self._parts.features.all, session.farm_id)
        field = await self._database.run(self._parts.features.get, session.farm_id, order.field_id)
        robot = self._parts.fleet.robot(order.robot_id)
        return wish_for(order, mission_id, field, features, None if robot is None else robot.factsheet)

    def _audit(self, session: SessionInfo, mission: Mission, outcome: str, data: dict[str, Any]) -> None:
        text, robot_id = f"{mission.name} {outcome}.", mission.robot_id
        self._parts.audit.append(
            audit_line(session, "mission", outcome, text, ref=mission.id, robot_id=robot_id, data=data)
        )


async def told_while(planner: Planner, wish: PlanWish) -> AsyncGenerator[tuple[float, str] | Candidate, None]:
    """Return how far a candidate is, as often as it is told, and at last the candidate.

    Ending the iteration gives the work up. Raises ``PlanRefused``.
    """
    heard: asyncio.Queue[tuple[float, str] | None] = asyncio.Queue()
    work = asyncio.ensure_future(planner.candidate(wish, lambda share, words: heard.put_nowait((share, words))))
    work.add_done_callback(lambda _: heard.put_nowait(None))
    try:
        while (step := await heard.get()) is not None:
            yield step
        yield work.result()
    finally:
        work.cancel()
        await asyncio.gather(work, return_exceptions=True)


def _on_map(planned: PlannedMission, version: MapStamp) -> PlannedMission:
    """Write into a plan which map it was made on."""
    if not version.number:
        return planned
    document = {**planned.document, "map_version": version.as_json()}
    return replace(planned, document=document, sha256=mission_sha256(document))


def _fingerprint(found: Candidate) -> tuple[float, ...]:
    """Return what only plans of one path have in common."""
    return tuple(found.statistics[key] for key in ("length_m", "duration_s", "turns", "pivots", "covered_m2"))


def _refuse_if_far(robot: Robot, mission: Mission, document: Document) -> None:
    if robot.telemetry is None:
        return
    pose = robot.telemetry.pose
    corner = document["parcel"][0][0]
    away = metres((pose.lon_deg, pose.lat_deg), (corner[0], corner[1]))
    if away > FAR_M:
        text = f"{robot.name} is {away / 1000:.0f} km from {mission.field_name}. Choose a robot of that site."
        raise OrderRefused("wrong_site", text)
