"""The local plane."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from backend_clients.simulator.enu import EnuFrame
from hmi.planning.projection import LocalFrame

lats, lons = st.floats(-80, 80), st.floats(-179, 179)
offsets = st.floats(-5000, 5000)


@settings(max_examples=30, deadline=None)
@given(lats, lons, offsets, offsets)
def test_a_point_comes_back_to_a_tenth_of_a_millimetre(lat: float, lon: float, x: float, y: float) -> None:
    frame = LocalFrame(lat, lon)
    assert np.allclose(frame.to_local(frame.to_lon_lat([(x, y)])), [(x, y)], atol=1e-4)


@settings(max_examples=20, deadline=None)  # each new datum costs milliseconds
@given(lats, lons)
def test_the_datum_is_the_origin(lat: float, lon: float) -> None:
    assert np.allclose(LocalFrame(lat, lon).to_local([(lon, lat)]), [(0, 0)], atol=1e-6)


def test_x_is_east_and_y_is_north() -> None:
    [(x, y)] = LocalFrame(51.78, 4.26).to_local([(4.261, 51.781)])
    assert x > 60
    assert y > 100


def test_a_tenth_of_a_degree_north_is_as_long_as_on_the_ellipsoid() -> None:
    [(_, y)] = LocalFrame(45.0, 7.0).to_local([(7.0, 45.01)])
    assert math.isclose(y, 1111.32, abs_tol=0.1)


def test_the_planner_and_the_simulated_robot_use_the_same_plane() -> None:
    ours = LocalFrame(51.78, 4.26).to_local([(4.2633, 51.7851)])[0]
    theirs = EnuFrame(51.78, 4.26).to_enu(51.7851, 4.2633)
    assert math.dist(ours, theirs) < 1e-6


@pytest.mark.parametrize(("lat", "lon"), [(91, 0), (0, 181), (math.nan, 0), (0, math.inf)])
def test_a_datum_off_the_earth_is_refused(lat: float, lon: float) -> None:
    with pytest.raises(ValueError, match="not a place on earth"):
        LocalFrame(lat, lon)
