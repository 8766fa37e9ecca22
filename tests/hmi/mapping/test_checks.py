"""What is found on a map, in which words, and that each fix mends what it is offered for."""

from __future__ import annotations

import math

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hmi.demo import farm
from hmi.mapping.checks import BLOCKS, LOOK, Finding, check
from hmi.mapping.errors import OperationRefused
from hmi.mapping.feature import MapFeature, parse_feature
from hmi.mapping.operations import apply
from tests.hmi.mapping.farms import area, box, degrees, draft, fields, line, metres, point, raw, scribbles

NORTH = area("north", box(0, 0, 100, 60))
HOME = point("home", (-20, -2))
LANE = line("lane", [(-50, -2), (120, -2)], name="Lane")


def found(*features: MapFeature, width_m: float | None = None) -> list[Finding]:
    return check(features, width_m)


def only(*features: MapFeature, width_m: float | None = None) -> Finding:
    findings = found(*features, width_m=width_m)
    assert len(findings) == 1, findings
    return findings[0]


def said(finding: Finding) -> str:
    return f"{finding.text} {finding.advice}"


def after_fix(finding: Finding, *features: MapFeature) -> list[Finding]:
    assert finding.fix is not None
    outcome = apply(finding.fix.op, draft(*features), finding.fix.features, finding.fix.args)
    return check(outcome.applied_to(draft(*features)).values())


def test_a_sound_map_has_no_findings() -> None:
    assert found() == []
    assert found(NORTH, area("east", box(100, 0, 200, 60)), LANE, point("home", (-3, 3)), width_m=3) == []


def test_the_demo_farm_may_be_published() -> None:
    features = [parse_feature(raw(f.id, f.kind, f.geometry, name=f.name, **f.properties)) for f in farm.features()]
    assert check(features, 1.7) == []


def test_an_edge_that_crosses_itself_blocks_and_says_between_which_corners() -> None:
    # edge 2-3 crosses edge 5-6
    ring = [(0, 0), (60, 0), (60, 60), (80, 60), (80, 30), (20, 30), (0, 60), (0, 0)]
    bad = area("bad", ring)
    finding = only(bad)
    assert (finding.code, finding.level, finding.feature_id) == ("crosses_itself", BLOCKS, "bad")
    assert said(finding) == "Edge crosses itself. Between corner 3 and 5. Move one of them."
    assert finding.at == pytest.approx(degrees([(60, 30)])[0], abs=2e-8)
    assert after_fix(finding, bad) == []


def test_a_hole_that_crosses_itself_is_named() -> None:
    bad = area("bad", box(0, 0, 100, 60), [(20, 20), (40, 40), (40, 20), (20, 40), (20, 20)])
    assert found(bad)[0].text == "Edge of hole 1 crosses itself."
    assert after_fix(found(bad)[0], bad) == []


def test_double_and_spike_corners_are_to_look_at_unless_they_break_the_outline() -> None:
    double = area("double", [(0, 0), (50, 0), (50.005, 0), (100, 0), (100, 60), (0, 60), (0, 0)])
    finding = only(double)
    assert (finding.code, finding.level) == ("needless_corner", LOOK)
    assert said(finding) == "Corner 3 is double or a spike. Remove it; the shape stays the same."
    assert after_fix(finding, double) == []
    spike = area("spike", [(0, 0), (100, 0), (100, 60), (100, 90), (100, 60), (0, 60), (0, 0)])
    finding = only(spike)
    assert (finding.code, finding.level) == ("needless_corner", BLOCKS)
    assert after_fix(finding, spike) == []


def test_a_road_that_turns_back_on_itself_is_to_look_at() -> None:
    road = line("road", [(0, 0), (50, 0), (20, 0.01), (20, 40)])
    assert only(road).code == "needless_corner"


def test_wrong_winding_is_to_look_at() -> None:
    for wrong in (area("wrong", box(0, 0, 100, 60)[::-1]), area("wrong", box(0, 0, 100, 60), box(9, 9, 20, 20))):
        finding = only(wrong)
        assert (finding.code, finding.level) == ("winding", LOOK)
        assert after_fix(finding, wrong) == []


