"""Turns in pieces: a machine that backs up needs less headland; its path is checked, counted and planned anew."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from itertools import pairwise
from typing import Any

import msgspec
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from shapely.geometry import Polygon

from backend_clients.edge import codec
from backend_clients.edge import messages_down as down
from backend_clients.simulator.kinematics import TRACKED, WHEELED
from backend_clients.simulator.route import Route, RouteError
from hmi.domain.mission_document import canonical, drives_backward, mission_sha256
from hmi.domain.mission_plan import PathUnfit, PlannedMission, PlanRefused
from hmi.domain.mission_rest import Progress, RestWish, length_m
from hmi.planning.coverage import plan_coverage
from hmi.planning.estimate import CUSP_S, effort, timeline
from hmi.planning.given_path import checked_mission, segments_of
from hmi.planning.job import Job, checked_field
from hmi.planning.machine import RobotProfile
from hmi.planning.mission import job_of, plan_mission
from hmi.planning.path_check import check_path
from hmi.planning.plan import Leg, Plan, is_cusp
from hmi.planning.rest import plan_rest
from tests.hmi.missions.test_document import wish
from tests.hmi.planning.grounds import assert_drivable, convex_fields, crooked_fields, square
from tests.hmi.presenters.robots import SHEET

FORWARDS = RobotProfile(length_m=3.0, width_m=1.5, base_to_front_m=2.0, turning_radius_m=3.0, can_pivot=False)
BACKING = replace(FORWARDS, reverse_mps=0.5)
BACKING_SHEET = replace(
    SHEET, length_m=3.0, width_m=1.5, base_to_front_m=2.0, turning_radius_m=3.0, can_pivot=False, path_reverse_mps=0.5
)


@cache
def plan(machine: RobotProfile = BACKING) -> Plan:
    return plan_coverage(Job(square(60), 2.0, machine, angle_rad=math.pi / 2))


def cusps(legs: tuple[Leg, ...]) -> int:
    return sum(is_cusp(a, b) for a, b in pairwise(legs))


def test_it_takes_less_headland_and_less_way_than_driving_on() -> None:
    backing, forwards = plan(), plan(FORWARDS)
    assert backing.figures.headland_passes < forwards.figures.headland_passes
    assert backing.figures.length_m < 0.9 * forwards.figures.length_m
    assert backing.figures.duration_s < forwards.figures.duration_s
    assert backing.figures.covered_m2 >= forwards.figures.covered_m2 - 1
    assert backing.figures.reversals == cusps(backing.legs) >= 2 * 10
    assert_drivable(Job(square(60), 2.0, BACKING), backing)


def test_a_machine_that_says_nothing_of_it_never_backs_up() -> None:
    assert cusps(plan(FORWARDS).legs) == plan(FORWARDS).figures.reversals == 0
    asked = wish(angle_rad=0.0, width_m=2.0, robot=replace(BACKING_SHEET, path_reverse_mps=None))
    assert not drives_backward(plan_mission(asked).document)


def test_where_driving_on_is_quicker_it_drives_on() -> None:
    slow = replace(BACKING, reverse_mps=0.02)
    assert plan_coverage(Job(square(60), 7.0, slow, angle_rad=math.pi / 2)).figures.reversals == 0


@settings(max_examples=12, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.one_of(convex_fields(), crooked_fields()), st.sampled_from([1.0, 2.0, 3.0]))
@pytest.mark.slow
def test_on_any_field_the_outline_stays_inside_and_the_path_passes_the_check(field: Polygon, width_m: float) -> None:
    job = Job(field, width_m, BACKING)
    try:
        found = plan_coverage(job)
    except PlanRefused:
        return  # what small fields are refused for is asked of all machines in test_properties
    assert_drivable(job, found)
    check_path(job, checked_field(job), found.legs)


def test_stops_count_in_time_and_energy() -> None:
    legs = [leg for leg in plan().legs if leg.kind.value == "turn"][:3]
    assert [leg.is_backward for leg in legs] == [False, True, False]
    whole, alone = effort(legs, BACKING), [effort([leg], BACKING) for leg in legs]
    assert whole.reversals == 2
    assert whole.duration_s == pytest.approx(sum(one.duration_s for one in alone) + 2 * CUSP_S)
    assert whole.energy_j > sum(one.energy_j for one in alone)
    (_, first), (second, _), _ = timeline(legs, BACKING)
    assert second - first == pytest.approx(CUSP_S)


@cache
def planned() -> PlannedMission:
    return plan_mission(wish(angle_rad=0.0, width_m=2.0, robot=BACKING_SHEET))


def test_the_document_says_it_only_where_it_backs_up_and_robots_read_it_back() -> None:
    document = planned().document
    backward = [one for one in document["segments"] if "backward" in one]
    assert backward
    assert all(one["backward"] is True and one["kind"] == "turn" and not one["tool_on"] for one in backward)
    assert codec.mission_hash(_read(document)) == planned().sha256
    said = {**document, "segments": [{**one, "backward": one.get("backward", False)} for one in document["segments"]]}
    assert mission_sha256(canonical(said)) == planned().sha256


def _read(document: dict[str, Any]) -> down.Mission:
    return msgspec.convert(document, down.Mission)


def test_a_robot_that_cannot_refuses_the_path() -> None:
    segments = _read(planned().document).segments
    assert Route(segments, replace(WHEELED, path_reverse_mps=0.5)).rows > 0
    with pytest.raises(RouteError, match="backwards"):
        Route(segments, TRACKED)


def given_path() -> list[dict[str, Any]]:
    return segments_of(plan_coverage(job_of(wish(angle_rad=0.0, width_m=2.0, robot=BACKING_SHEET))).legs)


def test_a_path_from_elsewhere_may_back_up_and_comes_back_the_same() -> None:
    asked = wish(angle_rad=0.0, width_m=2.0, robot=BACKING_SHEET)
    assert checked_mission(asked, given_path(), []).sha256 == planned().sha256


def _tool_on(one: dict[str, Any]) -> dict[str, Any]:
    return {**one, "tool_on": True}


def _faster(one: dict[str, Any]) -> dict[str, Any]:
    return {**one, "speed_mps": 0.9}


def _as_row(one: dict[str, Any]) -> dict[str, Any]:
    return {**one, "kind": "headland"}


def _forwards(one: dict[str, Any]) -> dict[str, Any]:
    return {**one, "is_backward": False}


@pytest.mark.parametrize(
    ("change", "code"), [(_tool_on, "backward"), (_as_row, "backward"), (_faster, "speed"), (_forwards, "corner")]
)
def test_a_path_that_backs_up_wrongly_is_refused(change: Callable[[dict[str, Any]], dict[str, Any]], code: str) -> None:
    path = [change(one) if one["is_backward"] else one for one in given_path()]
    with pytest.raises(PathUnfit) as refused:
        checked_mission(wish(angle_rad=0.0, width_m=2.0, robot=BACKING_SHEET), path, [])
    assert refused.value.code == code


def test_a_path_that_backs_up_is_refused_for_a_robot_that_does_not() -> None:
    asked = wish(angle_rad=0.0, width_m=2.0, robot=replace(BACKING_SHEET, path_reverse_mps=None))
    with pytest.raises(PathUnfit, match="drives backwards, which this robot does on no path"):
        checked_mission(asked, given_path(), [])


def rest(segment: int, s_m: float, **more: Any) -> list[dict[str, Any]]:
    progress = Progress(planned().sha256, segment, s_m)
    base = {"base": planned().document, "base_sha256": planned().sha256, "revision": 2, "robot": BACKING_SHEET}
    found: list[dict[str, Any]] = plan_rest(RestWish(progress=progress, **{**base, **more})).document["segments"]
    return found


def test_inside_such_a_turn_the_rest_goes_on_backwards() -> None:
    segments = planned().document["segments"]
    number = next(k for k, one in enumerate(segments) if one.get("backward"))
    half_m = length_m(segments[number]) / 2
    found = rest(number, half_m, row_speed_mps=0.3)
    assert [one.get("backward", False) for one in found[number : number + 3]] == [True, True, False]
    assert found[number]["points"][-1] == found[number + 1]["points"][0]
    assert sum(map(length_m, found[number : number + 2])) == pytest.approx(2 * half_m, abs=0.01)
    assert not any(one["pivot"] for one in found[number : number + 3])


def test_left_out_rows_are_passed_with_a_new_turn_that_fits() -> None:
    segments = planned().document["segments"]
    number = next(k for k, one in enumerate(segments) if one.get("backward"))
    rows = [k for k, one in enumerate(segments) if one["kind"] == "row"]
    left_out = tuple(k for k in rows if k > number)[:2]  # the one after them begins at the same end
    found = rest(number, 0.3, leave_out=left_out)
    assert len([one for one in found if one["kind"] == "row"]) == len(rows) - 2
    Route(_read({**planned().document, "segments": found}).segments, replace(WHEELED, path_reverse_mps=0.5))
