"""A mission that a person sent and nobody started gives way to the queue only when a person says so."""

from __future__ import annotations

from datetime import timedelta

import pytest

from hmi.commands.refusal import OrderRefused
from hmi.domain.queue.entry import Entry
from hmi.domain.robot import Mode, OrderStatus
from hmi.domain.role import Role
from hmi.security.errors import NotAllowed
from tests.hmi.commands.field import person
from tests.hmi.queue.rig import MORNING, PIETER, QueueFarm


async def waiting(farm: QueueFarm) -> Entry:
    """A person's mission lies on the robot, the queue's waits behind it."""
    await farm.desk.missions.send(PIETER, "weeder-01", "wheat-3")
    await farm.step(2)
    entry = await farm.add("wheat-1")
    await farm.step(2)
    assert farm.code(entry) == "holds_other"
    return entry


async def test_it_is_replaced_and_nothing_starts_that_was_armed_before(farm: QueueFarm) -> None:
    await waiting(farm)
    await farm.arm()
    await farm.queue.handover.take_off(PIETER, "weeder-01", "wheat-3")
    assert not farm.is_armed()
    await farm.step(20)
    assert (farm.weeder.holds, farm.weeder.starts) == ("wheat-1", [])
    assert farm.status("wheat-3") == "validated"
    assert farm.kept.audit.outcomes("queue")[-1] == "taken_off"
    await farm.arm()
    await farm.step(3)
    assert [one.mission_id for one in farm.weeder.starts] == ["wheat-1"]


async def test_until_its_turn_has_come_the_other_one_stays_on_the_robot(farm: QueueFarm) -> None:
    await farm.desk.missions.send(PIETER, "weeder-01", "wheat-3")
    await farm.step(2)
    await farm.add("wheat-1", earliest=MORNING + timedelta(minutes=10))
    await farm.queue.handover.take_off(PIETER, "weeder-01", "wheat-3")
    await farm.step(30)
    assert farm.weeder.holds == "wheat-3"
    await farm.step(600, stride_s=10)
    assert farm.weeder.holds == "wheat-1"


async def test_sent_once_more_it_is_wanted_again(farm: QueueFarm) -> None:
    await farm.desk.missions.send(PIETER, "weeder-01", "wheat-3")
    await farm.step(2)
    entry = await farm.add("wheat-1", earliest=MORNING + timedelta(minutes=10))
    await farm.queue.handover.take_off(PIETER, "weeder-01", "wheat-3")
    await farm.step(5)
    await farm.desk.missions.send(PIETER, "weeder-01", "wheat-3")
    await farm.step(620, stride_s=10)
    assert (farm.weeder.holds, farm.code(entry)) == ("wheat-3", "holds_other")


async def test_a_restart_asks_a_person_again(farm: QueueFarm) -> None:
    await farm.desk.missions.send(PIETER, "weeder-01", "wheat-3")
    await farm.step(2)
    entry = await farm.add("wheat-1", earliest=MORNING + timedelta(minutes=10))
    await farm.queue.handover.take_off(PIETER, "weeder-01", "wheat-3")
    await farm.again()
    await farm.step(620, stride_s=10)
    assert farm.code(entry) == "holds_other"


async def test_what_was_started_or_is_not_there_or_keeps_nobody_waiting_stays(farm: QueueFarm) -> None:
    await waiting(farm)
    with pytest.raises(OrderRefused, match="does not hold it"):
        await farm.queue.handover.take_off(PIETER, "weeder-01", "wheat-2")
    farm.weeder.tell(OrderStatus.RUNNING, Mode.AUTO)
    with pytest.raises(OrderRefused, match="it was started"):
        await farm.queue.handover.take_off(PIETER, "weeder-01", "wheat-3")


async def test_without_a_queue_there_is_nothing_to_give_way_to(farm: QueueFarm) -> None:
    await farm.desk.missions.send(PIETER, "weeder-01", "wheat-3")
    await farm.step(2)
    with pytest.raises(OrderRefused, match="Nothing waits"):
        await farm.queue.handover.take_off(PIETER, "weeder-01", "wheat-3")


async def test_it_needs_what_sending_needs(farm: QueueFarm) -> None:
    await waiting(farm)
    with pytest.raises(NotAllowed):
        await farm.queue.handover.take_off(person("Vera Lang", Role.VIEWER), "weeder-01", "wheat-3")
    with pytest.raises(NotAllowed, match="new here"):
        await farm.queue.handover.take_off(PIETER, "weeder-09", "wheat-3")
