"""Areas, lengths and middles."""

from __future__ import annotations

import json
import math

import pytest
from pyproj import Geod

from hmi.demo import farm
from hmi.mapping.feature import parse_feature
from hmi.mapping.measures import area_m2, area_text, centroid, edge_lengths_m, edge_m
from tests.hmi.mapping.farms import area, box, degrees, line, point, raw

HOLED = area("holed", box(0, 0, 100, 60), box(40, 20, 60, 40)[::-1])
LANE = line("lane", [(0, 0), (30, 40), (30, 50)])


def test_an_area_is_without_its_holes() -> None:
    assert area_m2(HOLED) == pytest.approx(5600, rel=1e-4)
    assert area_m2(LANE) == 0
    assert area_m2(point("pole", (0, 0), kind="obstacle", radius_m=2)) == pytest.approx(4 * math.pi)
    assert area_m2(point("home", (0, 0))) == 0


def test_a_crossed_outline_still_has_an_area() -> None:
    bow = area("bow", [(0, 0), (60, 0), (0, 60), (60, 60), (0, 0)])
    assert area_m2(bow) == pytest.approx(1800, rel=1e-3)


def test_edges_are_measured_one_by_one() -> None:
    assert edge_lengths_m(LANE) == pytest.approx([50, 10], abs=0.003)
    assert edge_lengths_m(HOLED, 1) == pytest.approx([20] * 4, abs=0.003)
    assert edge_m(HOLED) == pytest.approx(400, abs=0.02)
    assert edge_m(point("home", (0, 0))) == 0
    with pytest.raises(IndexError):
        edge_lengths_m(LANE, 1)


def test_the_centroid_is_a_place_on_earth() -> None:
    assert centroid(HOLED) == pytest.approx(degrees([(50, 30)])[0], abs=2e-8)
    assert centroid(point("home", (5, 6))) == pytest.approx(degrees([(5, 6)])[0], abs=2e-8)


def test_a_real_field_measures_as_on_the_ellipsoid() -> None:
    one = farm.feature("polder-17")
    feature = parse_feature(json.loads(json.dumps(raw(one.id, one.kind, one.geometry, name=one.name))))
    lon, lat = zip(*one.geometry["coordinates"][0], strict=True)
    area_geodesic, length_geodesic = Geod(ellps="WGS84").polygon_area_perimeter(lon, lat)
    assert area_m2(feature) == pytest.approx(abs(area_geodesic), rel=1e-5)
    assert edge_m(feature) == pytest.approx(length_geodesic, rel=1e-5)


@pytest.mark.parametrize(("area_m2", "text"), [(0.4, "0.4 m²"), (13.6, "14 m²"), (999, "999 m²"), (12_200, "1.22 ha")])
def test_an_area_is_told_in_units_of_its_size(area_m2: float, text: str) -> None:
    assert area_text(area_m2) == text
