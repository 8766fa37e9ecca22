"""Reeds-Shepp paths."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmi.planning import dubins
from hmi.planning.dubins import Pose
from hmi.planning.plan import headings
from hmi.planning.reeds_shepp import candidates, shortest
from hmi.planning.turns import MOST_CUSPS

poses = st.tuples(st.floats(-30, 30), st.floats(-30, 30), st.floats(-7, 7))
near = st.tuples(st.floats(-6, 6), st.floats(-6, 6), st.floats(-7, 7))
radii = st.floats(0.3, 6)
PIECE_RAD = math.radians(8)


def turned(a: float, b: float) -> float:
    return abs(math.remainder(b - a, 2 * math.pi))


@given(st.one_of(poses, near), st.one_of(poses, near), radii)
def test_every_word_ends_at_the_goal_with_its_heading(start: Pose, goal: Pose, radius: float) -> None:
    for path in candidates(start, goal, radius):
        x, y, heading = start[0] / radius, start[1] / radius, start[2]
        for kind, part in path.parts:
            x, y, heading = dubins.along(kind, x, y, heading, np.array([part]))[0]
        assert math.dist((x * radius, y * radius), goal[:2]) < 1e-4
        assert turned(heading, goal[2]) < 1e-5


@given(near, near, radii)
def test_it_is_never_longer_than_the_way_forwards(start: Pose, goal: Pose, radius: float) -> None:
    length_m = shortest(start, goal, radius).length_m
    assert math.dist(start[:2], goal[:2]) - 1e-5 <= length_m <= dubins.shortest(start, goal, radius).length_m + 1e-5


@given(near, near, radii)
def test_the_way_back_is_as_long(start: Pose, goal: Pose, radius: float) -> None:
    there, back = shortest(start, goal, radius), shortest(goal, start, radius)
    assert math.isclose(there.length_m, back.length_m, rel_tol=1e-6, abs_tol=1e-4)


@given(near, near, radii)
def test_the_heading_goes_on_where_it_stops_and_bends_no_tighter_than_the_radius(
    start: Pose, goal: Pose, radius: float
) -> None:
    last: float | None = start[2]
    place = start[:2]
    for drive in shortest(start, goal, radius).drives(0.5):
        steps, looks = np.hypot(*np.diff(drive.points, axis=0).T), headings(drive.points) + math.pi * drive.is_backward
        assert math.dist(place, drive.points[0]) < 1e-3
        place = drive.points[-1]
        if steps.min() < 0.02:
            last = None  # too short for a direction
            continue
        assert last is None or turned(last, looks[0]) <= PIECE_RAD + 1e-3  # half a piece before, half a piece after
        bends = np.abs(np.angle(np.exp(1j * np.diff(looks))))
        assert (bends <= PIECE_RAD + 1e-6).all()
        assert (2 * radius * np.sin(bends / 2) <= (steps[:-1] + steps[1:]) / 2 + 1e-6).all()
        last = looks[-1]
    assert math.dist(place, goal[:2]) < 1e-3
    assert last is None or turned(last, goal[2]) <= PIECE_RAD / 2 + 1e-3


def test_the_next_row_nearer_than_the_circle_is_reached_in_three_pushes_within_one_radius() -> None:
    path = min(
        (
            one
            for one in candidates((0, 0, math.pi / 2), (4, 0, -math.pi / 2), 5)
            if len(one.drives_m) == MOST_CUSPS + 1
        ),
        key=lambda one: one.length_m,
    )
    points = np.concatenate([drive.points for drive in path.drives(0.2)])
    assert [drive > 0 for drive in path.drives_m] == [True, False, True]
    assert points[:, 1].max() < 5.1  # the bulb forwards goes 12 m out
    assert path.length_m < 0.65 * dubins.shortest((0, 0, math.pi / 2), (4, 0, -math.pi / 2), 5).length_m


def test_straight_back_is_driven_straight_back() -> None:
    path = shortest((0, 0, 0), (-10, 0, 0), 2)
    assert path.parts == (("S", pytest.approx(-5)),)


def test_where_it_is_already_there_it_does_not_drive() -> None:
    assert shortest((3, 4, 1), (3, 4, 1), 2).parts == ()


@pytest.mark.parametrize("radius", [0.0, -1.0, math.nan, math.inf])
def test_a_radius_that_cannot_be_is_refused(radius: float) -> None:
    with pytest.raises(ValueError, match="no Reeds-Shepp path"):
        candidates((0, 0, 0), (1, 1, 1), radius)
