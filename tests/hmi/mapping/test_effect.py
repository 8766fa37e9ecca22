"""What an operation would do, told before anything is changed."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hmi.mapping.effect import Effect, effect_of
from hmi.mapping.errors import OperationRefused
from hmi.mapping.feature import MapFeature
from hmi.mapping.operations import apply
from tests.hmi.mapping.farms import area, box, draft, fields, point


def effect(feature: MapFeature, op: str, **args: float) -> Effect:
    return effect_of(apply(op, draft(feature), [feature.id], args))


def test_simplifying_tells_how_many_corners_stay_and_how_far_off_the_edge_is() -> None:
    field = area("field", [(0, 0), (50, 0.08), (100, 0), (100, 60), (0, 60), (0, 0)])
    told = effect(field, "simplify", tolerance_m=0.1)
    assert (told.corners_before, told.corners_after, told.pieces) == (5, 4, 1)
    assert told.off_m == pytest.approx(0.08, abs=0.002)


def test_an_inset_tells_the_area_before_and_after() -> None:
    told = effect(area("field", box(0, 0, 100, 60)), "buffer", distance_m=-3)
    assert told.area_before_m2 == pytest.approx(6000, abs=1)
    assert told.area_after_m2 == pytest.approx(94 * 54, abs=1)


def test_a_circle_has_an_area_and_no_corners_to_be_off() -> None:
    told = effect(point("pylon", (0, 0), kind="obstacle", radius_m=2), "buffer", distance_m=1)
    assert told.off_m is None
    assert told.area_after_m2 == pytest.approx(28.27, abs=0.01)


@settings(max_examples=40, deadline=None)
@given(fields(), st.floats(0.05, 5))
def test_the_edge_is_never_further_off_than_the_tolerance(north: MapFeature, tolerance: float) -> None:
    try:
        told = effect(north, "simplify", tolerance_m=tolerance)
    except OperationRefused:
        return
    assert told.off_m is not None
    assert told.off_m <= tolerance + 0.003
    assert told.corners_after < told.corners_before
