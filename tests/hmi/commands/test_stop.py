"""The console's second path for STOP."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from typing import Any

import pytest

from hmi.clock import FakeClock
from hmi.commands.stop import StopService
from hmi.domain.command import Acknowledgement, Order, StopOrder
from hmi.domain.robot import Press, SafetyState, Stamp
from hmi.domain.stop import StopTarget

STOP_ID = "a" * 32


class FakeSender:
    """Remembers what left; answers by HTTP if told to."""

    def __init__(self) -> None:
        self.is_up = True
        self.sent: list[StopOrder] = []
        self.by_http: list[StopOrder] = []
        self.http_answer: Acknowledgement | None = None
        self.http_hangs = False

    def send(self, order: Order) -> bool:
        assert isinstance(order, StopOrder)
        self.sent.append(order)
        return self.is_up

    async def stop_by_http(self, order: StopOrder) -> Acknowledgement | None:
        self.by_http.append(order)
        if self.http_hangs:
            await asyncio.Event().wait()
        return self.http_answer

    async def upload_mission(self, robot_id: str, document: dict[str, Any]) -> Acknowledgement:
        raise NotImplementedError


class Registry:
    def stop_targets(self) -> Mapping[str, StopTarget]:
        return {name: StopTarget(name, name.title(), 1.0) for name in ("weeder-01", "weeder-02")}


class Field:
    """One service with everything around it."""

    def __init__(self) -> None:
        self.clock, self.sender = FakeClock(), FakeSender()
        self.revoked: list[tuple[str, str, str]] = []
        self.service = StopService(
            self.sender, self.clock, Registry(), on_press=lambda *told: self.revoked.append(told)
        )

    def press(self, robots: Any = ("weeder-01",), stop_id: str = STOP_ID) -> list[dict[str, Any]]:
        return self.service.press(stop_id, robots, "Martha", "Tablet 3")

    def ack(self, robot: str = "weeder-01", code: str = "ok") -> Acknowledgement:
        now_s = self.clock.mono_s()
        return Acknowledgement(robot, "stop", STOP_ID, code == "ok", code, "", 0.4, None, Stamp(now_s, now_s))

    def report(self, robot: str = "weeder-01", *, standstill: bool = True, is_reset: bool = False) -> None:
        now_s = self.clock.mono_s()
        presses = (Press(STOP_ID, "Martha", "Tablet 3", now_s, is_reset),)
        state = SafetyState(
            False, not is_reset, standstill, 0.0 if standstill else 0.4, True, presses, 0.2, Stamp(now_s, now_s)
        )
        self.service.on_safety(robot, state)

    def state(self, robot: str = "weeder-01") -> str:
        return next(s["state"] for s in self.service.steps(STOP_ID) if s["robot"] == robot)


@pytest.fixture
async def field() -> Field:
    return Field()


async def test_a_press_leaves_on_both_paths_before_it_returns(field: Field) -> None:
    steps = field.press()
    assert [order.robot_id for order in field.sender.sent] == ["weeder-01"]
    assert (steps[0]["state"], steps[0]["sent_ms"], steps[0]["name"]) == ("sent", 0, "Weeder-01")
    await asyncio.sleep(0)
    assert [order.stop_id for order in field.sender.by_http] == [STOP_ID]
    await field.service.close()


async def test_it_is_acknowledged_confirmed_and_then_empties_itself(field: Field) -> None:
    field.press()
    field.clock.advance(0.2)
    field.service.on_ack(field.ack())
    assert field.state() == "acknowledged"
    field.clock.advance(0.8)
    field.report()
    assert field.state() == "standstill"
    copies = len(field.sender.sent)
    for _ in range(20):
        field.clock.advance(1)
        field.service.pulse()
    assert len(field.sender.sent) == copies
    field.report(is_reset=True)
    assert field.state() == "reset"
    field.press()
    assert len(field.sender.sent) == copies  # a press that was reset never latches again


async def test_a_step_tells_how_old_the_proof_is_and_which_run_of_the_console_counts_its_age(field: Field) -> None:
    assert field.press()[0]["safety_ms"] is None
    field.report()
    field.clock.advance(0.7)
    (step,) = field.service.steps(STOP_ID)
    assert (step["state"], step["age_ms"], step["safety_ms"]) == ("standstill", 700, 700)
    assert field.press()[0]["boot"] == step["boot"]
    assert Field().press()[0]["boot"] != step["boot"]


async def test_copies_go_until_standstill_and_limits_run_out_by_the_monotonic_clock(field: Field) -> None:
    field.press()
    field.clock.jump_wall(-3600)
    for _ in range(100):
        field.clock.advance(0.01)
        field.service.pulse()
    assert len(field.sender.sent) in (5, 6)  # at 0 and every 0.2 s of one second
    field.clock.advance(0.01)
    assert field.state() == "not-confirmed"


async def test_all_means_every_registered_robot_and_whoever_else_was_heard_lately(field: Field) -> None:
    field.report("gone-1", standstill=False)
    field.clock.advance(60.001)
    field.report("stranger-1", standstill=False)
    names = {step["robot"]: step["name"] for step in field.press("all")}
    assert names == {
        "weeder-01": "Weeder-01",
        "weeder-02": "Weeder-02",
        "stranger-1": "stranger-1 (not registered)",
    }
    assert {order.robot_id for order in field.sender.sent} == set(names)


async def test_all_means_a_robot_with_an_open_press_too_however_long_ago_it_was_heard(field: Field) -> None:
    field.report("stranger-1", standstill=False)
    field.press("all")
    field.clock.advance(3600)
    assert "stranger-1" in {step["robot"] for step in field.press("all", stop_id="b" * 32)}
    await field.service.close()


async def test_a_robot_that_nobody_registered_can_be_stopped_and_a_bad_id_cannot_reach_the_wire(field: Field) -> None:
    steps = field.press(["stranger-1", "../x", "+", "stranger-1"])
    assert [step["robot"] for step in steps] == ["stranger-1"]


async def test_without_the_broker_the_answer_by_http_counts(field: Field) -> None:
    field.sender.is_up = False
    field.sender.http_answer = field.ack()
    field.press()
    await asyncio.sleep(0)
    assert field.state() == "acknowledged"
    assert field.service.steps(STOP_ID)[0]["paths"] == {"mqtt": 0, "http": 1}


async def test_a_robot_that_does_not_answer_http_collects_no_more_than_a_few_requests(field: Field) -> None:
    field.sender.http_hangs = True
    field.press()
    for _ in range(50):
        field.clock.advance(0.2)
        field.service.pulse()
        await asyncio.sleep(0)
    assert len(field.sender.by_http) <= 3
    assert len(field.sender.sent) > 40
    field.press(stop_id="b" * 32)
    await asyncio.sleep(0)
    assert field.sender.by_http[-1].stop_id == "b" * 32  # a new press never waits behind old copies
    await field.service.close()


async def test_a_new_press_is_told_once_for_each_robot_so_that_leases_end(field: Field) -> None:
    field.press("all")
    field.press("all")
    assert field.revoked == [("weeder-01", STOP_ID, "Martha"), ("weeder-02", STOP_ID, "Martha")]


async def test_answers_to_other_orders_change_nothing(field: Field) -> None:
    field.press()
    now_s = field.clock.mono_s()
    field.service.on_ack(
        Acknowledgement("weeder-01", "command", STOP_ID, True, "ok", "", None, None, Stamp(now_s, now_s))
    )
    assert field.state() == "sent"


async def test_the_task_sends_what_is_due_and_ends_when_cancelled(field: Field) -> None:
    task = asyncio.create_task(field.service.run())
    field.press()
    await asyncio.sleep(0)
    field.clock.advance(0.3)
    field.service.on_return("weeder-01")
    for _ in range(5):
        await asyncio.sleep(0)  # the task's turn
    assert len(field.sender.sent) == 2
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task
    await field.service.close()


async def test_one_robot_that_cannot_be_sent_to_or_told_of_keeps_stop_from_no_other(field: Field) -> None:
    send, told = field.sender.send, field.revoked

    def fails(order: Order) -> bool:
        if order.robot_id == "weeder-01":
            raise OSError("no")
        return send(order)

    def refuses(robot_id: str, stop_id: str, by: str) -> None:
        if robot_id == "weeder-01":
            raise RuntimeError("no")
        told.append((robot_id, stop_id, by))

    field.sender.send = fails  # type: ignore[method-assign]
    service = StopService(field.sender, field.clock, Registry(), on_press=refuses)
    steps = service.press(STOP_ID, "all", "Martha", "Tablet 3")
    await asyncio.sleep(0)
    assert [order.robot_id for order in field.sender.sent] == ["weeder-02"]
    assert sorted(order.robot_id for order in field.sender.by_http) == ["weeder-01", "weeder-02"]
    assert told == [("weeder-02", STOP_ID, "Martha")]
    assert {step["robot"]: step["sent_ms"] for step in steps} == {"weeder-01": None, "weeder-02": 0}
    await service.close()


async def test_a_round_that_fails_is_not_the_last_one(field: Field, monkeypatch: pytest.MonkeyPatch) -> None:
    targets, has_failed, goes_on = Registry.stop_targets, asyncio.Event(), asyncio.Event()

    def once(self: Registry) -> Mapping[str, StopTarget]:
        if not has_failed.is_set():
            has_failed.set()
            raise RuntimeError("no")
        goes_on.set()
        return targets(self)

    task = asyncio.create_task(field.service.run())
    await asyncio.sleep(0)
    monkeypatch.setattr(Registry, "stop_targets", once)
    field.clock.advance(60)
    field.service.on_return("weeder-01")  # wakes it
    await asyncio.wait_for(has_failed.wait(), 5)
    field.clock.advance(60)
    field.press()
    await asyncio.wait_for(goes_on.wait(), 5)
    copies = len(field.sender.sent)
    field.clock.advance(0.3)
    while len(field.sender.sent) == copies:
        assert not task.done()
        await asyncio.sleep(0)
    task.cancel()
    await field.service.close()
