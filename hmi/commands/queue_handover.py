"""What lies unstarted on a robot and may be replaced: what the queue itself sent, else what a person gives up.

A mission that a person sent and nobody started gives way to the queue because a person says so. Nothing goes to the
robot for it. The edge contract has no message that empties a robot, and needs none: a mission that was never started
is replaced by the next one that is sent, and a start names mission and hash, so that nothing old can begin in between.
A message of its own would be one more order that robots must know, and would leave them without a mission while the
queue waits for daylight. So the queue is only allowed to send its own mission over this one.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from hmi.clock import Clock
from hmi.commands.audit_line import audit_line
from hmi.commands.ports import AuditSink, FleetReader
from hmi.commands.refusal import UNKNOWN_ROBOT, OrderRefused
from hmi.domain.robot import Order, OrderStatus, Robot
from hmi.domain.role import Permission
from hmi.security.authorization import Authorize
from hmi.security.session_info import SessionInfo
from hmi.store.database import Database
from hmi.store.missions import Mission, Missions
from hmi.store.queue import QueueStore


@dataclass(frozen=True, slots=True)
class HandoverParts:
    """What it is wired to.

    Args:
        on_changed: told of the robot and who did it: what was armed before it is disarmed.
    """

    store: QueueStore
    missions: Missions
    fleet: FleetReader
    database: Database
    audit: AuditSink
    authorize: Authorize
    on_changed: Callable[[str, str], None]
    clock: Clock


class QueueHandover:
    """Remembers which missions may be replaced; forgets it at a restart, when a person is asked again.

    That a mission stands or stood in a queue says nothing: a person may have sent it all the same, and is on the way.
    """

    def __init__(self, parts: HandoverParts) -> None:
        self._parts = parts
        self._replaceable: dict[str, str] = {}  # robot: hash
        self._sent_s: dict[str, float] = {}  # robot: when a person's mission was taken

    def may_replace(self, robot_id: str, sha256: str) -> bool:
        """Say whether the queue may send its next mission over the one with this hash; from memory."""
        return bool(sha256) and self._replaceable.get(robot_id) == sha256

    def sent(self, robot_id: str) -> None:
        """Forget it: a robot took a mission again, and what was sent last is wanted."""
        self._replaceable.pop(robot_id, None)
        self._sent_s[robot_id] = self._parts.clock.mono_s()

    def sent_s(self, robot_id: str) -> float:
        """Return when a robot last took a mission from a person, on the monotonic clock; long ago if it never did."""
        return self._sent_s.get(robot_id, -math.inf)

    def sent_by_queue(self, robot_id: str, sha256: str) -> None:
        """Note what the queue itself has just sent, after ``sent``."""
        self._replaceable[robot_id] = sha256
        self._sent_s.pop(robot_id, None)

    async def take_off(self, session: SessionInfo, robot_id: str, mission_id: str) -> str:
        """Let the queue replace a mission that a person sent and nobody started; returns what comes now.

        Raises:
            NotSignedIn, NotAllowed: as for sending a mission.
            OrderRefused: the robot does not hold it any more, it was started, or no queue waits for the robot.
        """
        parts = self._parts
        parts.authorize(session, Permission.SEND_MISSION, robot_id)
        robot = parts.fleet.robot(robot_id)
        if robot is None or robot.farm_id != session.farm_id:
            raise OrderRefused(UNKNOWN_ROBOT, "There is no such robot.")
        held = held_unstarted(robot)
        if held is None or held.mission_id != mission_id:
            raise OrderRefused("not_held", f"{robot.name} does not hold it, or it was started. Look again.")
        if not parts.store.entries(robot_id):
            raise OrderRefused("nothing_waits", f"Nothing waits in the queue of {robot.name}: it can stay there.")
        mission = parts.missions.known(mission_id)
        name = mission_id if mission is None else mission.name
        if mission is not None:
            why = f"Taken off {robot.name}: the queue may send its own over it. Nothing moved."
            await parts.database.run(parts.missions.note, session.farm_id, mission_id, session.user_name, why)
        self._replaceable[robot_id] = held.sha256
        parts.on_changed(robot_id, session.user_name)
        self._audit(session, robot, mission, name)
        return f"{name} gives way. It stays on {robot.name} until the queue sends the next; nothing moves."

    def _audit(self, session: SessionInfo, robot: Robot, mission: Mission | None, name: str) -> None:
        text, ref = f"{name} may be replaced on {robot.name}.", name if mission is None else mission.id
        self._parts.audit.append(audit_line(session, "queue", "taken_off", text, ref=ref, robot_id=robot.id))


def held_unstarted(robot: Robot) -> Order | None:
    """Return the mission a robot holds and has not begun, ``None`` if there is none."""
    order = robot.state.order if robot.state is not None else None
    return order if order is not None and order.status is OrderStatus.LOADED else None
