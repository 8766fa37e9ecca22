"""Hold-to-run: each setpoint a browser sends is judged, clamped and forwarded once, or not at all.

Wheels and joints follow the same rules and share one pair of hands. Nothing here repeats a setpoint: when frames
stop, sending stops, and the robot's own dead-man (0.5 s) does the rest. The only setpoint the console ever makes by
itself is zero.
"""

from __future__ import annotations

import math
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass, field, replace

from hmi.clock import Clock
from hmi.commands.gate import Gate
from hmi.commands.hold_rules import HoldRules, is_slow_picture
from hmi.commands.lease_service import LeaseService
from hmi.commands.ledger import CommandResult, Ticket
from hmi.commands.ports import FleetReader, LaneEvent, TickJudge
from hmi.commands.refusal import BAD_SETPOINT, DRIVEN_ELSEWHERE, FUNCTION_OFF, NOT_CONNECTED, OrderRefused
from hmi.domain.command import Acknowledgement, Action, DriveOrder, JogOrder, OrderSender
from hmi.domain.function_use import jog_obstacle, obstacle
from hmi.domain.ids import new_id
from hmi.domain.lease import Lease
from hmi.domain.robot import Robot
from hmi.security.session_info import SessionInfo

SLOW_MPS, CREEP_MPS = 0.5, 0.2  # ux-spec.md: Slow and Creep; faster needs a spotter on site
SLOW_RADPS, CREEP_RADPS = 0.6, 0.3  # a 1.5 m machine's corner then moves no faster than its middle
SLOW_SHARE, CREEP_SHARE = 0.5, 0.2  # of a joint's own top rate: nobody guides a crane by hand at full speed
SAME_HAND_S = 0.5  # one pair of hands: a second page of the same person waits until the first let go
NO_INPUT_S = 300.0  # ux-spec.md: control ends after 5:00 without input


@dataclass(frozen=True, slots=True)
class DriveFrame:
    """One setpoint from a browser: forward speed in m/s, yaw rate in rad/s (left is positive).

    Args:
        picture_s: age of the camera picture the person steers by, ``None`` where none is in use.
    """

    robot_id: str
    v_mps: float
    yaw_rate_radps: float
    tick_id: str
    picture_s: float | None = None


@dataclass(frozen=True, slots=True)
class JogFrame:
    """One setpoint of joints from a browser, by name: rad/s or m/s; ``picture_s`` as of ``DriveFrame``."""

    robot_id: str
    rates: Mapping[str, float]
    tick_id: str
    picture_s: float | None = None