@pytest.mark.parametrize(
    ("hole", "text", "op"),
    [
        (box(200, 0, 220, 20), "Hole 1 is outside.", "remove_hole"),
        (box(90, 10, 110, 20), "Hole 1 reaches across the edge.", "untangle"),
    ],
)
def test_a_hole_outside_blocks(hole: list[tuple[float, float]], text: str, op: str) -> None:
    bad = area("bad", box(0, 0, 100, 60), hole[::-1])
    finding = only(bad)
    assert (finding.code, finding.level, finding.text) == ("hole_outside", BLOCKS, text)
    assert finding.fix
    assert finding.fix.op == op
    assert after_fix(finding, bad) == []


@pytest.mark.parametrize(
    ("second", "word"),
    [(box(20, 20, 40, 40), "overlap"), (box(30, 10, 40, 30), "touch"), (box(30, 30, 40, 40), "touch")],
)
def test_holes_that_meet_block(second: list[tuple[float, float]], word: str) -> None:
    bad = area("bad", box(0, 0, 100, 60), box(10, 10, 30, 30)[::-1], second[::-1])
    finding = only(bad)
    assert (finding.code, finding.level) == ("holes_meet", BLOCKS)
    assert finding.text == f"Hole 1 and hole 2 {word}."


def test_overlapping_holes_are_made_one() -> None:
    bad = area("bad", box(0, 0, 100, 60), box(10, 10, 30, 30)[::-1], box(20, 20, 40, 40)[::-1])
    assert after_fix(only(bad), bad) == []


@pytest.mark.parametrize("hole", [box(40, 0, 60, 20), [(50, 0), (60, 10), (40, 10), (50, 0)], box(40, 0.005, 60, 20)])
def test_a_hole_that_touches_the_edge_becomes_a_bay(hole: list[tuple[float, float]]) -> None:
    bad = area("bad", box(0, 0, 100, 60), hole[::-1])
    finding = only(bad)
    level = LOOK if metres(bad).is_valid else BLOCKS
    assert (finding.code, finding.level, finding.text) == ("hole_touches", level, "Hole 1 touches the edge.")
    assert after_fix(finding, bad) == []


def test_a_parcel_too_small_to_be_one_can_be_removed_with_one_tap() -> None:
    crumb = area("crumb", box(200, 0, 203, 3))
    finding = only(NORTH, crumb)
    assert (finding.code, finding.text) == ("area", "Parcel has 9.0 m². That is very small.")
    assert after_fix(finding, NORTH, crumb) == []


def test_parcels_that_overlap_are_to_look_at() -> None:
    other = area("other", box(99.5, 10, 150, 38), name="Other")
    finding = only(NORTH, other)
    assert (finding.code, finding.level, finding.feature_id, finding.other_id) == ("overlap", LOOK, "north", "other")
    assert finding.text == "Parcels overlap by 14 m²."
    assert finding.fix
    assert finding.fix.label == "Cut back North"
    assert after_fix(finding, NORTH, other) == []


def test_an_overlap_of_less_than_a_square_metre_is_nothing() -> None:
    assert found(NORTH, area("other", box(99.99, 0, 150, 60))) == []


def test_a_parcel_drawn_twice_becomes_one() -> None:
    again = area("again", box(0, 0, 100, 60))
    finding = only(NORTH, again)
    assert finding.code == "overlap"
    assert after_fix(finding, NORTH, again) == []


def test_a_sliver_between_parcels_is_to_look_at() -> None:
    finding = only(NORTH, area("other", box(100.2, 0, 150, 60)))
    assert (finding.code, finding.level) == ("sliver", LOOK)
    assert finding.text == "A strip of 12 m² lies between two parcels."
    assert after_fix(finding, NORTH, area("other", box(100.2, 0, 150, 60))) == []
    assert found(NORTH, area("other", box(100.6, 0, 150, 60))) == []
    assert found(NORTH, area("other", box(100.005, 0, 150, 60))) == []


def test_a_sliver_along_part_of_a_longer_edge_is_found() -> None:
    long = area("long", box(-500, 60.3, 900, 200))
    assert [one.code for one in found(NORTH, long)] == ["sliver"]


def test_a_road_that_ends_short_is_to_look_at() -> None:
    short = line("short", [(20, 50), (20, -1.2)])
    finding = only(LANE, short)
    assert (finding.code, finding.level, finding.feature_id, finding.other_id) == ("road_gap", LOOK, "short", "lane")
    assert said(finding) == "Road ends 0.8 m short. Robots cannot route across the gap."
    assert finding.fix
    assert finding.fix.label == "Join to Lane"
    assert after_fix(finding, LANE, short) == []


