"""Freshness, lease, sequence and idempotency under every disorder a network can make.

The model below is written from docs/protocols/edge.md alone and shares no code with the robot.
"""

from __future__ import annotations

import uuid
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from backend_clients.edge import messages_down as down
from tests.backend_clients.simulator.rig import Rig, small_mission


@dataclass
class Model:
    """What the contract says the robot must think."""

    issued_s: dict[str, float] = field(default_factory=dict)
    highest: int = 0
    revoked: int = 0
    last_seq: int = -1
    answers: dict[str, tuple[str, str]] = field(default_factory=dict)
    is_latched: bool = False
    is_open: bool = False
    opened: int = 0

    def must_accept(self, order: down.Command, now_s: float) -> bool:
        issued_s = self.issued_s.get(order.challenge)
        if issued_s is None or now_s - issued_s > min(2.0, order.ttl_ms / 1000):
            return False
        if order.lease_token <= self.revoked or order.lease_token < self.highest:
            return False
        return order.lease_token > self.highest or order.lease_seq > self.last_seq

    def adopt(self, order: down.Command) -> None:
        self.highest, self.last_seq = order.lease_token, order.lease_seq


class DisorderlyNetwork(RuleBasedStateMachine):
    """Sends, holds back, doubles, reorders and replays orders while clocks run and jump."""

    def __init__(self) -> None:
        super().__init__()
        self.rig = Rig()
        self.model = Model()
        self.in_flight: list[down.Command] = []
        self.heard: list[str] = []
        self.stops: list[str] = []
        self.token, self.seq = 1, 0
        self.distance = self.rig.robot.machine.base.distance_m

    @rule()
    def heartbeat(self) -> None:
        challenge = self.rig.challenge()
        self.model.issued_s[challenge] = self.rig.clock.mono_s()
        self.heard.append(challenge)

    @precondition(lambda self: self.heard)
    @rule(is_open=st.booleans(), back=st.integers(0, 3), ttl_ms=st.sampled_from([300, 2000, 10_000]))
    def send(self, is_open: bool, back: int, ttl_ms: int) -> None:
        self.seq += 1
        self.in_flight.append(
            down.Command(
                robot="weeder-01",
                command_id=uuid.uuid4().hex,
                action="drive_open" if is_open else "drive_close",
                by="Martha",
                lease_token=self.token,
                lease_seq=self.seq,
                ttl_ms=ttl_ms,
                challenge=self.heard[max(len(self.heard) - 1 - back, 0)],
            )
        )

    @precondition(lambda self: self.in_flight)
    @rule(data=st.data(), is_copy=st.booleans())
    def deliver(self, data: st.DataObject, is_copy: bool) -> None:
        index = data.draw(st.integers(0, len(self.in_flight) - 1))
        order = self.in_flight[index] if is_copy else self.in_flight.pop(index)
        ack = self.rig.robot.receive(order)
        assert ack is not None
        assert ack.ref == order.command_id
        answer = (ack.outcome, ack.code)
        if order.command_id in self.model.answers:
            assert answer == self.model.answers[order.command_id], "a repeat gets the same answer"
            return
        self.model.answers[order.command_id] = answer
        if not self.model.must_accept(order, self.rig.clock.mono_s()):
            assert ack.outcome == "rejected"
            assert ack.text
            return
        self.model.adopt(order)
        if order.action == "drive_open" and self.model.is_latched:
            assert answer == ("rejected", "stop_latched")
            return
        assert ack.outcome == "accepted", f"fresh, in order, leased, and yet {ack.code}"
        if order.action == "drive_open" and not self.model.is_open:
            self.model.opened += 1
        self.model.is_open = order.action == "drive_open"

    @rule(seconds=st.sampled_from([0.01, 0.09, 0.31, 0.77, 1.9, 2.3]))
    def time_passes(self, seconds: float) -> None:
        self.rig.clock.advance(seconds)

    @rule(seconds=st.sampled_from([-3600.0, 3600.0, 86_400.0, -0.5]))
    def wall_clock_jumps(self, seconds: float) -> None:
        self.rig.clock.jump_wall(seconds)

    @rule()
    def lease_changes_hands(self) -> None:
        self.token, self.seq = self.token + 1, 0

    @rule(is_new=st.booleans())
    def stop(self, is_new: bool) -> None:
        if is_new or not self.stops:
            self.stops.append(uuid.uuid4().hex)
            self.model.is_latched, self.model.is_open = True, False
            self.model.revoked = self.model.highest
        assert self.rig.stop(self.stops[-1]).outcome == "accepted"

    @precondition(lambda self: self.stops and self.model.is_latched)
    @rule()
    def reset(self) -> None:
        self.token, self.seq = max(self.token, self.model.highest) + 1, 1
        challenge = self.rig.challenge()
        self.model.issued_s[challenge] = self.rig.clock.mono_s()
        ack = self.rig.robot.receive(
            down.StopReset(
                robot="weeder-01",
                reset_id=uuid.uuid4().hex,
                stop_ids=self.stops[-64:],
                by="Martha",
                reason="Test",
                lease_token=self.token,
                lease_seq=self.seq,
                challenge=challenge,
            )
        )
        assert ack is not None
        assert ack.code == "ok"
        self.model.highest, self.model.last_seq, self.model.is_latched = self.token, self.seq, False

    @invariant()
    def robot_is_as_the_model_says(self) -> None:
        events = self.rig.robot.take_events()
        self.rig.events += events
        opened = sum(event.name == "Driving by hand" for event in self.rig.events)
        assert opened == self.model.opened, "each accepted order acts exactly once"
        assert self.rig.safety.latched == self.model.is_latched
        assert (self.rig.state.mode == "manual") == self.model.is_open
        assert self.rig.robot.machine.base.distance_m == self.distance


