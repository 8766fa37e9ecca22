"""The registry: robots that an administrator accepted. Address and token come from here alone, never from the wire."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from datetime import datetime

from sqlalchemy import select

from hmi.clock import Clock
from hmi.domain.robot import Family
from hmi.store.database import Database
from hmi.store.errors import AlreadyExists, NotFound
from hmi.store.stop_list import StopList
from hmi.store.tables import RobotRow


@dataclass(frozen=True, slots=True)
class RegisteredRobot:
    """What the registry keeps of one robot; limits in SI."""

    id: str
    farm_id: str
    name: str
    family: Family
    added_by: str
    added_at: datetime
    http_url: str | None = None
    http_token: str | None = field(default=None, repr=False)
    contact_name: str | None = None
    contact_phone: str | None = None
    ack_limit_s: float = 1.0
    standstill_limit_s: float = 3.0
    decel_mps2: float = 1.0
    keep_out_m: float = 15.0
    is_unattended_allowed: bool = False


_COLUMNS = (
    "id", "farm_id", "name", "added_by", "added_at", "http_url", "http_token", "contact_name", "contact_phone",
    "ack_limit_s", "standstill_limit_s", "decel_mps2", "keep_out_m", "is_unattended_allowed",
)  # fmt: skip


class Robots:
    """The registered robots of one farm, in memory and on disk.

    ``get`` and ``all`` answer from memory and may be called on the event loop; everything else blocks and goes through
    ``Database.run``. ``on_changed`` callbacks run in the thread that made the change.
    """

    def __init__(self, database: Database, farm_id: str, clock: Clock, stop_list: StopList) -> None:
        self._database = database
        self._farm_id = farm_id
        self._clock = clock
        self._stop_list = stop_list
        self._known: dict[str, RegisteredRobot] = {}
        self._elsewhere: dict[str, RegisteredRobot] = {}
        self._changing = threading.Lock()
        self._listeners: list[Callable[[], None]] = []

    def get(self, robot_id: str) -> RegisteredRobot | None:
        """Return a registered robot of this farm, from memory."""
        return self._known.get(robot_id)

    def may_run_alone(self, robot_id: str) -> bool:
        """Say whether an administrator lets this robot run without a person, from memory."""
        known = self._known.get(robot_id)
        return known is not None and known.is_unattended_allowed

    def of_any_farm(self, robot_id: str) -> RegisteredRobot | None:
        """Return a registered robot of this or another farm, from memory; for deciding on rights only."""
        return self._known.get(robot_id) or self._elsewhere.get(robot_id)

    def all(self) -> list[RegisteredRobot]:
        """Return the registered robots by name, from memory."""
        return sorted(self._known.values(), key=lambda robot: (robot.name, robot.id))

    def on_changed(self, callback: Callable[[], None]) -> None:
        """Call ``callback`` after each change of the registry."""
        self._listeners.append(callback)

    def load(self) -> None:
        """Read the registry and write the STOP gateway's list; at start, or after another console changed it."""
        with self._changing, self._database.read() as session:
            every = [_registered(row) for row in session.scalars(select(RobotRow).filter_by(removed_at=None))]
            self._known = {robot.id: robot for robot in every if robot.farm_id == self._farm_id}
            self._elsewhere = {robot.id: robot for robot in every if robot.farm_id != self._farm_id}
        self._tell()

    def add(self, robot: RegisteredRobot) -> RegisteredRobot:
        """Register a robot; one that was removed before is taken back in.

        Raises:
            AlreadyExists: the id is in use, here or on another farm.
            StopListNotWritten: registered, but the STOP gateway does not know yet.
        """
        robot = replace(robot, farm_id=self._farm_id, added_at=self._clock.utc())
        with self._changing:
            with self._database.write() as session:
                row = session.get(RobotRow, robot.id)
                if row is not None and (row.removed_at is None or row.farm_id != self._farm_id):
                    raise AlreadyExists(f"a robot {robot.id!r} is already registered")
                if row is None:
                    row = RobotRow(id=robot.id)
                    session.add(row)
                _fill(row, robot)
            self._known = {**self._known, robot.id: robot}
        self._tell()
        return robot

    def change(self, robot: RegisteredRobot) -> RegisteredRobot:
        """Replace what is kept of a robot; use ``dataclasses.replace`` on what ``get`` gave.

        Raises:
            NotFound: it is not registered here.
            StopListNotWritten: changed, but the STOP gateway does not know yet.
        """
        with self._changing:
            with self._database.write() as session:
                row = session.get(RobotRow, robot.id)
                if row is None or row.removed_at is not None or row.farm_id != self._farm_id:
                    raise NotFound(f"there is no robot {robot.id!r}")
                robot = replace(robot, farm_id=self._farm_id, added_by=row.added_by, added_at=row.added_at)
                _fill(row, robot)
            self._known = {**self._known, robot.id: robot}
        self._tell()
        return robot

    def remove(self, robot_id: str) -> None:
        """Take a robot out; its records stay.

        Raises:
            NotFound: it is not registered here.
            StopListNotWritten: removed, but the STOP gateway does not know yet.
        """
        with self._changing:
            with self._database.write() as session:
                row = session.get(RobotRow, robot_id)
                if row is None or row.removed_at is not None or row.farm_id != self._farm_id:
                    raise NotFound(f"there is no robot {robot_id!r}")
                row.removed_at = self._clock.utc()
            self._known = {key: robot for key, robot in self._known.items() if key != robot_id}
        self._tell()

    def _tell(self) -> None:
        try:
            self._stop_list.export()
        finally:
            for listener in tuple(self._listeners):
                listener()


def _fill(row: RobotRow, robot: RegisteredRobot) -> None:
    for column in _COLUMNS:
        setattr(row, column, getattr(robot, column))
    row.family = robot.family.value
    row.removed_at = None


def _registered(row: RobotRow) -> RegisteredRobot:
    return RegisteredRobot(family=Family(row.family), **{column: getattr(row, column) for column in _COLUMNS})
