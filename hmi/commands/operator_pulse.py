"""The lease holder is there: forwards each browser's proof of life to the robot, and never makes one up."""

from __future__ import annotations

from hmi.clock import Clock
from hmi.commands.lease_service import LeaseService
from hmi.commands.ports import FleetReader, TickJudge
from hmi.domain.command import OperatorPulse, OrderSender
from hmi.security.session_info import SessionInfo

PERIOD_S = 1.0
JITTER_S = 0.5  # a browser's timer wanders; dropping a frame for 10 ms would halve the rate at the robot


class OperatorPulseRelay:
    """Turns ``here`` frames into lease renewals and operator heartbeats, at most one a second and robot."""

    def __init__(
        self, leases: LeaseService, fleet: FleetReader, ticks: TickJudge, sender: OrderSender, clock: Clock
    ) -> None:
        self._leases, self._fleet, self._ticks = leases, fleet, ticks
        self._sender, self._clock = sender, clock
        self._due_s: dict[str, float] = {}

    def here(self, actor: SessionInfo, robot_id: str, tick_id: str) -> bool:
        """Take one ``here`` frame; return whether this browser holds the robot.

        A frame with an old tick was held up somewhere: it proves nothing about now and is dropped.
        """
        if not self._ticks.is_fresh(tick_id):
            return False
        robot = self._fleet.robot(robot_id)
        if robot is not None:
            self._leases.observe(robot)
        lease = self._leases.prove_life(actor.session_id, robot_id)
        if lease is None or robot is None:
            return False
        now_s = self._clock.mono_s()
        due_s = self._due_s.get(robot_id, now_s)
        if robot.link.challenge is not None and now_s >= due_s - JITTER_S:
            pulse = OperatorPulse(robot_id, lease.token, self._leases.next_seq(lease), robot.link.challenge)
            if self._sender.send(pulse):
                self._due_s[robot_id] = max(now_s, due_s) + PERIOD_S
        return True
