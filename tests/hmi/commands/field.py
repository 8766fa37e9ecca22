"""A field with robots that judge orders as real ones do, on clocks that only tests move."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from typing import Any

from hmi.clock import FakeClock
from hmi.commands.desk import CommandDesk, CommandPorts
from hmi.commands.ports import StoredMission
from hmi.domain.command import (
    Acknowledgement,
    Action,
    CommandOrder,
    DriveOrder,
    JogOrder,
    OperatorPulse,
    Order,
    OrderFailed,
    ResetOrder,
    StopOrder,
)
from hmi.domain.freshness import TickRing
from hmi.domain.machine import Body, Worksite
from hmi.domain.robot import (
    Factsheet,
    Family,
    LinkHealth,
    Mode,
    Node,
    OrderStatus,
    Press,
    Robot,
    RobotState,
    SafetyState,
    Stamp,
)
from hmi.domain.robot import Order as MissionOrder
from hmi.domain.role import Role
from hmi.security.authorization import Authorizer
from hmi.security.session_info import SessionInfo
from hmi.store.audit_chain import AuditEntry

FARM = "farm"
CHALLENGE_LIFE_S = 2.0
SHA = "a" * 64
MOVING = frozenset({Action.START, Action.RESUME, Action.RETURN_HOME, Action.DRIVE_OPEN})


def person(name: str, role: Role = Role.OPERATOR, *, browser: str = "1", farm_id: str = FARM) -> SessionInfo:
    """Return somebody signed in on one browser."""
    user_id = name.split()[0].lower()
    return SessionInfo(
        session_id=f"{user_id}-{browser}",
        user_id=user_id,
        user_name=name,
        role=role,
        device_id=f"tablet-{browser}",
        device_name=f"Tablet {browser}",
        farm_id=farm_id,
        csrf="csrf",
        expires_utc=datetime(2026, 5, 5, tzinfo=UTC),
    )


MARTHA = person("Martha Keller")
JONAS = person("Jonas Weber")
ANNA = person("Anna Ostermeier", Role.SUPERVISOR)
VERA = person("Vera Lang", Role.VIEWER)


@dataclass
class FakeRobot:
    """A robot: its own clock, challenges, fencing, latch and memory of ids."""

    id: str
    clock: FakeClock
    name: str = "Weeder 01"
    is_registered: bool = True
    farm_id: str = FARM
    mode: Mode = Mode.IDLE
    mission: MissionOrder | None = None
    boot: str = "boot-0001"
    speed_mps: float = 0.0
    hardware_stop: bool = False
    presses: list[Press] = field(default_factory=list)
    rtt_s: float | None = 0.02
    factsheet: Factsheet | None = None
    is_silent: bool = False
    is_deaf: bool = False
    refuse_with: tuple[str, str] | None = None
    own_s: float = 0.0
    challenge: str = ""
    heard_s: float | None = None
    state_s: float | None = None  # when it told its state last; with each heartbeat if nothing is said
    orders: list[Order] = field(default_factory=list)
    done: list[str] = field(default_factory=list)
    v_mps: float = 0.0
    rates: dict[str, float] = field(default_factory=dict)
    nodes: dict[str, Node] = field(default_factory=dict)
    worksite: Worksite | None = None
    body: Body | None = None
    stored_sha256: str | None = SHA
    _issued: dict[str, float] = field(default_factory=dict)
    _answers: dict[str, Acknowledgement] = field(default_factory=dict)
    _token: int = 0
    _revoked: int = 0
    _seq: dict[str, int] = field(default_factory=dict)

    def beat(self) -> None:
        """Send a heartbeat that the console hears at once."""
        self.challenge = f"challenge-{self.boot}-{len(self._issued):08d}"
        self._issued[self.challenge] = self.own_s
        self.heard_s = self.clock.mono_s()

    def reboot(self) -> None:
        """Start anew: another boot, another clock, no challenge known; latch and fencing survive."""
        self.boot = f"boot-{int(self.boot.removeprefix('boot-')) + 1:04d}"
        self.own_s = 0.0
        self._issued = {}
        self.challenge, self.heard_s = "", None

    def press(self, stop_id: str, by: str, device: str = "Tablet 9") -> None:
        """Latch a STOP."""
        self.presses.append(Press(stop_id, by, device, self.clock.mono_s(), False))
        self._revoked = max(self._revoked, self._token)
        self.v_mps = self.speed_mps = 0.0
        self.rates = {}
        self.mode = Mode.STOPPED

    def push_button(self) -> None:
        """Press the red button on the machine."""
        self.hardware_stop, self.mode = True, Mode.STOPPED
        self._revoked = max(self._revoked, self._token)

    @property
    def is_latched(self) -> bool:
        """Whether a press is not reset."""
        return any(not p.is_reset for p in self.presses)

    def receive(self, order: Order) -> Acknowledgement | None:
        """Judge an order by the robot's own rules and carry it out if it is good."""
        self.orders.append(order)
        match order:
            case CommandOrder():
                return self._once(order.command_id, lambda: self._command(order))
            case ResetOrder():
                return self._once(order.reset_id, lambda: self._reset(order))
            case StopOrder():
                self.press(order.stop_id, order.by, order.device)
                return self._ack("stop", order.stop_id, "ok")
            case DriveOrder():
                if self._judge(order.challenge, order.lease_token, order.lease_seq, "order") == "ok":
                    self.v_mps = 0.0 if self.is_latched else order.v_mps
            case JogOrder():
                if self._judge(order.challenge, order.lease_token, order.lease_seq, "order") == "ok":
                    self.rates = {} if self.is_latched else {n: rate for n, rate in order.rates.items() if rate}
            case OperatorPulse():
                pass
        return None

    def known(self) -> Robot:
        """Return what the console knows of this robot now."""
        now_s = self.clock.mono_s()
        heard_s = self.heard_s if self.heard_s is not None else now_s
        stamp = Stamp(heard_s, heard_s)
        told = stamp if self.state_s is None else Stamp(self.state_s, self.state_s)
        return Robot(
            id=self.id,
            is_registered=self.is_registered,
            name=self.name,
            farm_id=self.farm_id,
            link=LinkHealth(
                is_online=True,
                heard_s=self.heard_s,
                challenge=self.challenge or None,
                challenge_s=self.heard_s,
                boot=self.boot,
                rtt_s=self.rtt_s,
                rtt_max_s=self.rtt_s,
                is_broker_up=not self.is_deaf,
                rtt_at_s=now_s if self.rtt_s is not None else None,
            ),
            factsheet=self.factsheet,
            state=RobotState(self.mode, (), now_s, self._token, None, self.mission, (), None, told),
            safety=SafetyState(
                hardware_stop=self.hardware_stop,
                latched=self.is_latched,
                standstill=self.speed_mps == 0,
                speed_mps=self.speed_mps,
                tool_off=True,
                presses=tuple(self.presses),
                stopping_distance_m=None,
                stamp=stamp,
            ),
            nodes=self.nodes,
            worksite=self.worksite,
            body=self.body,
        )

    def _once(self, ref: str, act: Any) -> Acknowledgement:
        if ref not in self._answers:
            self._answers[ref] = act()
        return self._answers[ref]

    def _command(self, order: CommandOrder) -> Acknowledgement:
        if self.refuse_with is not None:
            return self._ack("command", order.command_id, *self.refuse_with)
        is_leased = order.lease_token > 0
        code = self._judge(order.challenge, order.lease_token, order.lease_seq, "order") if is_leased else "ok"
        if code == "ok" and self._age_s(order.challenge) * 1000 > order.ttl_ms:
            code = "expired"
        if code == "ok" and self.is_latched and order.action in MOVING:
            code = "stop_latched"
        if code == "ok":
            self.done.append(order.command_id)
            self.mode = {"drive_open": Mode.MANUAL, "pause": Mode.PAUSED}.get(order.action.value, self.mode)
        return self._ack("command", order.command_id, code)

    def _reset(self, order: ResetOrder) -> Acknowledgement:
        code = self._judge(order.challenge, order.lease_token, order.lease_seq, "order")
        if code == "ok":
            self.done.append(order.reset_id)
            self.presses = [replace(p, is_reset=p.is_reset or p.stop_id in order.stop_ids) for p in self.presses]
            self.mode = self.mode if self.is_latched else Mode.PAUSED
        return self._ack("stop-reset", order.reset_id, code)

    def _judge(self, challenge: str, token: int, seq: int, kind: str) -> str:
        if self._age_s(challenge) > CHALLENGE_LIFE_S:
            return "stale_challenge"
        if token <= self._revoked:
            return "lease_revoked"
        if token < self._token:
            return "old_lease"
        if token > self._token:
            self._token, self._seq = token, {}
        if seq <= self._seq.get(kind, 0):
            return "out_of_order"
        self._seq[kind] = seq
        return "ok"

    def _age_s(self, challenge: str) -> float:
        return self.own_s - self._issued.get(challenge, float("-inf"))

    def _ack(self, kind: str, ref: str, code: str, text: str = "") -> Acknowledgement:
        return Acknowledgement(self.id, kind, ref, code == "ok", code, text, None, None, None)


