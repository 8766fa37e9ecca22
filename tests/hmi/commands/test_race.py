"""Two operators race while everything on the way goes wrong: nothing late acts, nothing acts twice, nothing fresh is
refused.

Requests of browsers and orders on the wire are held, repeated and reordered; the console's wall clock jumps, the
robot's clock starts anew, leases expire, STOP is pressed in between. Browsers have no clock here at all: what they
send carries none, so theirs can say anything.
"""

from __future__ import annotations

import asyncio
from collections.abc import Coroutine
from dataclasses import dataclass
from datetime import datetime
from typing import Any, TypeVar

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from hmi.commands.lease_service import LeaseOp
from hmi.commands.ledger import CommandResult
from hmi.commands.reset import ResetRequest
from hmi.commands.service import CommandRequest
from hmi.domain.command import LEASED_ACTIONS, Action, CommandOrder, Order, Outcome
from hmi.security.session_info import SessionInfo
from tests.hmi.commands.field import ANNA, JONAS, MARTHA, MOVING, Field, Wire

R = TypeVar("R")
LATE_S = 2.0 + 2.0  # the picture may be 2 s old at the console, the order another 2 s old at the robot
PEOPLE = st.sampled_from([MARTHA, JONAS])
ACTIONS = st.sampled_from([Action.RETURN_HOME, Action.RESUME, Action.DRIVE_CLOSE, Action.PAUSE])


class SlowWire(Wire):
    """Keeps every order until it is told to deliver it; may deliver it again and in any order."""

    def __init__(self, field: Field) -> None:
        super().__init__(field.robots)
        self._field = field
        self.under_way: list[tuple[Order, str | None]] = []

    def send(self, order: Order) -> bool:
        """Note the order and who had control when it was sent."""
        lease = self._field.desk.leases.of(order.robot_id)
        self.under_way.append((order, lease.holder.user_name if lease is not None else None))
        return True

    def arrive(self, number: int) -> None:
        """Deliver one order, for the first time or again."""
        super().send(self.under_way[number][0])


@dataclass(frozen=True)
class Sent:
    """A request of a browser and when the person decided: in true time, and by the console's wall clock."""

    actor: SessionInfo
    request: CommandRequest
    decided_s: float
    decided_at: datetime


