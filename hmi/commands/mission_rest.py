"""Going on with a mission: change the rest while it runs, resume it later from anywhere, or start it fresh.

A new document is planned, shown, sent, and becomes the mission's own only when the robot has read it back.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from hmi.commands.map_watch import MapWatch
from hmi.commands.mission_send import MissionSent
from hmi.commands.plan_wish import surroundings_of
from hmi.commands.refusal import HELD_BY_OTHER, UNKNOWN_ROBOT, OrderRefused
from hmi.commands.rest_sources import FreshSource, RestParts, RestSource
from hmi.commands.rest_words import drawn_on
from hmi.commands.service import TTL_MS, CommandRequest
from hmi.domain.command import Action, Outcome
from hmi.domain.ids import new_id
from hmi.domain.mission import ENDED, MissionStatus
from hmi.domain.mission_document import renamed
from hmi.domain.mission_plan import Geometry, MissionRefused
from hmi.domain.mission_rest import DrawnArea, Piece, PlannedRest, Progress, RestWish, pieces_of
from hmi.domain.robot import Mode, Order, OrderStatus, Robot
from hmi.domain.role import Permission
from hmi.security.authorization import is_allowed
from hmi.security.session_info import SessionInfo
from hmi.store.errors import NotFound
from hmi.store.features import Feature
from hmi.store.mission_drafts import refuse_draft
from hmi.store.missions import Mission

KEPT = 32  # previews that wait for their Send
MOVED = ("moved_while_paused", "return_home")
LEFT = (OrderStatus.PAUSED, OrderStatus.ABORTED, OrderStatus.FAILED)
CHANGE = "change"


@dataclass(frozen=True, slots=True)
class RestOrder:
    """What a person wants of the rest; see ``RestWish``.

    ``home_id`` is a map feature; ``areas`` are all that count from now on, ``None`` keeps those drawn before.
    """

    kind: str
    leave_out: tuple[int, ...] = ()
    areas: tuple[DrawnArea, ...] | None = None
    is_reversed: bool = False
    row_speed_mps: float | None = None
    end: str = "as_planned"
    home_id: str | None = None


@dataclass(frozen=True, slots=True)
class RestView:
    """How far a mission is and what is left; ``is_live``: the robot says so now, else it is what was stored."""

    mission: Mission
    progress: Progress | None
    pieces: Sequence[Piece]
    is_live: bool


class MissionRests:
    """Plans, shows and sends rests.

    Raises (every method): ``NotSignedIn``, ``NotAllowed``, ``NotFound``, ``StoreError`` and what it names itself.
    """

    def __init__(self, parts: RestParts) -> None:
        self._parts = parts
        self._run = parts.database.run
        self._map = MapWatch(parts.maps, parts.database)
        self._previews: OrderedDict[str, tuple[str, RestOrder, PlannedRest]] = OrderedDict()

    async def left(self, session: SessionInfo, mission_id: str) -> RestView:
        """Return how far a mission is and what is left to do."""
        self._parts.authorize(session, Permission.WATCH)
        mission = self._mission(session, mission_id)
        progress, is_live = self._progress(mission)
        if progress is None:
            return RestView(mission, None, (), False)
        document = await self._run(self._parts.missions.document, session.farm_id, mission_id)
        return RestView(mission, progress, pieces_of(document, progress), is_live)

    async def preview(self, session: SessionInfo, mission_id: str, order: RestOrder) -> PlannedRest:
        """Plan a rest without sending it; the plan is kept for ``send``.

        Raises:
            MissionRefused: it is not the time for it.
            PlanRefused: it cannot be planned.
        """
        mission = self._mission(session, mission_id)
        robot = self._robot(mission)
        self._may(session, robot, order.kind)
        wish = await self._wish(session, mission, robot, order)
        planned = await self._parts.planner.rest(wish)
        planned = replace(planned, difference={**planned.difference, "progress": wish.progress.as_json()})
        self._previews[planned.sha256] = (mission_id, order, planned)
        while len(self._previews) > KEPT:
            self._previews.popitem(last=False)
        return planned

    async def send(self, session: SessionInfo, mission_id: str, sha256: str, tick_id: str) -> MissionSent:
        """Send a rest that was shown; the robot says whether it still fits.

        Raises:
            MissionRefused: it was not shown, or it is not the time for it any more.
        """
        mission = self._mission(session, mission_id)
        robot = self._robot(mission)
        kept = self._previews.get(sha256)
        if kept is None or kept[0] != mission_id:
            raise MissionRefused("not_shown", "Look at the new rest first: it was planned too long ago.")
        _, order, planned = kept
        self._may(session, robot, order.kind)
        try:
            self._parts.gate.decided_now(tick_id)
            self._parts.gate.challenge(robot)
        except OrderRefused as refused:
            return MissionSent(Outcome.REJECTED, refused.code, refused.text)
        self._refuse_in_doubt(mission, robot)
        areas = _areas(mission, order)
        source = RestSource(self._parts, mission, order.kind, planned, self._map, areas)
        proof = None
        if self._is_driven(mission, robot):
            self._parts.authorize(session, Permission.START, robot.id)
            proof = partial(self._proof, session, robot.id, tick_id)
        sent = await self._parts.sender.put(session, robot.id, mission_id, source, proof)
        if sent.outcome is Outcome.ACCEPTED:
            self._previews.pop(sha256, None)
        return sent

    async def fresh(self, session: SessionInfo, mission_id: str, tick_id: str) -> MissionSent:
        """Send the whole mission again: what was done is forgotten. It moves nothing; a start does.

        Raises:
            MissionRefused: it runs.
        """
        mission = self._mission(session, mission_id)
        robot = self._robot(mission)
        self._parts.authorize(session, Permission.SEND_MISSION, robot.id)
        order = self._order_of(mission, robot)
        if order is not None and order.status is OrderStatus.RUNNING:
            raise MissionRefused("under_way", f"{mission.name} is running. Pause it first.")
        is_left = order is not None and order.status in (*LEFT, OrderStatus.DONE)
        if not is_left and mission.status not in ENDED and mission.status is not MissionStatus.PAUSED:
            raise MissionRefused("not_begun", f"{mission.name} has not begun. Start it.")
        self._may_touch(session, robot)
        if order is not None and order.status is OrderStatus.PAUSED:
            request = CommandRequest(robot.id, Action.ABORT, new_id(), tick_id, mission.id)
            ended = await self._parts.commands.submit(session, request)
            if not ended.is_accepted:
                return MissionSent(ended.outcome, ended.code, ended.text)
        source = FreshSource(self._parts, mission, self._map)
        return await self._parts.sender.put(session, robot.id, mission_id, source)

    # questions

    def _mission(self, session: SessionInfo, mission_id: str) -> Mission:
        mission = self._parts.missions.known(mission_id)
        if mission is None or mission.farm_id != session.farm_id:
            raise NotFound("There is no such mission.")
        refuse_draft(mission)
        return mission

    def _robot(self, mission: Mission) -> Robot:
        robot = self._parts.fleet.robot(mission.robot_id or "")
        if robot is None:
            raise MissionRefused("no_robot", f"{mission.name} was on no robot yet. Send it first.")
        return robot

    def _may(self, session: SessionInfo, robot: Robot, kind: str) -> None:
        """Ask for the rights: who has control may change the rest of what runs; a planner what nobody has in hand."""
        self._parts.authorize(session, Permission.SEND_MISSION, robot.id)
        self._may_touch(session, robot)
        if kind == CHANGE and self._parts.leases.holds(session.session_id, robot.id) is None:
            why = is_allowed(self._parts.authorize, session, Permission.EDIT_MISSION, robot.id)
            if why and not is_allowed(self._parts.authorize, session, Permission.LEASE, robot.id):
                raise MissionRefused("no_control", f"Take control of {robot.name} first, or let a planner change it.")
            self._parts.authorize(session, Permission.EDIT_MISSION, robot.id)

    def _may_touch(self, session: SessionInfo, robot: Robot) -> None:
        lease = self._parts.leases.of(robot.id)
        if lease is not None and self._parts.leases.holds(session.session_id, robot.id) is None:
            raise MissionRefused(HELD_BY_OTHER, f"{lease.holder.user_name} has control. Ask for it.")

    @staticmethod
    def _order_of(mission: Mission, robot: Robot) -> Order | None:
        order = robot.state.order if robot.state is not None else None
        return order if order is not None and order.mission_id == mission.id else None

    def _is_driven(self, mission: Mission, robot: Robot) -> bool:
        order = self._order_of(mission, robot)
        return order is not None and order.status is OrderStatus.RUNNING

    def _proof(self, session: SessionInfo, robot_id: str, tick_id: str) -> dict[str, Any]:
        """Return what lets a robot that drives take another path; raises ``OrderRefused``."""
        self._parts.gate.decided_now(tick_id)  # once more: storing the document may have waited for the disk
        robot = self._parts.fleet.robot(robot_id)
        if robot is None:
            raise OrderRefused(UNKNOWN_ROBOT, "There is no such robot.")
        challenge, lease = self._parts.gate.challenge(robot), self._parts.leases.control(session, robot)
        seq = self._parts.leases.next_seq(lease)
        return {"lease_token": lease.token, "lease_seq": seq, "challenge": challenge, "ttl_ms": TTL_MS}

    def _progress(self, mission: Mission) -> tuple[Progress | None, bool]:
        robot = self._parts.fleet.robot(mission.robot_id or "")
        order = self._order_of(mission, robot) if robot is not None else None
        if order is not None and order.sha256 == mission.sha256 and order.status is not OrderStatus.LOADED:
            return Progress.of(order), True
        stored = Progress.from_json(mission.progress)
        return (stored, False) if stored is not None and stored.sha256 == mission.sha256 else (None, False)

    def _refuse_in_doubt(self, mission: Mission, robot: Robot) -> None:
        """Refuse while it is not known whether the robot has what was sent before."""
        order = self._order_of(mission, robot)
        if mission.pending_sha256 and order is not None and order.sha256 != mission.sha256:
            text = "An update was sent and not confirmed. Wait until the robot says what it has."
            raise MissionRefused("in_doubt", text)

    async def _wish(self, session: SessionInfo, mission: Mission, robot: Robot, order: RestOrder) -> RestWish:
        progress, is_live = self._progress(mission)
        if progress is None:
            raise MissionRefused("no_progress", "How far it came is not known. Start it fresh.")
        is_running, stand = False, None
        if order.kind == CHANGE:
            is_running = self._check_change(mission, robot, is_live=is_live)
        else:
            stand = self._stand(mission, robot, progress)
        farm = session.farm_id
        base = await self._run(self._parts.missions.document, farm, mission.id)
        stamp = await self._map.now(farm)  # before the map itself: what is published in between is seen when it is sent
        features = await self._run(self._parts.features.all, farm)
        before = await self._map.features_of(farm, mission.planned_on(base)) if is_running else None
        parcel, sheet = {"type": "Polygon", "coordinates": base["parcel"]}, robot.factsheet
        home = next((f.geometry["coordinates"] for f in features if f.id == order.home_id and f.kind == "home"), None)
        return RestWish(
            base=renamed(base, name=mission.name),
            base_sha256=mission.sha256,
            revision=await self._run(self._parts.revisions.next_revision, mission.id),
            progress=progress,
            is_running=is_running,
            stand=stand,
            leave_out=order.leave_out,
            areas=_areas(mission, order),
            is_reversed=order.is_reversed,
            row_speed_mps=order.row_speed_mps,
            end=order.end,
            home=None if home is None else (float(home[0]), float(home[1])),
            field_now=_field_now(features, mission),
            surroundings=surroundings_of(features, parcel, mission.field_id, sheet),
            around_before=None if before is None else surroundings_of(before, parcel, mission.field_id, sheet),
            robot=sheet,
            map_version=stamp.as_json() if stamp.number else None,
            lead_m=_leads(mission),
        )

    def _check_change(self, mission: Mission, robot: Robot, *, is_live: bool) -> bool:
        """Return whether it runs now."""
        order = self._order_of(mission, robot)
        if order is None or not is_live or order.status not in (OrderStatus.RUNNING, OrderStatus.PAUSED):
            raise MissionRefused(
                "not_under_way", f"{mission.name} is not under way. Resume it later, or plan it again."
            )
        if order.status is OrderStatus.PAUSED and _was_moved(robot):
            raise MissionRefused("moved", f"{robot.name} was moved since the pause. Resume later brings it back first.")
        return order.status is OrderStatus.RUNNING

    def _stand(self, mission: Mission, robot: Robot, progress: Progress) -> tuple[float, float, float]:
        """Return where the robot stands, if a mission can be taken up again from there."""
        order = self._order_of(mission, robot)
        # the robot's word is newer than the stored state, which follows it a moment later
        is_left = order is not None and order.status in LEFT
        if not is_left and mission.status not in ENDED and mission.status is not MissionStatus.PAUSED:
            raise MissionRefused("not_interrupted", f"{mission.name} was not interrupted.")
        if mission.status is MissionStatus.DONE or not progress.is_begun:
            raise MissionRefused("nothing_left", "There is no interrupted work. Start it fresh.")
        try:
            self._parts.gate.challenge(robot)
            safety = self._parts.gate.safety(robot)
        except OrderRefused as refused:
            raise MissionRefused(refused.code, refused.text) from refused
        is_at_work = robot.state is not None and robot.state.mode in (Mode.AUTO, Mode.MANUAL)
        if is_at_work or not safety.standstill:
            raise MissionRefused("not_standing", f"{robot.name} must stand still first.")
        if robot.telemetry is None:
            raise MissionRefused("no_place", f"Where {robot.name} stands is not known.")
        pose = robot.telemetry.pose
        return pose.lon_deg, pose.lat_deg, pose.theta_rad


def _field_now(features: Sequence[Feature], mission: Mission) -> Geometry | None:
    """Return the mission's field as the map has it, ``None`` for a mission of no field of the map."""
    if mission.field_id is None:
        return None
    known = next((one for one in features if one.id == mission.field_id), None)
    if known is None or known.geometry["type"] not in ("Polygon", "MultiPolygon"):
        text = f"{mission.field_name} is no field on the map any more. Plan a new mission for what is left."
        raise MissionRefused("field_gone", text)
    return known.geometry


def _areas(mission: Mission, order: RestOrder) -> tuple[DrawnArea, ...]:
    """Return what was drawn: an obstacle stands there also for whoever takes the mission up again."""
    return drawn_on(mission) if order.areas is None or order.kind != CHANGE else order.areas


def _was_moved(robot: Robot) -> bool:
    return robot.state is not None and robot.state.hold is not None and robot.state.hold.code in MOVED


def _leads(mission: Mission) -> tuple[float, float] | None:
    leads = (mission.statistics.get("treatment") or {}).get("lead_m")
    return (float(leads[0]), float(leads[1])) if leads else None
