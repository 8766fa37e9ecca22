"""Dubins paths."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmi.planning.dubins import Pose, candidates, shortest

poses = st.tuples(st.floats(-30, 30), st.floats(-30, 30), st.floats(-7, 7))
radii = st.floats(0.3, 6)


def turned(a: float, b: float) -> float:
    return abs(math.remainder(b - a, 2 * math.pi))


@given(poses, poses, radii)
def test_every_word_ends_at_the_goal_with_its_heading(start: Pose, goal: Pose, radius: float) -> None:
    for path in candidates(start, goal, radius):
        x, y, heading = path.at(path.length_m)
        assert math.dist((x, y), goal[:2]) < 1e-5
        assert turned(heading, goal[2]) < 1e-5


@given(poses, poses, radii)
def test_no_path_is_shorter_than_the_straight_line(start: Pose, goal: Pose, radius: float) -> None:
    assert shortest(start, goal, radius).length_m >= math.dist(start[:2], goal[:2]) - 1e-6


@given(poses, poses, radii)
def test_a_path_driven_backwards_is_as_long(start: Pose, goal: Pose, radius: float) -> None:
    there = shortest(start, goal, radius)
    back = shortest((*goal[:2], goal[2] + math.pi), (*start[:2], start[2] + math.pi), radius)
    assert math.isclose(there.length_m, back.length_m, rel_tol=1e-6, abs_tol=1e-5)


@given(poses, poses, radii)
def test_samples_bend_gently_and_never_tighter_than_the_radius(start: Pose, goal: Pose, radius: float) -> None:
    samples = shortest(start, goal, radius).sample(0.5)
    steps = np.hypot(*np.diff(samples[:, :2], axis=0).T)
    for step, (a, b) in zip(steps, zip(samples[:-1, 2], samples[1:, 2], strict=True), strict=True):
        assert turned(a, b) <= math.radians(8) + 1e-9
        assert step >= 2 * radius * math.sin(turned(a, b) / 2) - 1e-6


def test_straight_ahead_is_a_straight_line() -> None:
    assert shortest((0, 0, 0), (10, 0, 0), 2).length_m == pytest.approx(10)


def test_the_next_row_two_radii_away_is_a_half_circle() -> None:
    assert shortest((0, 0, 0), (0, 3, math.pi), 1.5).length_m == pytest.approx(1.5 * math.pi)


@pytest.mark.parametrize("radius", [0.0, -1.0, math.nan, math.inf])
def test_a_radius_that_cannot_be_is_refused(radius: float) -> None:
    with pytest.raises(ValueError, match="no Dubins path"):
        candidates((0, 0, 0), (1, 1, 1), radius)
