"""What a person's accepted order means for a mission: the log says who, when and why, before the robot reports."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable

from hmi.clock import Clock
from hmi.commands.ledger import CommandResult, Ticket
from hmi.commands.ports import FleetReader
from hmi.domain.command import Action, Outcome
from hmi.domain.mission import BadMove, MissionChange, MissionStatus, Mover
from hmi.domain.robot import OrderStatus
from hmi.store.database import Database
from hmi.store.errors import NotFound, StoreError
from hmi.store.missions import Mission, Missions

WORDS = {
    Action.START: "Started. The horn sounds first.",
    Action.RESUME: "Continued. The horn sounds first.",
    Action.PAUSE: "Paused from the screen.",
    Action.ABORT: "Ended early from the screen.",
    Action.RETURN_HOME: "Sent home; the mission waits.",
}
log = logging.getLogger(__name__)


class MissionActs:
    """Writes accepted orders into the log of the mission they were for.

    Args:
        acted: told at once which mission was acted on and when, on the console's monotonic clock.
        on_moved: told of each move, on the event loop.
    """

    def __init__(
        self,
        missions: Missions,
        database: Database,
        fleet: FleetReader,
        clock: Clock,
        acted: Callable[[str, float], None],
        on_moved: Callable[[Mission, MissionChange], None],
    ) -> None:
        self._missions, self._database, self._fleet, self._clock = missions, database, fleet, clock
        self._acted, self._on_moved = acted, on_moved
        self._tasks: set[asyncio.Task[None]] = set()

    def settled(self, ticket: Ticket, result: CommandResult) -> None:
        """Take a result from the ledger; on the event loop, never waits."""
        if ticket.kind != "command" or result.outcome is not Outcome.ACCEPTED or ticket.what not in set(WORDS):
            return
        mission = self._mission_on(ticket.robot_id)
        if mission is None or mission.farm_id != ticket.actor.farm_id:
            return
        self._acted(mission.id, self._clock.mono_s())
        action, by = Action(ticket.what), ticket.actor.user_name
        task = asyncio.get_running_loop().create_task(self._write(mission, action, by), name="mission act")
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def close(self) -> None:
        """Finish what is being written."""
        await asyncio.gather(*self._tasks, return_exceptions=True)

    def _mission_on(self, robot_id: str) -> Mission | None:
        robot = self._fleet.robot(robot_id)
        order = robot.state.order if robot is not None and robot.state is not None else None
        if order is None or order.status is OrderStatus.NONE:
            return None
        return self._missions.known(order.mission_id)

    async def _write(self, mission: Mission, action: Action, by: str) -> None:
        try:
            if action is Action.RESUME:
                try:
                    moved, change = await self._database.run(
                        self._missions.move,
                        mission.farm_id,
                        mission.id,
                        MissionStatus.RESUMING,
                        Mover.PERSON,
                        by,
                        WORDS[action],
                    )
                    self._on_moved(moved, change)
                    return
                except BadMove:
                    pass  # the robot's report was faster than its answer: it runs already
            await self._database.run(self._missions.note, mission.farm_id, mission.id, by, WORDS[action])
        except (NotFound, StoreError) as error:
            log.warning("who did what to mission %s was not logged: %s", mission.id, error)