class Race(RuleBasedStateMachine):
    """One robot, two operators, and a network that keeps no promise."""

    @initialize()
    def start(self) -> None:
        """Begin with a robot that was just heard."""
        self.loop = asyncio.new_event_loop()
        self.field = Field()
        self.wire = SlowWire(self.field)
        self.wire.desk = self.field.desk
        self.field.wire = self.wire
        self.field.desk.ledger._sender = self.wire
        self.robot = self.field.weeder
        self.pictures: dict[str, tuple[str, float, datetime]] = {}
        self.requests: list[Sent] = []
        self.numbers = 0
        self.delivered: set[str] = set()
        self.done = 0
        for person in (MARTHA, JONAS):
            self.look(person)

    def run(self, work: Coroutine[Any, Any, R]) -> R:
        """Run until done; nothing here waits for real time."""
        return self.loop.run_until_complete(work)

    @property
    def now_s(self) -> float:
        """True time."""
        return self.field.clock.mono_s()

    @rule(person=PEOPLE)
    def look(self, person: SessionInfo) -> None:
        """A tick reaches a screen."""
        self.pictures[person.session_id] = (self.field.tick(), self.now_s, self.field.clock.utc())

    @rule(person=PEOPLE, action=ACTIONS)
    def decide(self, person: SessionInfo, action: Action) -> None:
        """Somebody slides to confirm; the request leaves the browser."""
        self.numbers += 1
        tick, seen_s, seen_at = self.pictures[person.session_id]
        request = CommandRequest("weeder-01", action, f"command-{self.numbers:06d}", tick)
        self.requests.append(Sent(person, request, seen_s, seen_at))

    @precondition(lambda self: self.requests)
    @rule(data=st.data())
    def deliver(self, data: st.DataObject) -> None:
        """A request reaches the console: now, late, or once more."""
        sent = data.draw(st.sampled_from(self.requests))
        self.submit(sent)

    @precondition(lambda self: self.wire.under_way)
    @rule(data=st.data())
    def arrive(self, data: st.DataObject) -> None:
        """An order reaches the robot: now, late, again, or before an earlier one."""
        self.wire.arrive(data.draw(st.integers(0, len(self.wire.under_way) - 1)))
        self.check_effects()

    @rule(seconds=st.floats(0, 3), hears=st.booleans())
    def wait(self, seconds: float, hears: bool) -> None:
        """Time passes, with or without heartbeats."""
        self.field.wait(seconds, hears=hears)
        self.run(self.field.desk.tend())

    @rule(seconds=st.sampled_from([-86_400.0, -3600.0, 3600.0, 86_400.0]))
    def jump(self, seconds: float) -> None:
        """Somebody sets the console's wall clock."""
        self.field.clock.jump_wall(seconds)

    @rule()
    def reboot(self) -> None:
        """The robot starts anew, with a clock of its own."""
        self.robot.reboot()
        self.robot.beat()

    @rule(person=PEOPLE)
    def stay(self, person: SessionInfo) -> None:
        """A page proves life."""
        self.field.desk.pulse.here(person, "weeder-01", self.pictures[person.session_id][0])

    @rule(person=PEOPLE, op=st.sampled_from(list(LeaseOp)))
    def lease(self, person: SessionInfo, op: LeaseOp) -> None:
        """Somebody asks for control, gives, keeps or returns it."""
        tick = self.pictures[person.session_id][0]
        self.field.desk.leases.operate(person, "weeder-01", op, tick_id=tick, reason="needed")

    @rule()
    def stop(self) -> None:
        """Somebody presses STOP; it reaches the robot at once."""
        self.numbers += 1
        self.robot.press(f"stop-{self.numbers:06d}", "Vera Lang")

    @rule()
    def reset(self) -> None:
        """A supervisor resets everything, on a good link: this must work unless somebody else has control."""
        pressed = tuple(p.stop_id for p in self.robot.presses if not p.is_reset)
        if not pressed:
            return
        self.numbers += 1
        self.robot.beat()
        request = ResetRequest("weeder-01", f"reset-{self.numbers:06d}", pressed, "Test", self.field.tick())
        self.at_once(ANNA, self.field.desk.resets.reset(ANNA, request))
        self.field.desk.leases.end_session(ANNA.session_id)

    @rule(person=PEOPLE, action=ACTIONS)
    def act_on_a_good_link(self, person: SessionInfo, action: Action) -> None:
        """What is decided and delivered at once is carried out, whatever went wrong before."""
        self.look(person)
        self.decide(person, action)
        self.robot.beat()
        sent = self.requests[-1]
        self.delivered.add(sent.request.command_id)
        result = self.at_once(person, self.field.desk.commands.submit(sent.actor, sent.request))
        if self.robot.is_latched and action in MOVING:
            assert result.code in ("latched", "held_by_other")
        elif result.code != "held_by_other":
            assert sent.request.command_id in self.robot.done

    @invariant()
    def one_person_has_control(self) -> None:
        """Every leased order went out under the control of the person it names."""
        if not hasattr(self, "wire"):
            return
        for order, holder in self.wire.under_way:
            if isinstance(order, CommandOrder) and order.action in LEASED_ACTIONS:
                assert order.by == holder

    def submit(self, sent: Sent) -> None:
        """Hand a request to the console and judge its answer."""
        before, owner = len(self.wire.under_way), self.owner()
        is_first = sent.request.command_id not in self.delivered
        self.delivered.add(sent.request.command_id)
        result = self.run(self.field.desk.commands.submit(sent.actor, sent.request))
        age_s = self.now_s - sent.decided_s
        if len(self.wire.under_way) > before:
            assert is_first
            assert age_s <= 2.0
            self.check_control(sent.actor, owner)
        elif is_first:
            wall_s = (self.field.clock.utc() - sent.decided_at).total_seconds()
            was_paused = wall_s > age_s + 60.0  # or somebody set the wall clock forward, which looks the same
            assert (result.code == "stale_tick") == (age_s > 2.0 or was_paused), result

    def at_once(self, person: SessionInfo, work: Coroutine[Any, Any, CommandResult]) -> CommandResult:
        """Run an order with its delivery in one go; it is accepted or refused for a good reason."""
        before, owner = len(self.wire.under_way), self.owner()
        result = self.run(work)
        if len(self.wire.under_way) > before:
            assert result.outcome is Outcome.TIMED_OUT  # the wire held it
            self.check_control(person, owner)
            self.wire.arrive(len(self.wire.under_way) - 1)
            self.check_effects()
            event = self.field.events_of("command")[-1]
            assert (event["outcome"], event["is_late"]) == ("accepted", True), event
        else:
            lease = self.field.desk.leases.of("weeder-01")
            is_held = lease is not None and lease.holder.session_id != person.session_id
            assert result.code == "latched" or (result.code == "held_by_other" and is_held), result
        return result

    def owner(self) -> str | None:
        """Return whose robot it is now, after what STOP revoked."""
        self.field.desk.leases.observe(self.robot.known())
        lease = self.field.desk.leases.of("weeder-01")
        return lease.holder.session_id if lease is not None else None

    def check_control(self, person: SessionInfo, owner: str | None) -> None:
        """An order that needs control took it from nobody."""
        order = self.wire.under_way[-1][0]
        if not isinstance(order, CommandOrder) or order.action in LEASED_ACTIONS:
            assert owner in (None, person.session_id)

    def check_effects(self) -> None:
        """Nothing was carried out twice, and nothing that is late."""
        assert len(self.robot.done) == len(set(self.robot.done))
        decided = {s.request.command_id: s.decided_s for s in self.requests}
        for command_id in self.robot.done[self.done :]:
            if command_id in decided:
                assert self.now_s - decided[command_id] <= LATE_S, command_id
        self.done = len(self.robot.done)

    def teardown(self) -> None:
        """End what still waits."""
        if hasattr(self, "loop"):
            self.run(self.field.desk.close())
            self.loop.close()


TestRace = Race.TestCase
TestRace.settings = settings(max_examples=40, stateful_step_count=40, deadline=None)
