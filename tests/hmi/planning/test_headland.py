"""Laps around fields and holes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from shapely.geometry import Polygon

from hmi.planning.ground import Ground
from hmi.planning.headland import divide, laps, without_kinks
from hmi.planning.machine import RobotProfile
from tests.hmi.planning.test_properties import SLACK_RAD, fields_with_holes, sharpest_excess_rad

MACHINE = RobotProfile(turning_radius_m=1.5)


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(fields_with_holes(), st.sampled_from([0.5, 3.0]))
def test_a_lap_bends_no_tighter_than_the_turning_radius(field: Polygon, width_m: float) -> None:
    for lap in laps(Ground(field, MACHINE), divide(MACHINE, width_m, None)):
        twice = np.vstack([lap.points, lap.points[1:]])  # the closing corner included
        assert sharpest_excess_rad(twice, MACHINE.turning_radius_m) <= SLACK_RAD


@pytest.mark.parametrize("number", [0, 1, 17])
@pytest.mark.parametrize("off_m", [-0.009, 0.009])
def test_a_corner_beside_the_way_is_left_out_wherever_the_ring_begins(number: int, off_m: float) -> None:
    angles = np.linspace(0, 2 * np.pi, 96, endpoint=False)  # as they come out: finer than a lap needs
    ring = 1.5 * np.column_stack([np.cos(angles), np.sin(angles)])
    ring[number] *= 1 + off_m / 1.5
    kinked = np.vstack([ring, ring[:1]])
    mended = without_kinks(kinked)
    twice = [np.vstack([points, points[1:]]) for points in (kinked, mended)]
    assert sharpest_excess_rad(twice[0], 1.5) > SLACK_RAD >= sharpest_excess_rad(twice[1], 1.5)
    assert len(mended) == len(kinked) - 1
    assert (mended[0] == mended[-1]).all()


def test_a_ring_that_winds_on_purpose_is_kept() -> None:
    zigzag = np.array(
        [[x, y] for x, y in zip(range(10), [0.0, 0.5] * 5, strict=True)] + [[9.0, 5.0], [0.0, 5.0], [0.0, 0.0]]
    )
    assert (without_kinks(zigzag) == zigzag).all()