def test_two_ends_that_miss_each_other_are_one_gap() -> None:
    parts = (line("west", [(0, 0), (50, 0)]), line("east", [(51, 0), (90, 0)]))
    assert only(*parts).text == "Road ends 1.0 m short."
    assert after_fix(only(*parts), *parts) == []


def test_roads_that_meet_or_are_far_apart_are_no_gap() -> None:
    assert found(LANE, line("joined", [(20, 50), (20, -2)])) == []
    assert found(LANE, line("far", [(20, 50), (20, 2)])) == []
    assert found(area("yard", box(0, 0, 30, 30), kind="road"), line("in", [(80, 15), (20, 15)])) == []


def test_a_road_joined_to_one_may_pass_near_another() -> None:
    assert found(LANE, line("a", [(20, 50), (20, -2)]), line("b", [(60, 50), (22, -2)])) == []


def test_a_parcel_no_road_leads_to_is_to_look_at() -> None:
    far = area("far", box(0, 200, 50, 250))
    finding = only(NORTH, LANE, far)
    assert (finding.code, finding.level, finding.feature_id) == ("unreachable", LOOK, "far")
    assert finding.text == "No road or home within 30 m of this parcel."
    assert found(NORTH, far) == []  # a farm without roads
    assert found(NORTH, LANE, HOME, far, point("other-home", (60, 225))) == []


def test_a_parcel_whose_roads_lead_to_no_home_is_to_look_at() -> None:
    far = area("far", box(0, 200, 50, 250))
    alone = line("alone", [(60, 220), (90, 220)])
    finding = only(NORTH, LANE, HOME, far, alone)
    assert (finding.code, finding.level, finding.feature_id) == ("unreachable", LOOK, "far")
    assert said(finding).startswith("The road here leads to no home. ")
    joined = line("joined", [(80, 220), (80, -2)])
    assert found(NORTH, LANE, HOME, far, alone, joined) == []
    shut = area("shut", box(70, 100, 90, 120), kind="no-go")
    assert [one.code for one in found(NORTH, LANE, HOME, far, alone, joined, shut)] == ["unreachable", "road_closed"]
    around = line("around", [(80, 140), (110, 140), (110, 80), (80, 80)])
    assert [one.code for one in found(NORTH, LANE, HOME, far, alone, joined, shut, around)] == ["road_closed"]


def test_a_road_through_closed_ground_is_to_look_at() -> None:
    shut = area("shut", box(40, -20, 70, 20), kind="no-go", name="Wet meadow")
    finding = only(LANE, shut)
    assert (finding.code, finding.level, finding.feature_id, finding.other_id) == ("road_closed", LOOK, "lane", "shut")
    assert said(finding).startswith("Road runs 30 m through Wet meadow.")
    stone = point("stone", (40, -2), kind="obstacle", radius_m=2)
    assert only(LANE, stone).text.startswith("Road runs 4 m through ")
    assert found(LANE, area("barn", box(119.5, -10, 140, 10), kind="building")) == [], "it ends at its door"
    assert found(LANE, area("ditch", box(40, -20, 44, 20), kind="water")) == [], "a road over water is a bridge"
    yard = area("yard", box(0, 0, 60, 60), kind="road")
    assert found(yard, area("hall", box(10, 10, 30, 30), kind="building")) == []


def test_a_parcel_narrower_than_the_machine_is_to_look_at() -> None:
    strip = area("strip", box(0, 0, 100, 2.4))
    finding = only(strip, width_m=2.5)
    assert (finding.code, finding.level) == ("too_narrow", LOOK)
    assert said(finding).startswith("Parcel is too narrow for the machine. It needs 2.5 m")
    assert found(strip, width_m=2.3) == []
    assert found(strip) == []
    ring = area("ring", box(0, 0, 40, 40), box(2, 2, 38, 38)[::-1])
    assert only(ring, width_m=3).code == "too_narrow"


@pytest.mark.parametrize(
    ("side", "text"),
    [(4.4, "Parcel has 19 m². That is very small."), (2300, "Parcel has 529.00 ha. That is very large.")],
)
def test_an_area_no_parcel_has_is_to_look_at(side: float, text: str) -> None:
    finding = only(area("odd", box(0, 0, side, side)))
    assert (finding.code, finding.level, finding.text) == ("area", LOOK, text)
    assert found(area("farm", box(0, 0, side, side), kind="farm")) == []