DisorderlyNetwork.TestCase.settings = settings(max_examples=60, stateful_step_count=40, deadline=None)
TestDisorderlyNetwork = DisorderlyNetwork.TestCase


def test_an_order_echoing_a_challenge_older_than_two_seconds_is_not_carried_out() -> None:
    rig = Rig()
    late = rig.order("drive_open")
    rig.clock.advance(2.01)
    ack = rig.robot.receive(late)
    assert ack is not None
    assert (ack.code, rig.state.mode) == ("stale_challenge", "idle")


def test_an_order_is_not_carried_out_after_its_time_to_live() -> None:
    rig = Rig()
    short = rig.order("drive_open", ttl_ms=500)
    rig.clock.advance(0.6)
    ack = rig.robot.receive(short)
    assert ack is not None
    assert ack.code == "expired"


def test_a_challenge_of_an_earlier_boot_is_worth_nothing() -> None:
    rig = Rig()
    order = rig.order("drive_open")
    rig.robot.crash(0.0)
    rig.robot.step(0.05)
    ack = rig.robot.receive(order)
    assert ack is not None
    assert ack.code == "stale_challenge"


@pytest.mark.parametrize("action", ["start", "resume", "return_home", "drive_open", "drive_close"])
def test_what_can_move_the_machine_needs_a_lease(action: str) -> None:
    assert Rig().do(action, lease_token=0).code == "no_lease"


def test_retained_orders_are_refused_but_a_retained_stop_stops() -> None:
    rig = Rig()
    order = rig.order("drive_open")
    ack = rig.robot.receive(order, is_retained=True)
    assert ack is not None
    assert ack.code == "retained"
    mission = rig.robot.receive(small_mission(), is_retained=True)
    assert mission is not None
    assert mission.code == "retained"
    rig.robot.receive(down.Stop(robot="weeder-01", stop_id="stop-000009", by="Anna"), is_retained=True)
    assert rig.safety.latched


def test_an_older_lease_cannot_act_once_a_newer_one_was_seen() -> None:
    rig = Rig()
    rig.token = 5
    rig.pulse()
    assert rig.do("drive_open", lease_token=4).code == "old_lease"


def test_the_lease_fence_survives_a_reboot(tmp_path: Path) -> None:
    rig = Rig(tmp_path)
    rig.token = 7
    rig.do("drive_open")
    rig.restart_process()
    assert rig.do("drive_open", lease_token=6).code == "old_lease"


def test_operator_pulses_of_a_revoked_lease_keep_nothing_running() -> None:
    rig = Rig()
    rig.start()
    rig.run(5)
    rig.stop()
    rig.run(2)
    rig.reset()
    rig.do("resume")
    rig.token -= 1
    rig.run(4)
    assert rig.state.hold is not None
    assert rig.state.hold.code == "operator_lost"


def test_a_flood_of_orders_is_refused_before_anything_is_forgotten() -> None:
    rig = Rig()
    first = rig.order("drive_open")
    rig.robot.receive(first)
    codes = set()
    for _ in range(4200):
        ack = rig.robot.receive(rig.order("drive_close"))
        assert ack is not None
        codes.add(ack.code)
    assert "busy" in codes
    again = rig.robot.receive(first)
    assert again is not None
    assert (again.code, rig.state.mode) == ("ok", "idle")