class Wire:
    """Carries orders to the robots and their answers back, at once or when told."""

    def __init__(self, robots: dict[str, FakeRobot]) -> None:
        self._robots = robots
        self.held_answers: list[Acknowledgement] = []
        self.desk: CommandDesk | None = None

    def send(self, order: Order) -> bool:
        """Deliver at once; the answer comes at once unless the robot is silent."""
        robot = self._robots[order.robot_id]
        if robot.is_deaf:
            return False
        answer = robot.receive(order)
        if answer is not None and self.desk is not None:
            if robot.is_silent:
                self.held_answers.append(answer)
            else:
                self.desk.ledger.acknowledged(answer)
        return True

    def release(self) -> None:
        """Let every held answer arrive."""
        held, self.held_answers = self.held_answers, []
        for answer in held:
            assert self.desk is not None
            self.desk.ledger.acknowledged(answer)

    async def stop_by_http(self, order: StopOrder) -> Acknowledgement | None:
        """Deliver by the other path."""
        return self._robots[order.robot_id].receive(order)

    async def upload_mission(self, robot_id: str, document: dict[str, Any]) -> Acknowledgement:
        """Store and read back."""
        robot = self._robots[robot_id]
        await asyncio.sleep(0)
        if robot.is_silent:
            raise OrderFailed("no_answer", "The robot did not answer.", is_outcome_known=False)
        if robot.refuse_with is not None:
            code, text = robot.refuse_with
            return Acknowledgement(robot_id, "mission", document["mission_id"], False, code, text, None, None, None)
        return Acknowledgement(
            robot_id, "mission", document["mission_id"], True, "ok", "", None, robot.stored_sha256, None
        )


