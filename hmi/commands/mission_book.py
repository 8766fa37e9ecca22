"""The farm's missions for screens and programs: list, plan, copy, rename, delete, and hand over for sending."""

from __future__ import annotations

import logging
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from hmi.clock import Clock
from hmi.commands.ports import AuditSink, FleetReader, StoredMission
from hmi.commands.refusal import OrderRefused
from hmi.domain.ids import new_id
from hmi.domain.mission import UNDER_WAY, BadMove, MissionStatus, Mover
from hmi.domain.mission_document import Document, for_robot, mission_sha256, renamed
from hmi.domain.mission_plan import PlannedMission, Planner, PlanWish, Surroundings
from hmi.domain.robot import Robot
from hmi.domain.role import Permission
from hmi.security.authorization import Authorize
from hmi.security.session_info import SessionInfo
from hmi.store.audit_chain import AuditEntry
from hmi.store.database import Database
from hmi.store.features import Feature, Features
from hmi.store.missions import Mission, MissionLogEntry, Missions

NEAR_HOME_M = 2000.0  # a home further away belongs to another site
FAR_M = 3000.0  # a robot this far from a field is at another site: sending must be a mistake
EARTH_M = 6_371_000.0
log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class PlanOrder:
    """What a person asks to be planned.

    Args:
        row_bearing_deg: clockwise from north; ``None`` follows the field's crop rows, or searches the best.
        headland_passes: ``None`` takes as many as turning needs.
        home_id: map feature where the robot stands; ``None`` takes its own or the nearest.
    """

    field_id: str
    robot_id: str
    width_m: float
    name: str = ""
    row_bearing_deg: float | None = None
    headland_passes: int | None = None
    home_id: str | None = None
    returns_home: bool = True
    is_supervised: bool = True


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


