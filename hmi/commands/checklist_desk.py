"""The pre-start checklist: shown, ticked, recorded with who and when."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import timedelta

from hmi.clock import Clock
from hmi.commands.audit_line import audit_line
from hmi.commands.ports import AuditSink, FleetReader
from hmi.domain.checklist import Item, items_of
from hmi.domain.ids import new_id
from hmi.domain.mission_plan import MissionRefused
from hmi.domain.robot import Family, Robot
from hmi.domain.role import Permission
from hmi.security.authorization import Authorize
from hmi.security.session_info import SessionInfo
from hmi.store.checklists import Checklist, Checklists
from hmi.store.database import Database
from hmi.store.errors import NotFound
from hmi.store.missions import Missions


@dataclass(frozen=True, slots=True)
class ChecklistView:
    """The list of a robot and this person's record of it that still counts."""

    items: Sequence[Item]
    is_required: bool
    valid_hours: float
    record: Checklist | None


class ChecklistDesk:
    """Shows and records lists.

    Args:
        valid_hours: how long a ticked list counts, for the person who ticked it.
    """

    def __init__(
        self,
        checklists: Checklists,
        missions: Missions,
        database: Database,
        fleet: FleetReader,
        audit: AuditSink,
        authorize: Authorize,
        clock: Clock,
        *,
        is_required: bool,
        valid_hours: float,
    ) -> None:
        self._checklists, self._missions, self._database, self._fleet = checklists, missions, database, fleet
        self._audit, self._authorize, self._clock = audit, authorize, clock
        self.is_required, self._valid_hours = is_required, valid_hours

    def view(self, session: SessionInfo, robot_id: str) -> ChecklistView:
        """Return the list of a robot; raises ``NotFound``, ``NotAllowed``."""
        self._authorize(session, Permission.WATCH)
        robot = self._robot(session, robot_id)
        record = self._checklists.newest(session.farm_id, robot_id, session.user_id)
        return ChecklistView(items_of(_family(robot)), self.is_required, self._valid_hours, record)

    async def tick(self, session: SessionInfo, robot_id: str, ticked: Sequence[str]) -> Checklist:
        """Record that this person ticked the whole list.

        Raises:
            MissionRefused: a line is missing, or is not of this list.
            NotFound, NotAllowed, NotSignedIn, StoreError.
        """
        robot = self._robot(session, robot_id)
        self._authorize(session, Permission.START, robot_id)
        family = _family(robot)
        missing = [one.text for one in items_of(family) if one.id not in ticked]
        if missing:
            raise MissionRefused("not_ticked", f"Not ticked: {missing[0]}.", "ticked")
        if set(ticked) - {one.id for one in items_of(family)}:
            raise MissionRefused("other_list", "The list has changed. Look at it again.", "ticked")
        now = self._clock.utc()
        record = Checklist(
            new_id(),
            session.farm_id,
            robot_id,
            family.value,
            session.user_id,
            session.user_name,
            session.device_name,
            tuple(ticked),
            now,
            now + timedelta(hours=self._valid_hours),
        )
        await self._database.run(self._checklists.add, record)
        await self._note(session, robot, record)
        return record

    async def _note(self, session: SessionInfo, robot: Robot, record: Checklist) -> None:
        texts = [one.text for one in items_of(_family(robot))]
        text = f"{robot.name}: {len(texts)} checks ticked."
        data = {"ticked": list(record.ticked), "valid_until": record.valid_until.isoformat()}
        self._audit.append(
            audit_line(session, "checklist", "ticked", text, ref=record.id, robot_id=robot.id, data=data)
        )
        order = robot.state.order if robot.state is not None else None
        mission = self._missions.known(order.mission_id) if order is not None else None
        if mission is not None and mission.farm_id == session.farm_id:
            why = "Checked before the start: " + "; ".join(texts) + "."
            await self._database.run(self._missions.note, mission.farm_id, mission.id, session.user_name, why)

    def _robot(self, session: SessionInfo, robot_id: str) -> Robot:
        robot = self._fleet.robot(robot_id)
        if robot is None or robot.farm_id != session.farm_id:
            raise NotFound(f"There is no robot {robot_id}.")
        return robot


def _family(robot: Robot) -> Family:
    return robot.factsheet.family if robot.factsheet is not None else Family.OTHER