class Missions:
    """Stored missions by id."""

    def __init__(self) -> None:
        self.by_id: dict[str, StoredMission] = {
            "field-1": StoredMission("field-1", "Field 1", {"mission_id": "field-1"}, SHA)
        }
        self.noted: list[tuple[str, str]] = []
        self.done: dict[str, str] = {}

    def forgets(self, farm_id: str, mission_id: str) -> str:
        """Say what was done of a mission that was interrupted."""
        return self.done.get(mission_id, "")

    async def stored(self, farm_id: str, mission_id: str, robot_id: str, by: str) -> StoredMission | None:
        """Return one."""
        return self.by_id.get(mission_id)

    async def sent(self, farm_id: str, mission_id: str, robot_id: str, by: str) -> None:
        """Note that it was sent."""
        self.noted.append((mission_id, robot_id))

    async def refused(self, farm_id: str, mission_id: str, sha256: str, by: str, why: str) -> None:
        """Nothing was proposed."""


@dataclass
class Rules:
    """Start rules that let everything through and say whether somebody has to look on."""

    supervised: bool = True

    def check(self, actor: SessionInfo, robot: Robot, order: MissionOrder, checklist_id: str | None) -> None:
        """Let it through."""

    def check_flight(self, robot: Robot, order: MissionOrder) -> None:
        """Let it through."""

    def is_supervised(self, robot: Robot, order: MissionOrder) -> bool:
        """Say so."""
        return self.supervised


