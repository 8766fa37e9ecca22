"""Hold-to-run: each setpoint a browser sends is judged, clamped and forwarded once, or not at all.

Nothing here repeats a setpoint: when frames stop, sending stops, and the robot's own dead-man (0.5 s) does the
rest. The only setpoint the console ever makes by itself is zero.
"""

from __future__ import annotations

import math
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, replace

from hmi.clock import Clock
from hmi.commands.gate import Gate
from hmi.commands.lease_service import LeaseService
from hmi.commands.ledger import CommandResult, Ticket
from hmi.commands.ports import FleetReader, LaneEvent, TickJudge
from hmi.commands.refusal import (
    BAD_SETPOINT,
    DELAY,
    DELAY_UNKNOWN,
    DRIVEN_ELSEWHERE,
    NO_LEASE,
    NOT_CONNECTED,
    NOT_MANUAL,
    STALE_TICK,
    OrderRefused,
)
from hmi.domain.command import Action, DriveOrder, OrderSender
from hmi.domain.ids import new_id
from hmi.domain.lease import Lease
from hmi.domain.robot import Mode, Robot
from hmi.domain.role import Permission
from hmi.security.session_info import SessionInfo

SLOW_MPS, CREEP_MPS = 0.5, 0.2  # ux-spec.md: Slow and Creep; faster needs a spotter on site
SLOW_RADPS, CREEP_RADPS = 0.6, 0.3  # a 1.5 m machine's corner then moves no faster than its middle
DELAY_LOWERS_S, DELAY_STOPS_S = 0.2, 0.3  # at 0.5 m/s and 0.3 s the robot is 15 cm past what the person saw
RTT_KNOWN_S = 5.0  # an older measurement says nothing of the link now
TICK_PERIOD_S = 0.1  # a tick is up to this old when a browser echoes it at once
SAME_HAND_S = 0.5  # one pair of hands: a second page of the same person waits until the first let go
NO_INPUT_S = 300.0  # ux-spec.md: control ends after 5:00 without input


@dataclass(frozen=True, slots=True)
class DriveFrame:
    """One setpoint from a browser: forward speed in m/s, yaw rate in rad/s (left is positive)."""

    robot_id: str
    v_mps: float
    yaw_rate_radps: float
    tick_id: str


@dataclass(frozen=True, slots=True)
class DriveVerdict:
    """What became of a frame: forwarded as ``v_mps`` and ``yaw_rate_radps``, or refused with a sentence."""

    is_forwarded: bool
    code: str
    text: str
    v_mps: float = 0.0
    yaw_rate_radps: float = 0.0
    ends_in_s: float = NO_INPUT_S


@dataclass(frozen=True, slots=True)
class _Driving:
    """Who drives a robot by hand, over which socket, and when something was last pressed."""

    actor: SessionInfo
    input_s: float
    connection: str = ""
    moved_s: float = -math.inf
    lease: Lease | None = None

    @property
    def is_moving(self) -> bool:
        """Whether the last setpoint forwarded was not zero."""
        return self.lease is not None


CloseDrive = Callable[[SessionInfo, str, str], Awaitable[CommandResult]]


