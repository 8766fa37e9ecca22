"""Laps around fields and holes."""

from __future__ import annotations

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from shapely.geometry import Polygon

from hmi.planning.ground import Ground
from hmi.planning.headland import divide, laps
from hmi.planning.machine import RobotProfile
from tests.hmi.planning.test_properties import SLACK_RAD, fields_with_holes, sharpest_excess_rad

MACHINE = RobotProfile(turning_radius_m=1.5)


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(fields_with_holes(), st.sampled_from([0.5, 3.0]))
def test_a_lap_bends_no_tighter_than_the_turning_radius(field: Polygon, width_m: float) -> None:
    for lap in laps(Ground(field, MACHINE), divide(MACHINE, width_m, None)):
        twice = np.vstack([lap.points, lap.points[1:]])  # the closing corner included
        assert sharpest_excess_rad(twice, MACHINE.turning_radius_m) <= SLACK_RAD
