"""A mission in one robot's queue is that robot's, and a queue takes only what its robot can drive."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hmi.commands.refusal import OrderRefused
from hmi.domain.command import Outcome
from hmi.domain.mission_plan import MissionRefused
from hmi.domain.planned_machine import MACHINE
from hmi.domain.role import Role
from tests.hmi.commands.field import FARM, factsheet, person
from tests.hmi.queue.rig import PIETER, QueueFarm

PLANNER = person("Petra Vos", Role.PLANNER)
TAKEN = "It stands in the queue of Weeder 01. Take it out there, or copy it."


@pytest.fixture
def two(farm: QueueFarm) -> QueueFarm:
    """Return the farm with a second robot."""
    farm.put_robot("weeder-02", "Weeder 02")
    return farm


async def test_it_is_sent_to_no_other_robot_while_it_waits(two: QueueFarm) -> None:
    entry = await two.add("wheat-1")
    sent = await two.desk.missions.send(PIETER, "weeder-02", "wheat-1")
    assert (sent.outcome, sent.code, sent.text) == (Outcome.REJECTED, "in_queue", TAKEN)
    assert two.robots["weeder-02"].holds is None
    await two.queue.book.remove(PIETER, entry.id)
    assert (await two.desk.missions.send(PIETER, "weeder-02", "wheat-1")).outcome is Outcome.ACCEPTED


async def test_nor_when_its_own_robot_has_it(two: QueueFarm) -> None:
    await two.add("wheat-1")
    await two.step(3)
    assert two.weeder.holds == "wheat-1"
    sent = await two.desk.missions.send(PIETER, "weeder-02", "wheat-1")
    assert sent.code == "in_queue"
    await two.arm()
    await two.step(3)
    assert [one.mission_id for one in two.weeder.starts] == ["wheat-1"]


async def test_nor_is_it_given_to_another_one(two: QueueFarm) -> None:
    await two.add("wheat-1")
    with pytest.raises(MissionRefused) as caught:
        await two.book.change(PLANNER, "wheat-1", robot_id="weeder-02")
    assert (caught.value.code, caught.value.text) == ("in_queue", TAKEN)
    assert (await two.book.change(PLANNER, "wheat-2", robot_id="weeder-02")).robot_id == "weeder-02"


async def test_a_queue_takes_no_mission_of_a_smaller_machine(two: QueueFarm) -> None:
    two.weeder.factsheet = factsheet()
    two.robots["weeder-02"].factsheet = replace(factsheet(), width_m=3.4)
    # planned for what the first one is
    known = two.missions.known("wheat-1")
    assert known is not None
    figures = {key: value for key, value in known.statistics.items() if key != MACHINE}
    two.missions.change(FARM, "wheat-1", lambda _s, one, document: (replace(one, statistics=figures), document), "", "")
    with pytest.raises(OrderRefused, match=r"planned for Weeder 01, which is smaller\. Plan .* Weeder 02") as caught:
        await two.add("wheat-1", robot_id="weeder-02")
    assert caught.value.code == "other_machine"
    assert two.status("wheat-1") == "validated"
    assert await two.add("wheat-1")


async def test_what_waited_for_a_robot_that_was_taken_out_is_free_again(two: QueueFarm) -> None:
    for mission_id in ("wheat-1", "wheat-2"):
        await two.add(mission_id)
    await two.queue.book.robots_removed({"weeder-01"})
    assert two.queue.store.entries("weeder-01") == []
    assert two.status("wheat-1") == "validated"
    assert (await two.desk.missions.send(PIETER, "weeder-02", "wheat-1")).outcome is Outcome.ACCEPTED


async def test_what_was_stuck_with_a_robot_that_is_gone_is_free_after_the_next_start(two: QueueFarm) -> None:
    await two.add("wheat-1")
    two.kept.robots.remove("weeder-01")
    await two.again()
    assert two.queue.store.entries("weeder-01") == []
    assert two.status("wheat-1") == "validated"


async def test_an_old_mission_fits_its_first_robot_also_after_it_stood_in_the_queue_of_a_smaller_one(
    two: QueueFarm,
) -> None:
    two.weeder.factsheet = factsheet()
    two.robots["weeder-02"].factsheet = replace(factsheet(), width_m=factsheet().width_m - 0.4)
    known = two.missions.known("wheat-1")
    assert known is not None
    figures = {key: value for key, value in known.statistics.items() if key != MACHINE}
    two.missions.change(FARM, "wheat-1", lambda _s, one, document: (replace(one, statistics=figures), document), "", "")
    entry = await two.add("wheat-1", robot_id="weeder-02")
    await two.queue.book.remove(PIETER, entry.id)
    assert (await two.desk.missions.send(PIETER, "weeder-01", "wheat-1")).outcome is Outcome.ACCEPTED