class DriveRelay:
    """Forwards setpoints of the lease holder.

    Args:
        close_drive: ends manual mode on the robot, see ``CommandService.close_drive``.
    """

    def __init__(
        self,
        gate: Gate,
        leases: LeaseService,
        fleet: FleetReader,
        ticks: TickJudge,
        sender: OrderSender,
        clock: Clock,
        on_event: LaneEvent,
        close_drive: CloseDrive,
    ) -> None:
        self._gate, self._leases, self._fleet, self._ticks = gate, leases, fleet, ticks
        self._sender, self._clock, self._on_event, self._close_drive = sender, clock, on_event, close_drive
        self._driving: dict[str, _Driving] = {}
        leases.when_ended(self._lease_ended)

    def setpoint(self, actor: SessionInfo, connection: str, frame: DriveFrame) -> DriveVerdict:
        """Judge one frame and forward it at once, or refuse it and bring the robot to rest.

        Args:
            connection: names the socket the frame came by, see ``connection_lost``.
        """
        try:
            robot, lease, cap_mps, cap_radps = self._admit(actor, connection, frame)
        except OrderRefused as refused:
            driving = self._driving.get(frame.robot_id)
            is_own = driving is not None and driving.actor.session_id == actor.session_id
            if is_own and refused.code != DRIVEN_ELSEWHERE:
                self._rest(frame.robot_id)
            return DriveVerdict(False, refused.code, refused.text, ends_in_s=self.ends_in_s(frame.robot_id))
        v_mps, w_radps = _clamp(frame, robot, cap_mps, cap_radps)
        if not self._sender.send(self._order(robot, lease, v_mps, w_radps)):
            return DriveVerdict(False, NOT_CONNECTED, "There is no connection to the robots. Nothing was sent.")
        self._note(actor, connection, robot.id, lease, is_moving=bool(v_mps or w_radps))
        return DriveVerdict(True, "ok", "", v_mps, w_radps, self.ends_in_s(robot.id))

    def connection_lost(self, connection: str) -> None:
        """Bring to rest what was driven over a socket that is gone; one zero each, then silence."""
        for robot_id in [i for i, d in self._driving.items() if d.is_moving and d.connection == connection]:
            self._rest(robot_id)

    def ends_in_s(self, robot_id: str) -> float:
        """Return how long manual control lasts without input."""
        driving = self._driving.get(robot_id)
        return NO_INPUT_S if driving is None else max(0.0, driving.input_s + NO_INPUT_S - self._clock.mono_s())

    def command_settled(self, ticket: Ticket, result: CommandResult) -> None:
        """Start and end the time without input with the commands that open and close driving."""
        if not result.is_accepted:
            return
        if ticket.what == Action.DRIVE_OPEN.value:
            self._driving[ticket.robot_id] = _Driving(ticket.actor, self._clock.mono_s())
        elif ticket.what == Action.DRIVE_CLOSE.value:
            self._driving.pop(ticket.robot_id, None)

    async def tend(self) -> None:
        """End manual control where nothing was pressed for 5:00; call every second or so."""
        due = [(i, d.actor) for i, d in self._driving.items() if self.ends_in_s(i) <= 0]
        for robot_id, actor in due:
            self._rest(robot_id)
            del self._driving[robot_id]
            text = "Driving by hand ended: nothing was pressed for 5:00."
            self._on_event({"kind": "drive", "robot": robot_id, "op": "ended", "by": actor.user_name, "text": text})
            await self._close_drive(actor, robot_id, new_id())

    def _admit(self, actor: SessionInfo, connection: str, frame: DriveFrame) -> tuple[Robot, Lease, float, float]:
        if not (math.isfinite(frame.v_mps) and math.isfinite(frame.yaw_rate_radps)):
            raise OrderRefused(BAD_SETPOINT, "The setpoint is not a number.")
        robot = self._gate.right(actor, Permission.DRIVE, frame.robot_id)
        self._leases.observe(robot)
        lease = self._leases.holds(actor.session_id, robot.id)
        if lease is None:
            owner = self._leases.of(robot.id)
            who = f"{owner.holder.user_name} has control. Ask for it." if owner else "Control has ended. Ask for it."
            raise OrderRefused(NO_LEASE, who)
        self._gate.decided_now(frame.tick_id)
        self._gate.challenge(robot)
        self._gate.may_move(robot)
        if robot.state is None or robot.state.mode is not Mode.MANUAL:
            raise OrderRefused(NOT_MANUAL, f"{robot.name} is not driven by hand now. Open driving first.")
        self._check_hand(robot.id, connection)
        return robot, lease, *self._caps(robot, frame.tick_id)

    def _check_hand(self, robot_id: str, connection: str) -> None:
        driving = self._driving.get(robot_id)
        if driving is None or driving.connection in ("", connection):
            return
        if self._clock.mono_s() - driving.moved_s < SAME_HAND_S:
            raise OrderRefused(DRIVEN_ELSEWHERE, "You drive from another page already. Let go there first.")

    def _caps(self, robot: Robot, tick_id: str) -> tuple[float, float]:
        """Return the highest speed and yaw rate for the delay there is."""
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
        is_slow_link = delay_s > DELAY_LOWERS_S or robot.factsheet is None
        cap_mps, cap_radps = (CREEP_MPS, CREEP_RADPS) if is_slow_link else (SLOW_MPS, SLOW_RADPS)
        if robot.factsheet is not None:
            cap_mps = min(cap_mps, robot.factsheet.max_speed_mps)
            cap_radps = min(cap_radps, robot.factsheet.max_yaw_rate_radps)
        return cap_mps, cap_radps

    def _note(self, actor: SessionInfo, connection: str, robot_id: str, lease: Lease, *, is_moving: bool) -> None:
        now_s = self._clock.mono_s()
        driving = self._driving.get(robot_id)
        if driving is None or driving.actor.session_id != actor.session_id:
            driving = _Driving(actor, now_s)
        if is_moving:
            driving = replace(driving, input_s=now_s, connection=connection, moved_s=now_s, lease=lease)
        else:
            driving = replace(driving, connection="", lease=None)
        self._driving[robot_id] = driving

    def _rest(self, robot_id: str) -> None:
        driving, robot = self._driving.get(robot_id), self._fleet.robot(robot_id)
        if driving is None or driving.lease is None:
            return
        self._driving[robot_id] = replace(driving, connection="", lease=None)
        if robot is not None and robot.link.challenge is not None:
            self._sender.send(self._order(robot, driving.lease, 0.0, 0.0))

    def _lease_ended(self, lease: Lease) -> None:
        driving = self._driving.get(lease.robot_id)
        if driving is not None and driving.actor.session_id == lease.holder.session_id:
            self._rest(lease.robot_id)
            del self._driving[lease.robot_id]

    def _order(self, robot: Robot, lease: Lease, v_mps: float, yaw_rate_radps: float) -> DriveOrder:
        return DriveOrder(
            robot_id=robot.id,
            lease_token=lease.token,
            lease_seq=self._leases.next_seq(lease),
            challenge=robot.link.challenge or "",
            v_mps=v_mps,
            yaw_rate_radps=yaw_rate_radps,
        )


def _clamp(frame: DriveFrame, robot: Robot, cap_mps: float, cap_radps: float) -> tuple[float, float]:
    """Slow a setpoint down to the caps without bending its curve."""
    v_mps, w_radps = frame.v_mps, frame.yaw_rate_radps
    if v_mps < 0 and robot.factsheet is not None and not robot.factsheet.can_reverse:
        v_mps = 0.0
    share = min(
        1.0,
        cap_mps / abs(v_mps) if v_mps else 1.0,
        cap_radps / abs(w_radps) if w_radps else 1.0,
    )
    return v_mps * share, w_radps * share
