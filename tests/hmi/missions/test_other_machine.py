"""A mission goes to another robot only if that one can drive what was planned for the first."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from hmi.commands.mission_send import MissionSender
from hmi.commands.plan_wish import PlanOrder
from hmi.commands.refusal import OrderRefused
from hmi.domain.mission_plan import MissionRefused
from hmi.domain.planned_machine import MACHINE, PlannedMachine, battery_share_on
from hmi.domain.robot import Factsheet, Family
from hmi.domain.role import Role
from hmi.store.missions import Mission
from tests.hmi.missions.rig import FARM, Rig, weeder
from tests.hmi.missions.test_rest_book import Wire
from tests.hmi.missions.test_store import put
from tests.hmi.presenters.robots import SHEET

HERE = replace(SHEET, datum_lat_deg=51.78, datum_lon_deg=4.26, battery_wh=4000.0)
BIG = replace(HERE, length_m=5.0, width_m=3.4, base_to_front_m=4.0)
KITE = replace(HERE, family=Family.UAV, length_m=0.9, width_m=0.9, base_to_front_m=0.45, max_speed_mps=8.0,
               tool_kind="camera", tool_width_m=20.0)  # fmt: skip
"""Smaller, faster and nimbler than any machine on the ground, and it works wider."""
REFUSED = "It was planned for Weeder 01, which is smaller. Plan the mission for Weeder 02."


def machines(rig: Rig, *sheets: Factsheet) -> None:
    for number, sheet in enumerate(sheets, 1):
        robot_id = f"weeder-{number:02}"
        known = rig.fleet.robots.get(robot_id) or weeder(robot_id, f"Weeder {number:02}")
        rig.fleet.robots[robot_id] = replace(known, factsheet=sheet)


async def planned(rig: Rig, *sheets: Factsheet) -> Mission:
    machines(rig, *sheets)
    return await rig.book.plan(rig.person(Role.PLANNER), PlanOrder("field-1", "weeder-01", 3.0))


async def given(rig: Rig, mission: Mission, robot_id: str) -> Mission:
    return await rig.book.change(rig.person(Role.PLANNER), mission.id, robot_id=robot_id)


async def test_a_larger_robot_neither_gets_nor_is_sent_it(rig: Rig) -> None:
    mission = await planned(rig, HERE, BIG)
    with pytest.raises(MissionRefused) as caught:
        await given(rig, mission, "weeder-02")
    assert (caught.value.code, caught.value.text) == ("other_machine", REFUSED)
    wire: Any = Wire(rig)
    sender = MissionSender(wire, rig.book, wire, rig.audit, lambda _event: None)
    sent = await sender.send(rig.person(Role.SUPERVISOR), "weeder-02", mission.id)
    assert (sent.outcome.value, sent.code, sent.text) == ("rejected", "other_machine", REFUSED)
    assert wire.sent == []
    sent = await sender.send(rig.person(Role.SUPERVISOR), "weeder-01", mission.id)
    assert sent.outcome.value == "accepted"


async def test_a_weeders_mission_goes_to_no_uav(rig: Rig) -> None:
    mission = await planned(rig, HERE, KITE)
    wire: Any = Wire(rig)
    sender = MissionSender(wire, rig.book, wire, rig.audit, lambda _event: None)
    sent = await sender.send(rig.person(Role.SUPERVISOR), "weeder-02", mission.id)
    text = "It was planned for Weeder 01, which is another kind of machine. Plan the mission for Weeder 02."
    assert (sent.code, sent.text, wire.sent) == ("other_machine", text, [])


async def test_rows_nearer_than_the_tool_is_wide_ask_for_no_more(rig: Rig) -> None:
    machines(rig, HERE)
    near = await rig.book.plan(rig.person(Role.PLANNER), PlanOrder("field-1", "weeder-01", 1.0))
    machine = PlannedMachine.from_json(near.statistics[MACHINE])
    assert machine is not None
    assert machine.ahead_of(replace(HERE, tool_width_m=1.2)) == ""


async def test_what_a_mission_of_before_does_not_say_is_not_compared(rig: Rig) -> None:
    kept = {**(await planned(rig, HERE)).statistics[MACHINE], "family": None}
    del kept["tool_width_m"]
    machine = PlannedMachine.from_json(kept)
    assert machine is not None
    assert machine.ahead_of(replace(KITE, tool_width_m=0.5)) == ""


async def test_a_copy_knows_the_machine_too(rig: Rig) -> None:
    mission = await planned(rig, HERE, BIG)
    copy = await rig.book.copy(rig.person(Role.PLANNER), mission.id)
    with pytest.raises(OrderRefused, match="which is smaller"):
        await rig.book.stored(FARM, copy.id, "weeder-02")


@pytest.mark.parametrize(
    ("other", "why"),
    [
        (HERE, ""),
        (replace(HERE, width_m=1.2, length_m=2.0, base_to_front_m=1.0), ""),
        (replace(HERE, width_m=1.9), "is smaller"),
        (replace(HERE, base_to_front_m=1.6), "is smaller"),
        (replace(HERE, base_to_front_m=1.2), "is smaller"),
        (replace(HERE, can_pivot=False), "turns on the spot"),
        (replace(HERE, turning_radius_m=4.0), "turns tighter"),
        (replace(HERE, max_speed_mps=0.3), "drives faster"),
        (replace(HERE, tool_width_m=1.2), "works wider"),
        (replace(HERE, tool_width_m=2.0), ""),
        (replace(HERE, tool_width_m=0.0), ""),
        (KITE, "is another kind of machine"),
    ],
)
async def test_it_fits_a_machine_that_is_no_larger_and_no_less_agile(rig: Rig, other: Factsheet, why: str) -> None:
    mission = await planned(rig, HERE)
    machine = PlannedMachine.from_json(mission.statistics[MACHINE])
    assert machine is not None
    assert machine.turns_on_spot
    assert machine.ahead_of(other) == why


async def test_equal_machines_change_places_and_the_figures_stay(rig: Rig) -> None:
    mission = await planned(rig, HERE, HERE)
    now = await given(rig, mission, "weeder-02")
    assert now.robot_id == "weeder-02"
    assert battery_share_on(now.statistics, HERE) == mission.statistics["battery_share"]


async def test_the_battery_is_that_of_the_robot_it_goes_to(rig: Rig) -> None:
    figures = (await planned(rig, HERE)).statistics
    half = replace(HERE, battery_wh=2000.0)
    assert battery_share_on(figures, half) == pytest.approx(2 * figures["battery_share"], rel=0.01)
    assert battery_share_on(figures, replace(HERE, battery_wh=None)) is None
    assert battery_share_on(figures, replace(HERE, family=Family.PLANTER)) is None


async def test_a_mission_that_does_not_tell_its_machine_was_planned_for_the_robot_it_is_for(rig: Rig) -> None:
    machines(rig, HERE, BIG, replace(HERE, width_m=1.5), replace(HERE, width_m=1.7))
    mission = put(rig)
    rig.missions.change(
        FARM,
        mission.id,
        lambda _s, one, document: (replace(one, statistics={}, robot_id="weeder-01"), document),
        "",
        "",
    )
    stored = await rig.book.stored(FARM, mission.id, "weeder-01")
    assert stored is not None
    with pytest.raises(OrderRefused, match="which is smaller"):
        await rig.book.stored(FARM, mission.id, "weeder-02")
    await given(rig, mission, "weeder-03")
    now = await given(
        rig, mission, "weeder-04"
    )  # it is larger than the one before, not than the one it was planned for
    assert now.statistics[MACHINE]["robot_id"] == "weeder-01"
