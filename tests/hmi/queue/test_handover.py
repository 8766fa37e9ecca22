"""A mission that a person sent and nobody started gives way to the queue only when a person says so."""

from __future__ import annotations

from dataclasses import replace
from datetime import timedelta

import pytest

from hmi.commands.refusal import OrderRefused
from hmi.domain.queue.entry import Entry
from hmi.domain.robot import Mode, OrderStatus
from hmi.domain.role import Role
from hmi.security.errors import NotAllowed
from tests.hmi.commands.field import person
from tests.hmi.queue.rig import EASY, MORNING, PIETER, QueueFarm
from tests.hmi.queue.test_rest import browser


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


@pytest.mark.parametrize("is_still_queued", [False, True])
async def test_what_a_person_sent_stays_although_it_stands_or_stood_in_the_queue(
    farm: QueueFarm, *, is_still_queued: bool
) -> None:
    other = await farm.add("wheat-3", earliest=MORNING + timedelta(hours=5))
    if not is_still_queued:
        await farm.queue.book.remove(PIETER, other.id)
    entry = await farm.add("wheat-1", earliest=MORNING + timedelta(minutes=1))
    await farm.arm()
    await farm.desk.missions.send(PIETER, "weeder-01", "wheat-3")
    await farm.step(90, stride_s=5)
    assert (farm.weeder.holds, farm.weeder.starts) == ("wheat-3", [])
    assert farm.why(entry) == "Weeder 01 holds Wheat 3, which nobody started. Start it there, or take it off."
    async with browser(farm, Role.OPERATOR) as client:
        [robot] = (await client.get("/queue")).json()["robots"]
    assert robot["holds"] == {"mission_id": "wheat-3", "name": "Wheat 3"}


async def test_what_the_robot_told_before_it_took_a_persons_mission_says_nothing_of_what_it_holds(
    farm: QueueFarm,
) -> None:
    entry = await farm.add("wheat-1", earliest=MORNING + timedelta(seconds=10))
    await farm.arm()
    await farm.step(9)
    await farm.desk.missions.send(PIETER, "weeder-01", "wheat-3")
    await farm.step(1, hears=False)
    assert farm.code(entry) == "state_unknown"
    await farm.step(1)
    assert (farm.weeder.holds, farm.code(entry)) == ("wheat-3", "holds_other")


async def test_what_the_queue_sent_it_replaces_until_somebody_sends_it_once_more(farm: QueueFarm) -> None:
    first, second = await farm.add("wheat-1", is_unattended=False), await farm.add("wheat-2", is_unattended=False)
    await farm.step(2)
    await farm.queue.book.remove(PIETER, first.id)
    await farm.step(2)
    assert farm.weeder.holds == "wheat-2"
    await farm.desk.missions.send(PIETER, "weeder-01", "wheat-2")
    third = await farm.add("wheat-3")
    await farm.queue.book.remove(PIETER, second.id)
    await farm.step(20)
    assert (farm.weeder.holds, farm.code(third)) == ("wheat-2", "holds_other")


async def test_after_a_restart_an_entry_knows_its_own_mission_and_no_other_replaces_it(farm: QueueFarm) -> None:
    first, second = await farm.add("wheat-1"), await farm.add("wheat-2")
    await farm.step(2)
    await farm.again()
    await farm.step(2)
    assert (farm.code(first), farm.code(second)) == ("not_armed", "not_first")
    async with browser(farm, Role.OPERATOR) as client:
        [robot] = (await client.get("/queue")).json()["robots"]
        assert robot["holds"] is None
    await farm.queue.book.remove(PIETER, first.id)
    await farm.step(20)
    assert (farm.weeder.holds, farm.code(second)) == ("wheat-1", "holds_other")
    await farm.queue.handover.take_off(PIETER, "weeder-01", "wheat-1")
    await farm.step(2)
    assert farm.weeder.holds == "wheat-2"


async def test_a_person_who_replaces_what_the_queue_sent_disarms_it(farm: QueueFarm) -> None:
    other = await farm.add("wheat-3")
    await farm.queue.book.remove(PIETER, other.id)
    await farm.add("wheat-1", conditions=replace(EASY, needs_daylight=True, after_sunrise_s=6 * 3600))
    await farm.step(2)
    await farm.arm()
    await farm.step(2)
    assert (farm.weeder.holds, farm.is_armed()) == ("wheat-1", True)
    await farm.desk.missions.send(PIETER, "weeder-01", "wheat-3")
    await farm.step(5)
    assert farm.disarmed() == "The robot does not have Wheat 1 any more."


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
