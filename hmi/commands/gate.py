"""The questions every order answers before it is sent; asked in one go, without waiting in between."""

from __future__ import annotations

from hmi.clock import Clock
from hmi.commands.ports import FleetReader, TickJudge
from hmi.commands.refusal import (
    HARDWARE_STOP,
    JOINTS_UNKNOWN,
    LATCHED,
    NOT_REGISTERED,
    ROBOT_SILENT,
    SAFETY_UNKNOWN,
    STALE_TICK,
    STATE_UNKNOWN,
    UNKNOWN_ROBOT,
    OrderRefused,
)
from hmi.domain.joint_use import joints_obstacle
from hmi.domain.robot import Robot, SafetyState
from hmi.domain.role import Permission
from hmi.security.authorization import Authorize
from hmi.security.errors import NotAllowed, NotSignedIn
from hmi.security.session_info import SessionInfo

LINK_FRESH_S = 2.0  # the robot refuses a challenge older than this by its own clock


class Gate:
    """Asks rights, registration, freshness and what the safety controller says.

    Every method returns what it established or raises ``OrderRefused``.
    """

    def __init__(self, fleet: FleetReader, ticks: TickJudge, clock: Clock, authorize: Authorize) -> None:
        self._fleet, self._ticks, self._clock, self._authorize = fleet, ticks, clock, authorize

    def right(self, actor: SessionInfo | None, permission: Permission, robot_id: str) -> Robot:
        """Return the robot if it is in the registry and this person may do this to it."""
        robot = self._fleet.robot(robot_id)
        try:
            self._authorize(actor, permission, robot_id)
        except (NotSignedIn, NotAllowed) as error:
            if robot is None and error.code == NOT_REGISTERED:
                raise OrderRefused(UNKNOWN_ROBOT, f"There is no robot {robot_id}.") from error
            raise OrderRefused(error.code, error.text) from error
        if robot is None:
            raise OrderRefused(UNKNOWN_ROBOT, f"There is no robot {robot_id}.")
        if not robot.is_registered:
            raise OrderRefused(
                NOT_REGISTERED, f"{robot.name} is new and cannot be operated. An admin must accept it first."
            )
        return robot

    def may(self, actor: SessionInfo, permission: Permission, robot: Robot) -> bool:
        """Say whether this person may also do something further."""
        try:
            self._authorize(actor, permission, robot.id)
        except (NotSignedIn, NotAllowed):
            return False
        return True

    def decided_now(self, tick_id: str) -> float:
        """Refuse what was decided on a picture older than 2 s, or sent late; return the picture's time."""
        age_s = self._ticks.age_s(tick_id)
        if age_s is None or not self._ticks.is_fresh(tick_id):
            raise OrderRefused(STALE_TICK, "The picture on this screen was older than 2 s. Look again, then repeat.")
        return self._clock.mono_s() - age_s

    def challenge(self, robot: Robot) -> str:
        """Return the challenge of the newest heartbeat if the robot was heard within 2 s."""
        link = robot.link
        if link.challenge is None or link.challenge_s is None:
            raise OrderRefused(ROBOT_SILENT, f"{robot.name} has not been heard yet.")
        age_s = self._clock.mono_s() - link.challenge_s
        if age_s > LINK_FRESH_S:
            raise OrderRefused(
                ROBOT_SILENT, f"No link to {robot.name} for {age_s:.0f} s. Commands are off until the link is back."
            )
        return link.challenge

    def safety(self, robot: Robot) -> SafetyState:
        """Return the robot's safety state if it is known and at most 2 s old."""
        safety = robot.safety
        if safety is None or self._clock.mono_s() - safety.stamp.source_s > LINK_FRESH_S:
            raise OrderRefused(SAFETY_UNKNOWN, f"The safety state of {robot.name} is not known right now.")
        return safety

    def knows_state(self, robot: Robot) -> None:
        """Refuse what goes by the robot's mission and mode if it told them more than 2 s ago, or never."""
        state = robot.state
        if state is None or self._clock.mono_s() - state.stamp.source_s > LINK_FRESH_S:
            raise OrderRefused(STATE_UNKNOWN, f"What {robot.name} is doing is not known right now.")

    def knows_joints(self, robot: Robot) -> None:
        """Refuse to send an arm of which a joint was not heard within 2 s."""
        if reason := joints_obstacle(robot, self._clock.mono_s()):
            raise OrderRefused(JOINTS_UNKNOWN, f"{robot.name}: {reason} How its arm stands is not known right now.")

    def may_move(self, robot: Robot) -> None:
        """Refuse motion while a stop is latched, pressed on the machine, or not known to be clear."""
        safety = self.safety(robot)
        if safety.hardware_stop:
            raise OrderRefused(HARDWARE_STOP, "Hardware button is pressed on the machine. Release it there first.")
        if safety.latched:
            raise OrderRefused(LATCHED, "Reset the stop first.")
