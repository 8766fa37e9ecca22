"""Before a mission moves: the robot has read back what is stored, and a person has ticked the list."""

from __future__ import annotations

from collections.abc import Callable

from hmi.commands.plan_wish import is_flying
from hmi.commands.refusal import CHECKLIST_MISSING, IN_FLIGHT_PATH, NOT_NOW, NOT_READ_BACK, OrderRefused
from hmi.domain.robot import Order, Robot
from hmi.security.session_info import SessionInfo
from hmi.store.checklists import Checklists
from hmi.store.missions import Missions

TAKEN_UP = "continued"
"""The hold of a robot that waits before the way back: resuming then is as much of a start as a start."""


class MissionStartRules:
    """Answers from memory; a ``StartRules``.

    Args:
        needs_list: whether the farm wants the list ticked before a supervised start.
        may_run_alone: whether an administrator lets a robot run without a person.
        in_flight: what stands in the path of a mission that is flown, empty if nothing does, ``None`` if not known yet.
    """

    def __init__(
        self,
        missions: Missions,
        checklists: Checklists,
        needs_list: Callable[[], bool],
        may_run_alone: Callable[[str], bool],
        in_flight: Callable[[str], str | None] = lambda _mission_id: "",
    ) -> None:
        self._missions, self._checklists, self._needs_list = missions, checklists, needs_list
        self._may_run_alone, self._in_flight = may_run_alone, in_flight

    def is_supervised(self, robot: Robot, order: Order) -> bool:
        """Say whether somebody has to look on: yes, unless mission and robot are both marked otherwise."""
        mission = self._missions.known(order.mission_id)
        if mission is None or mission.farm_id != robot.farm_id:
            return True
        return mission.is_supervised or not self._may_run_alone(robot.id)

    def check(self, actor: SessionInfo, robot: Robot, order: Order, checklist_id: str | None) -> None:
        """Return if this person may start or resume what the robot says it has.

        Raises:
            OrderRefused: the document is not the stored one, something stands in the path of what flies, or the
                checklist is missing.
        """
        self.check_flight(robot, order)
        mission = self._missions.known(order.mission_id)
        if mission is not None and mission.farm_id == robot.farm_id and order.sha256 != mission.sha256:
            text = f"{robot.name} has not read back {mission.name} as it is stored here. Send it again."
            raise OrderRefused(NOT_READ_BACK, text)
        if not (self.is_supervised(robot, order) and self._needs_list() and is_a_start(robot)):
            return
        if not self._checklists.is_valid(actor.farm_id, robot.id, actor.user_id, checklist_id):
            raise OrderRefused(CHECKLIST_MISSING, "Tick the list first: Before it starts.")

    def check_flight(self, robot: Robot, order: Order) -> None:
        """Return if nothing on the map stands in the path of what flies; asked of a queue, too.

        Raises:
            OrderRefused: something does, or it is not known yet.
        """
        mission = self._missions.known(order.mission_id)
        if mission is None or mission.farm_id != robot.farm_id or not is_flying(robot.factsheet):
            return
        text = self._in_flight(order.mission_id)
        if text is None:
            raise OrderRefused(NOT_NOW, "What stands in its path is being looked up. Try again in a moment.")
        if text:
            raise OrderRefused(IN_FLIGHT_PATH, text)


def is_a_start(robot: Robot) -> bool:
    """Say whether what comes next is a start, not going on after a pause."""
    state = robot.state
    if state is None or state.order is None:
        return True
    is_paused = state.order.status.value == "paused"
    return not is_paused or (state.hold is not None and state.hold.code == TAKEN_UP)