class MissionBook:
    """Answers everything about stored missions; each method asks the person's rights first.

    Raises (every method with a session): ``NotSignedIn``, ``NotAllowed``, ``StoreError`` and what it names itself.
    Also the ``MissionSource`` of the sending service.
    """

    def __init__(self, parts: MissionParts) -> None:
        self._parts = parts
        self._missions, self._database = parts.missions, parts.database

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
        """Return a mission's wire document; raises ``NotFound``."""
        self._parts.authorize(session, Permission.WATCH)
        return await self._database.run(self._missions.document, session.farm_id, mission_id)

    async def features(self, session: SessionInfo, kinds: Sequence[str] = ()) -> Sequence[Feature]:
        """Return the farm's map."""
        self._parts.authorize(session, Permission.WATCH)
        return await self._database.run(self._parts.features.all, session.farm_id, kinds)

    async def preview(self, session: SessionInfo, order: PlanOrder) -> PlannedMission:
        """Plan without storing; raises ``PlanRefused`` and ``NotFound`` (field or home)."""
        self._parts.authorize(session, Permission.EDIT_MISSION, order.robot_id)
        return await self._parts.planner.plan(await self._wish(session, order, "preview"))

    async def plan(self, session: SessionInfo, order: PlanOrder) -> Mission:
        """Plan and store a mission; raises as ``preview``."""
        self._parts.authorize(session, Permission.EDIT_MISSION, order.robot_id)
        mission_id = f"m-{new_id()[:12]}"
        wish = await self._wish(session, order, mission_id)
        planned = await self._parts.planner.plan(wish)
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
        )
        stored = await self._database.run(self._missions.add, mission, planned.document, "Planned.")
        self._audit(session, stored, "planned", {"width_m": order.width_m, "field_id": order.field_id})
        return stored

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

    async def stored(self, farm_id: str, mission_id: str, robot_id: str) -> StoredMission | None:
        """Return a mission as it goes to this robot, ``None`` if there is none.

        Raises:
            OrderRefused: another robot works on it, or the robot is at another site.
        """
        mission = self._missions.known(mission_id)
        if mission is None or mission.farm_id != farm_id:
            return None
        if mission.status in UNDER_WAY and mission.robot_id != robot_id:
            text = f"{mission.name} is {mission.status.value} on {mission.robot_id}. Copy it for another robot."
            raise OrderRefused("in_use", text)
        document = for_robot(await self._database.run(self._missions.document, farm_id, mission_id), robot_id)
        robot = self._parts.fleet.robot(robot_id)
        if robot is not None:
            _refuse_if_far(robot, mission, document)
        return StoredMission(mission_id, mission.name, document, mission_sha256(document))

    async def sent(self, farm_id: str, mission_id: str, robot_id: str, by: str) -> None:
        """Note that the robot holds this mission now."""
        await self._database.run(self._sent, farm_id, mission_id, robot_id, by)

    def _sent(self, farm_id: str, mission_id: str, robot_id: str, by: str) -> None:
        why = f"Sent to {robot_id}, read back whole."
        known = self._missions.known(mission_id)
        if known is not None and known.robot_id == robot_id and known.status is MissionStatus.ACCEPTED:
            # the robot's report was faster than its answer to the sending
            self._missions.note(farm_id, mission_id, by, why)
            return
        # a queued mission is moved on by the console, whoever sent it: it stays in its queue
        is_queued = known is not None and known.status in (MissionStatus.QUEUED, MissionStatus.WAITING)
        mover = Mover.CONSOLE if is_queued else Mover.PERSON
        try:
            self._missions.move(farm_id, mission_id, MissionStatus.SENT, mover, by, why, robot_id=robot_id)
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
            MissionRefused: a robot holds it or a queue waits for it.
        """
        self._parts.authorize(session, Permission.EDIT_MISSION, robot_id)
        stored = await self._database.run(
            self._missions.adjust,
            session.farm_id,
            mission_id,
            session.user_name,
            is_supervised=is_supervised,
            robot_id=robot_id,
        )
        self._audit(session, stored, "changed", {"is_supervised": is_supervised, "robot_id": robot_id})
        return stored

    def _copy(self, farm_id: str, by: str, mission_id: str, name: str) -> Mission:
        document = self._missions.document(farm_id, mission_id)
        known = self._missions.known(mission_id)
        assert known is not None  # the document was there
        copy_id, name = f"m-{new_id()[:12]}", name or f"{known.name[:73]}, copy"
        copy = replace(known, id=copy_id, name=name, status=MissionStatus.VALIDATED, created_by=by)
        return self._missions.add(copy, renamed(document, mission_id=copy_id, name=name), f"Copy of {known.name}.")

    async def _wish(self, session: SessionInfo, order: PlanOrder, mission_id: str) -> PlanWish:
        features = await self._database.run(self._parts.features.all, session.farm_id)
        field = await self._database.run(self._parts.features.get, session.farm_id, order.field_id)
        place = _places(field.geometry)[0]
        home = _home(features, order, place)
        robot = self._parts.fleet.robot(order.robot_id)
        sheet = None if robot is None else robot.factsheet
        origin = (sheet.datum_lon_deg, sheet.datum_lat_deg) if sheet else home or place
        return PlanWish(
            mission_id=mission_id,
            name=order.name or f"{field.title[:60]}, {order.width_m:g} m",
            robot_id=order.robot_id,
            field_name=field.title,
            parcel=field.geometry,
            width_m=order.width_m,
            datum_lat_deg=round(origin[1], 7),
            datum_lon_deg=round(origin[0], 7),
            robot=sheet,
            angle_rad=_row_angle(order, field),
            headland_passes=order.headland_passes,
            home=home,
            returns_home=order.returns_home,
            surroundings=_surroundings(features, field),
        )

    def _audit(self, session: SessionInfo, mission: Mission, outcome: str, data: dict[str, Any]) -> None:
        self._parts.audit.append(
            AuditEntry(
                farm_id=session.farm_id,
                actor=session.user_name,
                device=session.device_name,
                kind="mission",
                outcome=outcome,
                robot_id=mission.robot_id,
                ref=mission.id,
                text=f"{mission.name} {outcome}.",
                data=data,
            )
        )


def _row_angle(order: PlanOrder, field: Feature) -> float | None:
    """Return the ENU angle of the rows: as asked, else along the crop rows of the map, else to be searched."""
    bearing = order.row_bearing_deg if order.row_bearing_deg is not None else field.properties.get("row_bearing_deg")
    return None if bearing is None else math.pi / 2 - math.radians(float(bearing))


def _home(features: Sequence[Feature], order: PlanOrder, place: tuple[float, float]) -> tuple[float, float] | None:
    homes = {one.id: one for one in features if one.kind == "home"}
    if order.home_id is not None and order.home_id in homes:
        return _places(homes[order.home_id].geometry)[0]
    near = [one for one in homes.values() if _metres(_places(one.geometry)[0], place) < NEAR_HOME_M]
    own = [one for one in near if one.properties.get("robot") == order.robot_id]
    best = min(own or near, key=lambda one: _metres(_places(one.geometry)[0], place), default=None)
    return None if best is None else _places(best.geometry)[0]


def _surroundings(features: Sequence[Feature], field: Feature) -> Surroundings:
    """Return what is near the field; a farm may have sites on other continents."""
    place = _places(field.geometry)[0]
    near = [one for one in features if one.id != field.id and _metres(_places(one.geometry)[0], place) < FAR_M]
    solid = [one for one in near if one.kind in ("obstacle", "building", "no-go", "no_go", "hole")]
    roads = [one for one in near if one.kind in ("road", "yard")]
    return Surroundings(
        tuple((one.geometry, _width(one)) for one in solid), tuple((one.geometry, _width(one)) for one in roads)
    )


def _width(feature: Feature) -> float:
    """Return how wide a line is, or a point across."""
    radius = feature.properties.get("radius_m")
    return float(feature.properties.get("width_m", 4.0)) if radius is None else 2 * float(radius)


def _places(geometry: dict[str, Any]) -> list[tuple[float, float]]:
    """Return the positions of any GeoJSON geometry, longitude and latitude."""
    found: list[tuple[float, float]] = []
    waiting = [geometry["coordinates"]]
    while waiting:
        one = waiting.pop(0)
        if one and isinstance(one[0], int | float):
            found.append((float(one[0]), float(one[1])))
        else:
            waiting = [*one, *waiting]
    return found


def _metres(a: tuple[float, float], b: tuple[float, float]) -> float:
    """Return the distance of two places, longitude and latitude, on a round earth."""
    lon_a, lat_a, lon_b, lat_b = map(math.radians, (*a, *b))
    half = math.sin((lat_b - lat_a) / 2) ** 2 + math.cos(lat_a) * math.cos(lat_b) * math.sin((lon_b - lon_a) / 2) ** 2
    return 2 * EARTH_M * math.asin(min(1.0, math.sqrt(half)))


def _refuse_if_far(robot: Robot, mission: Mission, document: Document) -> None:
    if robot.telemetry is None:
        return
    pose = robot.telemetry.pose
    corner = document["parcel"][0][0]
    away = _metres((pose.lon_deg, pose.lat_deg), (corner[0], corner[1]))
    if away > FAR_M:
        text = f"{robot.name} is {away / 1000:.0f} km from {mission.field_name}. Choose a robot of that site."
        raise OrderRefused("wrong_site", text)
