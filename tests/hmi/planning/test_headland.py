"""Laps around fields and holes."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
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
@pytest.mark.slow
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
    mended = without_kinks(kinked, 1.5)
    twice = [np.vstack([points, points[1:]]) for points in (kinked, mended)]
    assert sharpest_excess_rad(twice[0], 1.5) > SLACK_RAD >= sharpest_excess_rad(twice[1], 1.5)
    assert len(kinked) - 4 < len(mended) < len(kinked)
    assert (mended[0] == mended[-1]).all()


def test_a_ring_that_winds_on_purpose_is_kept() -> None:
    zigzag = np.array(
        [[x, y] for x, y in zip(range(10), [0.0, 0.5] * 5, strict=True)] + [[9.0, 5.0], [0.0, 5.0], [0.0, 0.0]]
    )
    assert (without_kinks(zigzag, 1.5) == zigzag).all()


def test_a_lap_that_winds_by_centimetres_is_straightened() -> None:
    winding = [
        [-14.302, 5.888], [-14.329, 5.794], [-14.374, 5.604], [-14.406, 5.411], [-14.462, 5.224], [-14.543, 5.045],
        [-14.613, 4.862], [-14.643, 4.768],
    ]  # fmt: skip
    begin, end = np.array(winding[0]), np.array(winding[-1])
    way = (end - begin) / np.hypot(*(end - begin))
    along, aside = (np.array(winding) - begin) @ way, (np.array(winding) - begin) @ np.array([-way[1], way[0]])
    angles = np.radians(np.arange(0, 91, 7.5))
    corner = 3.0 * np.column_stack([np.cos(angles), np.sin(angles)])
    side = np.column_stack([20.0 + aside, 8.0 + along])
    quarters = [
        corner @ np.array([[c, s], [-s, c]]) + at
        for c, s, at in ((1, 0, (17, 17)), (0, 1, (3, 17)), (-1, 0, (3, 3)), (0, -1, (17, 3)))
    ]
    ring = np.vstack([*quarters, side, quarters[0][:1]])
    mended = without_kinks(ring, 3.0)
    tightest = [sharpest_excess_rad(np.vstack([points, points[1:2]]), 3.0) for points in (ring, mended)]
    assert tightest[0] > SLACK_RAD >= tightest[1]
    assert shapely.Polygon(ring).symmetric_difference(shapely.Polygon(mended)).area < 0.05
