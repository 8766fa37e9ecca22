"""What a hold-to-run setpoint must satisfy before it goes out, whether it moves wheels or joints."""

from __future__ import annotations

from hmi.clock import Clock
from hmi.commands.gate import Gate
from hmi.commands.lease_service import LeaseService
from hmi.commands.ports import TickJudge
from hmi.commands.refusal import (
    DELAY,
    DELAY_UNKNOWN,
    NO_LEASE,
    NOT_MANUAL,
    PICTURE_OLD,
    STALE_TICK,
    OrderRefused,
)
from hmi.domain.lease import Lease
from hmi.domain.robot import Mode, Robot
from hmi.domain.role import Permission
from hmi.security.session_info import SessionInfo

DELAY_LOWERS_S, DELAY_STOPS_S = 0.2, 0.3  # at 0.5 m/s and 0.3 s the robot is 15 cm past what the person saw
PICTURE_LOWERS_S, PICTURE_STOPS_S = 0.5, 1.0  # a frozen picture says so after 1 s; at creep it then is 20 cm behind
RTT_KNOWN_S = 5.0  # an older measurement says nothing of the link now
TICK_PERIOD_S = 0.1  # a tick is up to this old when a browser echoes it at once


class HoldRules:
    """Asks rights, control, freshness, latch, mode and delay; each question refuses with ``OrderRefused``."""

    def __init__(self, gate: Gate, leases: LeaseService, ticks: TickJudge, clock: Clock) -> None:
        self._gate, self._leases, self._ticks, self._clock = gate, leases, ticks, clock

    def admit(self, actor: SessionInfo, robot_id: str, tick_id: str) -> tuple[Robot, Lease]:
        """Return the robot and the lease if this browser may move it by hand right now."""
        robot = self._gate.right(actor, Permission.DRIVE, robot_id)
        self._leases.observe(robot)
        lease = self._leases.holds(actor.session_id, robot.id)
        if lease is None:
            owner = self._leases.of(robot.id)
            who = f"{owner.holder.user_name} has control. Ask for it." if owner else "Control has ended. Ask for it."
            raise OrderRefused(NO_LEASE, who)
        self._gate.decided_now(tick_id)
        self._gate.challenge(robot)
        self._gate.may_move(robot)
        if robot.state is None or robot.state.mode is not Mode.MANUAL:
            raise OrderRefused(NOT_MANUAL, f"{robot.name} is not driven by hand now. Open driving first.")
        return robot, lease

    def is_slow_link(self, robot: Robot, tick_id: str) -> bool:
        """Say whether the delay lowers the speed; a delay at which nobody can steer by eye is refused."""
        link, now_s = robot.link, self._clock.mono_s()
        if link.rtt_s is None or link.rtt_at_s is None or now_s - link.rtt_at_s > RTT_KNOWN_S:
            raise OrderRefused(DELAY_UNKNOWN, f"The delay to {robot.name} is not known right now.")
        age_s = self._ticks.age_s(tick_id)
        if age_s is None:
            raise OrderRefused(STALE_TICK, "The picture on this screen was older than 2 s.")
        # The tick's age holds the way to the browser and back, and at most one tick period on top.
        delay_s = link.rtt_s + max(0.0, age_s - TICK_PERIOD_S)
        if delay_s > DELAY_STOPS_S:
            raise OrderRefused(DELAY, f"The delay is {delay_s * 1000:.0f} ms. Driving needs 300 ms or less.")
        return delay_s > DELAY_LOWERS_S or robot.factsheet is None


def is_slow_picture(picture_s: float | None) -> bool:
    """Say whether the picture somebody steers by lowers the speed; one that nobody can steer by is refused.

    Args:
        picture_s: age of the picture on the driver's screen as the browser says, ``None`` without one in use.
    """
    if picture_s is None:
        return False
    if not 0.0 <= picture_s <= PICTURE_STOPS_S:  # a NaN is no age
        raise OrderRefused(PICTURE_OLD, "The picture you drive by is older than 1 s. Close it to drive by sight.")
    return picture_s > PICTURE_LOWERS_S
