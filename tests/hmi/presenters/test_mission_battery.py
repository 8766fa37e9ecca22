"""What a mission takes of a battery is told of the robot that gets it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from hmi.domain.planned_machine import MACHINE, PlannedMachine
from hmi.domain.robot import Battery, Family, Robot, Telemetry
from hmi.presenters.mission_battery import battery_row
from tests.hmi.missions.rig import weeder
from tests.hmi.presenters.robots import SHEET

SMALL, LARGE = replace(SHEET, battery_wh=6000.0), replace(SHEET, battery_wh=12000.0)


def figures() -> dict[str, Any]:
    """Return those of a mission planned for a large battery."""
    machine = PlannedMachine.of("weeder-01", LARGE).as_json()
    return {"battery_share": 0.4, "energy_j": 0.4 * 12000 * 3600, "reserve_share": 0.15, MACHINE: machine}


def robot(robot_id: str = "weeder-05", soc: float | None = None, **more: Any) -> Robot:
    found = replace(weeder(robot_id, robot_id.title()), **more)
    if soc is None:
        return found
    battery = Battery(soc, None, False)
    pose: Any = None
    return replace(found, telemetry=Telemetry(pose, None, battery, None, None, None))


def test_it_is_counted_with_the_battery_of_the_robot_it_goes_to() -> None:
    row = battery_row(figures(), robot(soc=0.97, factsheet=SMALL), "Weeder 01")
    assert (round(row["share"], 3), row["is_enough"]) == (0.8, True)
    assert row["text"] == "It takes 80 % of the full battery of Weeder-05, which has 97 % now."


def test_what_is_not_enough_with_the_reserve_says_so() -> None:
    row = battery_row(figures(), robot(soc=0.9, factsheet=SMALL), "Weeder 01")
    assert row["is_enough"] is False
    assert row["text"].startswith("Not enough: it takes 80 % of the full battery of Weeder-05 with 15 % reserve")


def test_what_is_not_known_is_not_made_up() -> None:
    row = battery_row(figures(), robot(soc=0.9), "Weeder 01")
    assert (row["share"], row["is_enough"]) == (None, None)
    assert row["text"] == ("What it takes of the battery of Weeder-05 is not known. The figure is for Weeder 01.")
    own = battery_row(figures(), robot("weeder-01", factsheet=LARGE), "Weeder 01")
    assert own["text"] == "It takes 40 % of the full battery of Weeder-01; what it has now is not known."


def test_more_than_a_charge_is_told_in_charges_and_another_kind_of_machine_is_not_counted() -> None:
    long = {**figures(), "energy_j": 2.0 * 6000 * 3600}
    row = battery_row(long, robot(soc=0.9, factsheet=SMALL), "Weeder 01")
    assert row["text"] == "It takes 3 full charges of Weeder-05: it pauses to be charged, and goes on."
    other = battery_row(figures(), robot(soc=0.9, factsheet=replace(SMALL, family=Family.UAV)), "Weeder 01")
    assert other["share"] is None