@dataclass(frozen=True, slots=True)
class DriveVerdict:
    """What became of a frame: forwarded as ``v_mps`` and ``yaw_rate_radps`` or ``rates``, or refused."""

    is_forwarded: bool
    code: str
    text: str
    v_mps: float = 0.0
    yaw_rate_radps: float = 0.0
    ends_in_s: float = NO_INPUT_S
    rates: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class _Driving:
    """Who drives a robot by hand, over which socket, and when something was last pressed."""

    actor: SessionInfo
    input_s: float
    connection: str = ""
    moved_s: float = -math.inf
    lease: Lease | None = None
    is_driving: bool = False
    joints: frozenset[str] = frozenset()

    @property
    def is_moving(self) -> bool:
        """Whether the last setpoint forwarded to wheels or joints was not zero."""
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
        self._leases, self._fleet, self._rules = leases, fleet, HoldRules(gate, leases, ticks, clock)
        self._sender, self._clock, self._on_event, self._close_drive = sender, clock, on_event, close_drive
        self._driving: dict[str, _Driving] = {}
        leases.when_ended(self._lease_ended)

    def setpoint(self, actor: SessionInfo, connection: str, frame: DriveFrame) -> DriveVerdict:
        """Judge one frame for the wheels and forward it at once, or refuse it and bring the robot to rest.

        Args:
            connection: names the socket the frame came by, see ``connection_lost``.
        """
        try:
            robot, lease, v_mps, w_radps = self._admit_drive(actor, connection, frame)
        except OrderRefused as refused:
            return self._refuse(actor, frame.robot_id, refused)
        if not self._sender.send(self._order(robot, lease, v_mps, w_radps)):
            return _NOT_SENT
        self._note(actor, connection, robot.id, lease, is_driving=bool(v_mps or w_radps))
        return DriveVerdict(True, "ok", "", v_mps, w_radps, self.ends_in_s(robot.id))

    def jog(self, actor: SessionInfo, connection: str, frame: JogFrame) -> DriveVerdict:
        """Judge one frame for the joints and forward it at once, or refuse it and bring the robot to rest."""
        try:
            robot, lease, rates = self._admit_jog(actor, connection, frame)
        except OrderRefused as refused:
            return self._refuse(actor, frame.robot_id, refused)
        if not self._sender.send(self._jog_order(robot, lease, rates)):
            return _NOT_SENT
        moving = frozenset(name for name, rate in rates.items() if rate)
        self._note(actor, connection, robot.id, lease, joints=moving)
        return DriveVerdict(True, "ok", "", ends_in_s=self.ends_in_s(robot.id), rates=rates)

    def refused_by_robot(self, answer: Acknowledgement) -> None:
        """Bring to rest what the robot does not do, and say why to the hand that holds it.

        A pad that is still held must not move it the moment the reason is gone: the hand has to let go first.
        """
        driving = self._driving.get(answer.robot_id)
        if answer.kind != "drive" or answer.is_accepted or driving is None or not driving.is_moving:
            return
        kinds = [kind for kind, is_held in (("drive", driving.is_driving), ("jog", bool(driving.joints))) if is_held]
        self._rest(answer.robot_id)
        for kind in kinds:
            told = {"kind": kind, "op": "refused", "robot": answer.robot_id, "code": answer.code, "text": answer.text}
            self._on_event(told)

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
        # asked anew each time: while one is closed, a hand may press elsewhere, or driving may end there
        while (robot_id := next((i for i in self._driving if self.ends_in_s(i) <= 0), None)) is not None:
            actor = self._driving[robot_id].actor
            self._rest(robot_id)
            del self._driving[robot_id]
            text = "Driving by hand ended: nothing was pressed for 5:00."
            self._on_event({"kind": "drive", "robot": robot_id, "op": "ended", "by": actor.user_name, "text": text})
            await self._close_drive(actor, robot_id, new_id())

    def _admit_drive(self, actor: SessionInfo, connection: str, frame: DriveFrame) -> tuple[Robot, Lease, float, float]:
        if not (math.isfinite(frame.v_mps) and math.isfinite(frame.yaw_rate_radps)):
            raise OrderRefused(BAD_SETPOINT, "The setpoint is not a number.")
        robot, lease = self._rules.admit(actor, frame.robot_id, frame.tick_id)
        if reason := obstacle(robot, Action.DRIVE_OPEN):
            raise OrderRefused(FUNCTION_OFF, reason)
        self._check_hand(robot.id, connection)
        is_old = is_slow_picture(frame.picture_s)
        is_slow = self._rules.is_slow_link(robot, frame.tick_id) or is_old
        return robot, lease, *_clamp(frame, robot, *_caps(robot, is_slow=is_slow))

    def _admit_jog(self, actor: SessionInfo, connection: str, frame: JogFrame) -> tuple[Robot, Lease, dict[str, float]]:
        if not all(math.isfinite(one) for one in frame.rates.values()):
            raise OrderRefused(BAD_SETPOINT, "The setpoint is not a number.")
        robot, lease = self._rules.admit(actor, frame.robot_id, frame.tick_id)
        if reason := jog_obstacle(robot):
            raise OrderRefused(FUNCTION_OFF, reason)
        self._check_hand(robot.id, connection)
        is_old = is_slow_picture(frame.picture_s)
        is_slow = self._rules.is_slow_link(robot, frame.tick_id) or is_old
        return robot, lease, _clamp_joints(frame, robot, CREEP_SHARE if is_slow else SLOW_SHARE)

    def _refuse(self, actor: SessionInfo, robot_id: str, refused: OrderRefused) -> DriveVerdict:
        driving = self._driving.get(robot_id)
        is_own = driving is not None and driving.actor.session_id == actor.session_id
        if is_own and refused.code != DRIVEN_ELSEWHERE:
            self._rest(robot_id)
        return DriveVerdict(False, refused.code, refused.text, ends_in_s=self.ends_in_s(robot_id))

    def _check_hand(self, robot_id: str, connection: str) -> None:
        driving = self._driving.get(robot_id)
        if driving is None or driving.connection in ("", connection):
            return
        if self._clock.mono_s() - driving.moved_s < SAME_HAND_S:
            raise OrderRefused(DRIVEN_ELSEWHERE, "You drive from another page already. Let go there first.")

    def _note(
        self,
        actor: SessionInfo,
        connection: str,
        robot_id: str,
        lease: Lease,
        *,
        is_driving: bool | None = None,
        joints: frozenset[str] | None = None,
    ) -> None:
        """Remember what moves now; what a frame does not speak of stays as it was."""
        now_s = self._clock.mono_s()
        driving = self._driving.get(robot_id)
        if driving is None or driving.actor.session_id != actor.session_id:
            driving = _Driving(actor, now_s)
        if is_driving is not None:
            driving = replace(driving, is_driving=is_driving)
        if joints is not None:
            driving = replace(driving, joints=joints)
        if is_driving or joints:
            driving = replace(driving, input_s=now_s, connection=connection, moved_s=now_s)
        is_moving = driving.is_driving or bool(driving.joints)
        driving = replace(driving, lease=lease) if is_moving else replace(driving, connection="", lease=None)
        self._driving[robot_id] = driving

    def _rest(self, robot_id: str) -> None:
        driving, robot = self._driving.get(robot_id), self._fleet.robot(robot_id)
        if driving is None or driving.lease is None:
            return
        self._driving[robot_id] = replace(driving, connection="", lease=None, is_driving=False, joints=frozenset())
        if robot is None or robot.link.challenge is None:
            return
        if driving.is_driving:
            self._sender.send(self._order(robot, driving.lease, 0.0, 0.0))
        if driving.joints:
            self._sender.send(self._jog_order(robot, driving.lease, dict.fromkeys(sorted(driving.joints), 0.0)))

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

    def _jog_order(self, robot: Robot, lease: Lease, rates: Mapping[str, float]) -> JogOrder:
        return JogOrder(robot.id, lease.token, self._leases.next_seq(lease), robot.link.challenge or "", rates)