class AuditLog:
    """Keeps audit lines."""

    def __init__(self) -> None:
        self.entries: list[AuditEntry] = []

    def append(self, entry: AuditEntry) -> None:
        """Keep one."""
        self.entries.append(entry)

    def outcomes(self, kind: str) -> list[str]:
        """Return the outcomes of one kind in order."""
        return [e.outcome for e in self.entries if e.kind == kind]


class Field:
    """One console with its robots."""

    def __init__(self, *, epoch: int = 1, ack_limit_s: float = 0.0, rules: Rules | None = None) -> None:
        self.clock = FakeClock()
        self.ticks = TickRing("console1", self.clock.mono_s, self.clock.utc)
        self.robots: dict[str, FakeRobot] = {}
        self.wire = Wire(self.robots)
        self.missions = Missions()
        self.audit = AuditLog()
        self.events: list[Mapping[str, Any]] = []
        self.signed_out: set[str] = set()
        self.pressers: dict[str, set[str]] = {}
        self._epoch = epoch
        self.weeder = self.add("weeder-01", "Weeder 01")
        self.desk = CommandDesk(
            CommandPorts(
                fleet=self,
                ticks=self.ticks,
                sender=self.wire,
                audit=self.audit,
                missions=self.missions,
                clock=self.clock,
                authorize=Authorizer(self._registered),
                on_event=self.events.append,
                epoch=epoch,
                next_epoch=self._next_epoch,
                is_signed_in=lambda session_id: session_id not in self.signed_out,
                ack_limit_s=ack_limit_s,
                start_rules=rules,
                pressers=self._who_pressed,
            )
        )
        self.wire.desk = self.desk

    def add(self, robot_id: str, name: str) -> FakeRobot:
        """Put a robot on the field; it has been heard."""
        robot = self.robots[robot_id] = FakeRobot(robot_id, self.clock, name)
        robot.beat()
        return robot

    def robot(self, robot_id: str) -> Robot | None:
        """Return what is known of one."""
        robot = self.robots.get(robot_id)
        return robot.known() if robot is not None else None

    def tick(self) -> str:
        """Return the id of a fresh tick."""
        return self.ticks.issue().id

    def wait(self, seconds: float, *, hears: bool = True) -> None:
        """Let all clocks run; robots keep sending heartbeats unless told otherwise."""
        self.clock.advance(seconds)
        for robot in self.robots.values():
            robot.own_s += seconds
            if hears:
                robot.beat()

    def events_of(self, kind: str) -> list[Mapping[str, Any]]:
        """Return lane events of one kind."""
        return [e for e in self.events if e["kind"] == kind]

    async def _who_pressed(self, robot_id: str) -> Mapping[str, set[str]]:
        return self.pressers

    def _registered(self, robot_id: str) -> FakeRobot | None:
        robot = self.robots.get(robot_id)
        return robot if robot is not None and robot.is_registered else None

    async def _next_epoch(self) -> int:
        self._epoch += 1
        return self._epoch


def factsheet(**changes: Any) -> Factsheet:
    """Return the weeder's factsheet with changes."""
    sheet = Factsheet(
        family=Family.WEEDER,
        name="Weeder 01",
        model="LW-1",
        software="1.0",
        datum_lat_deg=52.0,
        datum_lon_deg=5.0,
        length_m=2.4,
        width_m=1.6,
        height_m=1.4,
        base_to_front_m=1.2,
        track_m=1.5,
        max_speed_mps=1.67,
        max_accel_mps2=0.5,
        decel_mps2=1.0,
        max_yaw_rate_radps=0.8,
        turning_radius_m=0.0,
        can_reverse=True,
        can_pivot=True,
        tool_kind="laser",
        tool_label="Laser",
        tool_width_m=1.5,
        drive_deadman_s=0.5,
        operator_lost_pause_s=3.5,
        link_lost_pause_s=10.0,
        start_horn_s=3.0,
        keep_out_m=15.0,
        stop_effect="Laser off, tracks brake.",
    )
    return replace(sheet, **changes)


def mission(mission_id: str = "field-1", status: OrderStatus = OrderStatus.LOADED) -> MissionOrder:
    """Return a mission as the robot reports it."""
    return MissionOrder(mission_id, 1, SHA, status, 0, 40, 0, 0.0, 1e4, 0.0, 0.0, None, True)
