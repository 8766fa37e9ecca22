"""What holds for operations on any field, however it is drawn."""

from __future__ import annotations

import math
from typing import Any

import pytest
import shapely
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from hmi.mapping.errors import OperationRefused
from hmi.mapping.feature import MapFeature, as_geojson, parse_feature
from hmi.mapping.operations import apply
from tests.hmi.mapping.farms import area, assert_sound, box, degrees, do, draft, fields, metres, scribbles

calm = settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow])
offsets = st.floats(-60, 60)
angles = st.floats(0, math.pi)
NEIGHBOUR = area("east", box(20, -40, 220, 90), name="East")


def cut_at(offset_m: float, angle: float) -> list[list[float]]:
    """Return a line right across everything, ``offset_m`` beside the place."""
    along, beside = (math.cos(angle), math.sin(angle)), (-math.sin(angle), math.cos(angle))
    return degrees([(beside[0] * offset_m + along[0] * k, beside[1] * offset_m + along[1] * k) for k in (-400, 400)])


def tried(op: str, features: dict[str, MapFeature], ids: list[str], **args: Any) -> dict[str, MapFeature] | None:
    """Return the draft after, ``None`` if the operation does not fit these features."""
    try:
        return do(op, features, ids, **args)
    except OperationRefused:
        return None


def everything(offset: float, angle: float) -> list[tuple[str, list[str], dict[str, Any]]]:
    """Return one call of each operation."""
    one, two = ["north"], ["north", "east"]
    return [
        ("split", one, {"line": cut_at(offset, angle)}),
        ("merge", two, {}),
        ("merge", two, {"gap_m": abs(offset) / 10}),
        ("buffer", one, {"distance_m": offset / 5}),
        ("straighten", one, {"from": 0, "to": 2}),
        ("simplify", one, {"tolerance_m": 0.1 + abs(offset) / 10}),
        ("shift", two, {"east_m": offset, "north_m": 10 * angle}),
        ("turn", two, {"angle_deg": offset}),
        ("add_hole", one, {"ring": degrees(box(offset - 1, angle, offset + 1, angle + 3))}),
        ("remove_hole", one, {"ring": 1}),
        ("clip", one, {"others": ["east"]}),
        ("orient", one, {}),
        ("clean", one, {}),
        ("untangle", one, {}),
        ("swap_axes", one, {}),
    ]


@calm
@given(fields(), offsets, angles)
@pytest.mark.slow
def test_every_operation_on_a_field_is_valid_and_undone_exactly(north: MapFeature, offset: float, angle: float) -> None:
    farm = draft(north, NEIGHBOUR)
    for op, ids, args in everything(offset, angle):
        tried(op, farm, ids, **args)


@pytest.mark.slow
@calm
@given(scribbles(), offsets, angles)
def test_a_scribble_breaks_no_operation(north: MapFeature, offset: float, angle: float) -> None:
    farm = draft(north, NEIGHBOUR)
    for op, ids, args in everything(offset, angle):
        try:
            outcome = apply(op, farm, ids, args)
        except OperationRefused:
            continue
        assert outcome.taken_back_from(outcome.applied_to(farm)) == farm
        for change in outcome.changes:
            assert change.after is None or parse_feature(as_geojson(change.after)) == change.after


@calm
@given(fields(), offsets, angles)
def test_the_pieces_of_a_split_are_the_whole(north: MapFeature, offset: float, angle: float) -> None:
    after = tried("split", draft(north), ["north"], line=cut_at(offset, angle))
    assume(after is not None)
    assert after is not None
    pieces = [metres(one) for one in after.values()]
    # corners are kept to 1 mm
    assert sum(piece.area for piece in pieces) == pytest.approx(metres(north).area, abs=0.002 * metres(north).length)
    assert shapely.union_all(pieces).symmetric_difference(metres(north)).area < 0.002 * metres(north).length
    assert metres(after["north"]).area == max(piece.area for piece in pieces)
    assert all(one.properties == north.properties for one in after.values())


@calm
@given(fields(), offsets, angles)
def test_merging_what_was_split_gives_the_field_back(north: MapFeature, offset: float, angle: float) -> None:
    after = tried("split", draft(north), ["north"], line=cut_at(offset, angle))
    assume(after is not None)
    assert after is not None
    again = do("merge", after, list(after), gap_m=0)
    assert set(again) == {"north"}
    assert metres(again["north"]).symmetric_difference(metres(north)).area < 0.01 * metres(north).length
    assert (again["north"].name, again["north"].properties) == (north.name, north.properties)


@calm
@given(st.one_of(fields(), scribbles()), st.sampled_from(["orient", "clean", "untangle"]))
def test_mending_twice_is_mending_once(north: MapFeature, op: str) -> None:
    farm = draft(north)
    try:
        mended = apply(op, farm, ["north"], {}).applied_to(farm)
    except OperationRefused:
        return
    with pytest.raises(OperationRefused, match="nothing_to_do"):
        apply(op, mended, ["north"], {})


@calm
@given(scribbles())
def test_untangled_is_sound(north: MapFeature) -> None:
    try:
        outcome = apply("untangle", draft(north), ["north"], {})
    except OperationRefused as refused:
        if refused.code in ("nothing_to_do", "vanishes"):
            return
        raise
    assert_sound(outcome, draft(north))


@calm
@given(fields(), st.floats(0.1, 15))
def test_an_inset_lies_inside_and_an_outset_around(north: MapFeature, distance: float) -> None:
    around = do("buffer", draft(north), ["north"], distance_m=distance)["north"]
    assert metres(around).buffer(0.01).covers(metres(north))
    inside = tried("buffer", draft(north), ["north"], distance_m=-distance)
    for one in (inside or {}).values():
        assert metres(north).buffer(0.01).covers(metres(one))
        assert metres(north).boundary.distance(metres(one)) == pytest.approx(distance, abs=0.01)


@calm
@given(fields(), offsets, angles)
def test_shifting_and_turning_keep_the_shape(north: MapFeature, offset: float, angle: float) -> None:
    assume(abs(offset) > 0.01)
    shifted = do("shift", draft(north), ["north"], east_m=offset, north_m=angle)
    turned = do("turn", draft(north), ["north"], angle_deg=offset)
    for one in (shifted["north"], turned["north"]):
        assert metres(one).area == pytest.approx(metres(north).area, abs=0.002 * metres(north).length)
    back = do("shift", shifted, ["north"], east_m=-offset, north_m=-angle)
    assert metres(back["north"]).hausdorff_distance(metres(north)) < 0.01
    back = do("turn", turned, ["north"], angle_deg=-offset)
    assert metres(back["north"]).hausdorff_distance(metres(north)) < 0.01


@calm
@given(fields(), st.floats(0.05, 5))
def test_simplified_stays_near_and_has_fewer_corners(north: MapFeature, tolerance: float) -> None:
    after = tried("simplify", draft(north), ["north"], tolerance_m=tolerance)
    if after is not None:
        assert metres(after["north"]).boundary.hausdorff_distance(metres(north).boundary) < tolerance + 0.01


@calm
@given(fields(), offsets, offsets)
def test_clipped_parcels_overlap_no_more(north: MapFeature, east: float, up: float) -> None:
    other = area("other", box(east, up, east + 50, up + 50))
    after = tried("clip", draft(north, other), ["north"], others=["other"])
    if after is not None:
        pieces = [metres(one) for key, one in after.items() if key != "other"]
        assert all(piece.intersection(metres(other)).area < 0.3 for piece in pieces)
        left = metres(north).difference(metres(other)).area
        assert sum(piece.area for piece in pieces) == pytest.approx(left, abs=0.5)
