"""Moves missions on by what their robots report."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections.abc import Callable

from hmi.domain.mission import (
    ON_ROBOT,
    BadMove,
    MissionChange,
    MissionStatus,
    Mover,
    OpenMission,
    reported_move,
)
from hmi.domain.mission_rest import Progress
from hmi.domain.robot import Order, OrderStatus, Robot, RobotState
from hmi.store.database import Database
from hmi.store.errors import NotFound, StoreError
from hmi.store.mission_revisions import MissionRevisions
from hmi.store.missions import Mission, Missions

RETRY_S = 5.0  # the database was away; the robot's next report is asked again
READ_BACK = "The robot has read the new version back."
log = logging.getLogger(__name__)
HORN = "start_horn"
OnMoved = Callable[[Mission, MissionChange], None]


class MissionTracking:
    """Follows the missions of one farm.

    ``see`` belongs on the event loop, costs a few comparisons and never waits; a task writes the moves.

    Args:
        on_moved: told of each move, on the event loop.
        revisions: documents that were sent and that a robot may report it has read back.
    """

    def __init__(
        self,
        missions: Missions,
        database: Database,
        farm_id: str,
        on_moved: OnMoved = lambda _mission, _change: None,
        revisions: MissionRevisions | None = None,
    ) -> None:
        self._missions, self._database, self._farm_id, self._on_moved = missions, database, farm_id, on_moved
        self._revisions = revisions
        self._reports: dict[str, tuple[RobotState, str]] = {}
        self._settled: dict[str, tuple[RobotState, int]] = {}
        self._by_robot: dict[str, list[Mission]] = {}
        self._acted: dict[str, float] = {}
        self._version = -1
        self._news = asyncio.Event()
        self._task: asyncio.Task[None] | None = None

    def start(self) -> None:
        """Begin to write moves."""
        self._task = asyncio.create_task(self._run(), name="mission-tracking")

    async def close(self) -> None:
        """End; a move being written is finished."""
        if self._task is not None:
            self._task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._task
            self._task = None

    def acted(self, mission_id: str, at_s: float) -> None:
        """Remember when a person's order for a mission was accepted: older reports do not count against it."""
        self._acted[mission_id] = at_s

    def see(self, robot: Robot) -> None:
        """Take note of what a registered robot reports; what it reported before it was known does not count."""
        state = robot.state
        if state is None or not robot.is_registered or robot.farm_id != self._farm_id:
            return
        known, version = self._settled.get(robot.id, (None, -1))
        if known is state and version == self._missions.version:
            return
        self._reports[robot.id] = (state, robot.name)
        self._news.set()

    async def settle(self) -> None:
        """Write every move that is due now; ``start`` does it by itself."""
        reports, self._reports = self._reports, {}
        try:
            while reports:
                robot_id, (state, name) = next(iter(reports.items()))
                version = self._missions.version
                for mission in self._concerned(robot_id, state.order):
                    await self._follow(mission, state, name)
                self._settled[robot_id] = (state, version)
                del reports[robot_id]
        finally:
            self._reports = {**reports, **self._reports}

    def _concerned(self, robot_id: str, order: Order | None) -> list[Mission]:
        if self._version != self._missions.version:
            self._version = self._missions.version
            self._by_robot = {}
            for mission in self._missions.all_known(self._farm_id):
                if mission.robot_id is not None:
                    self._by_robot.setdefault(mission.robot_id, []).append(mission)
        reported = None if order is None else order.mission_id
        return [m for m in self._by_robot.get(robot_id, ()) if m.status in ON_ROBOT or m.id == reported]

    async def _follow(self, mission: Mission, state: RobotState, robot_name: str) -> None:
        order = state.order
        mission = await self._read_back(mission, order, robot_name)
        if _is_about_to_move(mission, state):
            return  # it sounds its horn: resuming, not running
        open_mission = OpenMission(
            mission.id, mission.status, mission.robot_id, mission.sha256, self._acted.get(mission.id)
        )
        move = reported_move(open_mission, order, state.stamp.source_s)
        await self._keep(mission, order, is_urgent=move is not None)
        if move is None:
            return
        steps, why = move
        if steps[-1] is MissionStatus.PAUSED and state.hold is not None:
            why = state.hold.text
        try:
            for step in steps:
                moved, change = await self._database.run(
                    self._missions.move, self._farm_id, mission.id, step, Mover.ROBOT, robot_name, why
                )
                self._on_moved(moved, change)
        except (BadMove, NotFound) as error:
            # a person changed it meanwhile; the next report is judged against what it is now
            log.info("mission %s stays as it is: %s", mission.id, error)

    async def _read_back(self, mission: Mission, order: Order | None, robot_name: str) -> Mission:
        """Make a document that was only sent the mission's own when the robot says that it has it."""
        is_it = order is not None and order.mission_id == mission.id and order.sha256 == mission.pending_sha256
        if not is_it or self._revisions is None or order is None:
            return mission
        try:
            return await self._database.run(
                self._revisions.take, self._farm_id, mission.id, order.sha256, robot_name, READ_BACK
            )
        except NotFound:
            return mission

    async def _keep(self, mission: Mission, order: Order | None, *, is_urgent: bool) -> None:
        """Store how far it is, so that it can be taken up again whatever happens to robot and console."""
        if order is None or order.mission_id != mission.id or order.sha256 != mission.sha256:
            return
        if order.status in (OrderStatus.NONE, OrderStatus.LOADED):
            return
        progress = Progress.of(order).as_json()
        known = self._missions.known(mission.id)
        if known is not None and known.progress != progress:
            await self._database.run(self._missions.keep_progress, mission.id, progress, is_urgent=is_urgent)

    async def _run(self) -> None:
        while True:
            await self._news.wait()
            self._news.clear()
            try:
                await self.settle()
            except StoreError as error:
                log.warning("missions could not be moved on: %s", error)
                await asyncio.sleep(RETRY_S)
                self._news.set()


def _is_about_to_move(mission: Mission, state: RobotState) -> bool:
    """Say whether it has taken the order to go on and does not move yet."""
    is_held = state.hold is not None and state.hold.code == HORN
    waits = mission.status in (MissionStatus.PAUSED, MissionStatus.RESUMING)
    return is_held and waits and state.order is not None and state.order.sha256 == mission.sha256