_NOT_SENT = DriveVerdict(False, NOT_CONNECTED, "There is no connection to the robots. Nothing was sent.")


def _caps(robot: Robot, *, is_slow: bool) -> tuple[float, float]:
    """Return the highest speed and yaw rate for the link there is."""
    cap_mps, cap_radps = (CREEP_MPS, CREEP_RADPS) if is_slow else (SLOW_MPS, SLOW_RADPS)
    if robot.factsheet is not None:
        cap_mps = min(cap_mps, robot.factsheet.max_speed_mps)
        cap_radps = min(cap_radps, robot.factsheet.max_yaw_rate_radps)
    return cap_mps, cap_radps


def _clamp_joints(frame: JogFrame, robot: Robot, share: float) -> dict[str, float]:
    """Slow each joint down to a share of its own top rate; a joint the machine does not have is refused."""
    joints = {one.name: one for one in robot.factsheet.joints} if robot.factsheet is not None else {}
    rates = {}
    for name, rate in frame.rates.items():
        if name not in joints:
            raise OrderRefused(BAD_SETPOINT, f"{robot.name} has no joint {name}.")
        cap = joints[name].max_rate * share
        rates[name] = max(-cap, min(cap, rate))
    if not rates:
        raise OrderRefused(BAD_SETPOINT, "The setpoint names no joint.")
    return rates


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
