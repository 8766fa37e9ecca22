"""Time and energy."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from backend_clients.simulator.planter_profile import PLANTER
from backend_clients.simulator.profile import Profile
from backend_clients.simulator.uav_profile import UAV
from backend_clients.simulator.weeder_profile import WEEDER
from hmi.domain.family import Family
from hmi.domain.mission_plan import PlanWish
from hmi.planning.energy import energy_of
from hmi.planning.estimate import effort, pivot_time
from hmi.planning.machine import PLANT_S, RobotProfile
from hmi.planning.mission import plan_mission
from hmi.planning.plan import Leg, LegKind
from tests.hmi.missions.rig import FRAME, parcel_geometry
from tests.hmi.presenters.robots import SHEET

MACHINE = RobotProfile(accel_mps2=0.5, yaw_rate_radps=0.5)


def straight(a: tuple[float, float], b: tuple[float, float], speed: float, **more: object) -> Leg:
    return Leg(LegKind.ROW, np.array([a, b], dtype=float), speed, **more)  # type: ignore[arg-type]


def test_a_long_row_takes_its_length_plus_one_ramp_up_and_down() -> None:
    took = effort([straight((0, 0), (100, 0), 0.5)], MACHINE)
    assert took.duration_s == pytest.approx(100 / 0.5 + 0.5 / 0.5)


def test_a_leg_too_short_to_reach_its_speed_is_driven_as_a_triangle() -> None:
    took = effort([straight((0, 0), (0.5, 0), 2.0)], MACHINE)
    assert took.duration_s == pytest.approx(2 * math.sqrt(0.5 / 0.5))


def test_a_pivot_costs_a_stop_and_the_turn() -> None:
    along = [straight((0, 0), (10, 0), 0.5), straight((10, 0), (20, 0), 0.5)]
    across = [straight((0, 0), (10, 0), 0.5), straight((10, 0), (10, 10), 0.5, pivot=True)]
    more = effort(across, MACHINE).duration_s - effort(along, MACHINE).duration_s
    assert more == pytest.approx(1.0 + pivot_time(math.pi / 2, MACHINE))


def test_a_planter_stands_for_each_tree_of_its_rows_and_for_none_on_its_way() -> None:
    planter = MACHINE.planting(4.0, None)
    row, way = straight((0, 0), (20, 0), 0.5, tool_on=True), straight((0, 0), (20, 0), 0.5)
    more = effort([row], planter).duration_s - effort([row], MACHINE).duration_s
    assert more == pytest.approx(20 * 4.0 * 0.25 * PLANT_S)
    assert effort([row], MACHINE.planting(4.0, 2.0)).working_s == pytest.approx(
        effort([row], MACHINE).working_s + 10 * PLANT_S
    )
    assert effort([way], planter).duration_s == effort([way], MACHINE).duration_s


def test_working_time_and_length_count_only_where_the_tool_is_on() -> None:
    legs = [straight((0, 0), (10, 0), 0.5, tool_on=True), straight((10, 0), (15, 0), 0.5)]
    took = effort(legs, MACHINE)
    assert took.working_length_m == 10
    assert took.length_m == 15
    assert took.working_s < took.duration_s


def test_energy_is_driving_plus_idling_plus_tool() -> None:
    took = effort([straight((0, 0), (100, 0), 0.5, tool_on=True)], MACHINE)
    use = MACHINE.energy
    expected = 100 * use.drive_j_per_m + took.duration_s * (use.idle_w + use.tool_w)
    assert took.energy_j == pytest.approx(expected)


def test_a_plan_counts_with_the_battery_the_robot_says_it_has() -> None:
    usual = RobotProfile.from_factsheet(SHEET)
    small = RobotProfile.from_factsheet(replace(SHEET, battery_wh=6000.0))
    assert (usual.battery_j, small.battery_j) == (12 * 3.6e6, 6 * 3.6e6)


@pytest.mark.parametrize("profile", [WEEDER, PLANTER, UAV], ids=lambda one: str(one.family))
def test_each_family_is_planned_with_what_its_simulated_machine_takes(profile: Profile) -> None:
    use, takes = energy_of(Family(profile.family)), profile.energy
    assert use.store_j == takes.capacity_j
    assert use.drive_j_per_m == takes.drive_w_per_mps
    assert use.idle_w == takes.idle_w + takes.hover_w
    assert use.tool_w == takes.tool_w


def test_a_planter_takes_more_for_the_same_row_than_a_weeder_and_says_what_is_assumed() -> None:
    row = [straight((0, 0), (100, 0), 0.4, tool_on=True)]
    weeder = RobotProfile.from_factsheet(SHEET)
    planter = RobotProfile.from_factsheet(replace(SHEET, family=Family.PLANTER))
    assert effort(row, planter).energy_j > 10 * effort(row, weeder).energy_j
    assert "129 kW" in planter.energy.basis
    assert "Do not rely" in RobotProfile.from_factsheet(replace(SHEET, family=Family.OTHER)).energy.basis


@pytest.mark.parametrize(
    ("battery_wh", "says"), [(None, "Tank of 600 kWh assumed."), (450_000.0, "Tank of 450 kWh from its factsheet.")]
)
def test_the_numbers_of_a_plan_name_the_figures_they_count_with(battery_wh: float | None, says: str) -> None:
    planter = replace(SHEET, family=Family.PLANTER, battery_wh=battery_wh)
    wish = PlanWish(
        mission_id="m-1",
        name="Home field",
        robot_id="planter-01",
        field_name="Home field",
        parcel=parcel_geometry(40.0),
        width_m=4.0,
        datum_lat_deg=FRAME.lat_deg,
        datum_lon_deg=FRAME.lon_deg,
        robot=planter,
    )
    told = plan_mission(wish).statistics
    assert told["is_tank"] is True
    assert told["energy_basis"].endswith(says)
    assert told["energy_basis"].startswith("Assumed for a 10 t planter")
