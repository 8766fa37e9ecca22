"""The path as a line, and how closely the machine keeps to it."""

from __future__ import annotations

import math
import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from backend_clients.edge.messages_down import Segment
from backend_clients.edge.messages_up import Datum
from backend_clients.simulator.enu import EnuFrame
from backend_clients.simulator.kinematics import TRACKED, Base
from backend_clients.simulator.machine import Machine
from backend_clients.simulator.route import Route, RouteError, straight
from backend_clients.simulator.tracking import Tracker
from tests.backend_clients.simulator.rig import arc, small_mission

DT = 0.05


def drive(route: Route, x: float, y: float, theta: float, seconds: float = 600) -> tuple[Machine, float, list[float]]:
    """Follow a route; return the machine, the time taken and the true distances from the line."""
    machine = Machine(random.Random(5), Base(x, y, theta))
    tracker = Tracker(route)
    errors = []
    for step in range(round(seconds / DT)):
        wanted = tracker.steer(*machine.measured_pose(), DT)
        machine.step(DT, wanted, is_braking=wanted.v_mps == 0 and not wanted.is_pivoting, tool_on=False)
        if tracker.left_of_line_m is not None:
            nearest = route.locate(machine.base.x_m, machine.base.y_m, tracker.s_m - 1, tracker.s_m + 1)
            errors.append(math.dist(route.point_at(nearest), (machine.base.x_m, machine.base.y_m)))
        if tracker.is_done:
            return machine, step * DT, errors
    raise AssertionError(f"not at the end after {seconds:g} s: {tracker.s_m:.1f} of {route.length_m:.1f} m")


def test_rows_and_turns_are_followed_within_five_centimetres() -> None:
    route = Route(small_mission(rows=6, length_m=40).segments)
    _, _, errors = drive(route, 0.0, -2.0, math.pi / 2)
    assert max(errors) < 0.05
    assert sum(errors) / len(errors) < 0.02


def test_sharp_corners_are_turned_on_the_spot_without_leaving_the_path() -> None:
    square = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0), (0.0, 0.5)]
    machine, _, errors = drive(straight(square, 1.5), 0.0, 0.0, 0.0)
    assert max(errors) < 0.06
    assert math.dist((machine.base.x_m, machine.base.y_m), square[-1]) < 0.1


def test_a_declared_pivot_is_turned_on_the_spot_even_where_the_bend_is_gentle() -> None:
    first = Segment(kind="approach", points=[(0.0, 0.0), (10.0, 0.0)], speed_mps=1.0)
    second = Segment(kind="row", points=[(10.0, 0.0), (20.0, 3.0)], speed_mps=1.0, pivot=True)
    assert list(Route([first, second]).pivots) == [10.0]
    again = Segment(kind="row", points=[(10.0, 0.0), (20.0, 3.0)], speed_mps=1.0)
    assert list(Route([first, again]).pivots) == []


def test_a_tight_arc_is_driven_slowly_enough() -> None:
    tight = Segment(kind="turn", points=arc(0.0, 0.0, 0.6, 0.0, math.pi), speed_mps=1.6)
    entry = Segment(kind="approach", points=[(0.6, -20.0), (0.6, 0.0)], speed_mps=1.6)
    _, _, errors = drive(Route([entry, tight]), 0.6, -20.0, math.pi / 2)
    assert max(errors) < 0.08


@settings(max_examples=12, deadline=None)
@given(
    bends=st.lists(st.floats(-2.6, 2.6), min_size=1, max_size=6),
    lengths=st.lists(st.floats(1.0, 15.0), min_size=7, max_size=7),
    speed=st.floats(0.3, 1.66),
)
@pytest.mark.slow
def test_any_polyline_is_driven_to_its_end_close_to_the_line(
    bends: list[float], lengths: list[float], speed: float
) -> None:
    heading, points = 0.0, [(0.0, 0.0)]
    for bend, length in zip([0.0, *bends], lengths, strict=False):
        heading += bend
        x, y = points[-1]
        points.append((x + length * math.cos(heading), y + length * math.sin(heading)))
    machine, _, errors = drive(straight(points, speed), 0.0, 0.0, 0.0)
    assert math.dist((machine.base.x_m, machine.base.y_m), points[-1]) < 0.12
    assert max(errors) < 0.2


@pytest.mark.parametrize("points", [[(1.0, 1.0), (1.0, 1.0)], [(0.0, 0.0), (0.0, 1e-6)]])
def test_a_path_without_length_is_refused(points: list[tuple[float, float]]) -> None:
    with pytest.raises(RouteError, match="no length"):
        straight(points, 1.0)


@settings(max_examples=50, deadline=None)
@given(orders=st.lists(st.tuples(st.floats(-3, 3), st.floats(-3, 3), st.booleans()), min_size=1, max_size=60))
def test_speed_and_acceleration_never_leave_their_limits(orders: list[tuple[float, float, bool]]) -> None:
    base = Base()
    for v, w, is_braking in orders:
        before, place = base.speed_mps, (base.x_m, base.y_m)
        base.step(DT, 0.0 if is_braking else v, w, is_braking=is_braking)
        assert abs(base.speed_mps) <= TRACKED.max_speed_mps + 1e-9
        assert abs(base.speed_mps - before) <= max(TRACKED.accel_mps2, TRACKED.brake_mps2) * DT + 1e-9
        if abs(base.speed_mps) > abs(before) and base.speed_mps * before > 0:
            assert abs(base.speed_mps - before) <= TRACKED.accel_mps2 * DT + 1e-9
        assert math.dist(place, (base.x_m, base.y_m)) <= TRACKED.max_speed_mps * DT + 1e-9
        assert -math.pi <= base.theta_rad <= math.pi


@settings(max_examples=50, deadline=None)
@given(x=st.floats(-3000, 3000), y=st.floats(-3000, 3000), lat=st.floats(-70, 70), lon=st.floats(-179, 179))
def test_positions_go_to_wgs84_and_back_within_a_millimetre(x: float, y: float, lat: float, lon: float) -> None:
    frame = EnuFrame(lat, lon)
    assert frame.to_enu(*frame.to_wgs84(x, y)) == pytest.approx((x, y), abs=1e-3)


def test_a_point_of_another_datum_is_the_same_place_on_earth() -> None:
    here, there = EnuFrame(52.0, 5.0), EnuFrame(52.003, 5.004)
    (moved,) = here.from_frame(Datum(lat_deg=52.003, lon_deg=5.004), [(12.0, -7.0)])
    assert here.to_wgs84(*moved) == pytest.approx(there.to_wgs84(12.0, -7.0), abs=1e-9)