def test_a_shape_across_longitude_180_blocks() -> None:
    ring = [[179.99, -17], [-179.99, -17], [-179.99, -16.99], [179.99, -16.99]]
    bad = parse_feature(raw("taveuni", "parcel", {"type": "Polygon", "coordinates": [ring]}))
    finding = only(bad, NORTH)
    assert (finding.code, finding.level, finding.feature_id) == ("antimeridian", BLOCKS, "taveuni")
    assert after_fix(finding, bad, NORTH) == []


def test_exchanged_latitude_and_longitude_block_and_are_exchanged_back_together() -> None:
    others = (NORTH, area("east", box(100, 0, 200, 60)), area("south", box(0, -80, 90, -10)))
    names = ("east", "south")
    swapped = apply("swap_axes", draft(*others), names, {}).applied_to(draft(*others))
    findings = check([*swapped.values(), LANE])
    assert [(one.code, one.level, one.feature_id) for one in findings if one.level == BLOCKS] == [
        ("swapped", BLOCKS, "east"),
        ("swapped", BLOCKS, "south"),
    ]
    assert all(one.level == LOOK for one in after_fix(findings[0], *swapped.values(), LANE))


def test_a_second_site_far_away_is_not_exchanged() -> None:
    spain = parse_feature(raw("spain", "home", {"type": "Point", "coordinates": [-3.48, 40.31]}))
    kenya = parse_feature(raw("kenya", "home", {"type": "Point", "coordinates": [40.31, -3.48]}))
    assert found(NORTH, spain) == []
    assert [one.feature_id for one in found(NORTH, spain, kenya)] == ["kenya"]


def test_neighbours_are_compared_on_every_site() -> None:
    away = [degrees(box(0, 0, 50, 50)), degrees(box(45, 0, 99, 50))]
    spain = [
        parse_feature(
            raw(f"spain-{n}", "parcel", {"type": "Polygon", "coordinates": [[[x - 7.7, y - 11.4] for x, y in ring]]})
        )
        for n, ring in enumerate(away)
    ]
    assert [one.code for one in found(NORTH, *spain)] == ["overlap"]


def test_what_blocks_comes_first_and_findings_are_plain_json() -> None:
    bow = area("bow", [(300, 0), (360, 0), (300, 60), (360, 60), (300, 0)])
    other = area("other", box(99.5, 10, 150, 38))
    findings = found(NORTH, other, bow)
    assert [one.level for one in findings] == [BLOCKS, LOOK]
    document = findings[1].as_json()
    assert set(document) == {"code", "level", "feature_id", "other_id", "text", "advice", "at", "fix"}
    assert document["fix"] == {
        "label": "Cut back North",
        "op": "clip",
        "features": ["north"],
        "args": {"others": ["other"]},
    }
    assert found(area("a", box(0, 0, 3000, 3000)))[0].as_json()["fix"] is None


calm = settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])


@calm
@given(scribbles())
def test_what_does_not_block_is_sound(north: MapFeature) -> None:
    blocked = any(one.level == BLOCKS for one in found(north))
    assert blocked == (not metres(north).is_valid)


@calm
@given(scribbles())
@pytest.mark.slow
def test_following_the_fixes_ends_in_a_map_that_may_be_published(north: MapFeature) -> None:
    features = draft(north)
    for _ in range(8):
        fix = next((one.fix for one in check(features.values()) if one.level == BLOCKS), None)
        if fix is None:
            return
        try:
            features = apply(fix.op, features, fix.features, fix.args).applied_to(features)
        except OperationRefused as refused:
            if refused.code == "vanishes":  # there is nothing but spikes
                return
            raise
    raise AssertionError("fixes go round in circles")


@calm
@given(fields(), fields(), st.floats(0, 60), st.floats(0, math.tau))
@pytest.mark.slow
def test_overlaps_are_found_exactly_where_there_are_some(
    a: MapFeature, b: MapFeature, way: float, towards: float
) -> None:
    b = MapFeature("south", b.kind, "South", b.geometry, b.properties)
    step = {"east_m": way * math.cos(towards) + 0.01, "north_m": way * math.sin(towards)}
    b = apply("shift", draft(b), ["south"], step).changes[0].after or b
    shared = metres(a).intersection(metres(b)).area
    codes = [one.code for one in found(a, b)]
    if shared > 1.01:
        assert "overlap" in codes
    if shared < 0.99:
        assert "overlap" not in codes
