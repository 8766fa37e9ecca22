"""Holes, clips and what mends a drawing."""

from __future__ import annotations

import pytest
import shapely

from hmi.mapping.checks import check
from hmi.mapping.feature import parse_feature
from tests.hmi.mapping.farms import area, box, degrees, do, draft, line, metres, point, raw
from tests.hmi.mapping.small_farm import BOW, FARM, HOLED, LANE, NORTH, label, refused


def test_a_hole_is_added_and_removed() -> None:
    after = do("add_hole", FARM, ["nordfeld-12"], ring=degrees(box(10, 10, 20, 20)))
    assert metres(after["nordfeld-12"]).area == pytest.approx(5900, rel=1e-4)
    hole = after["nordfeld-12"].geometry["coordinates"][1]
    assert not shapely.is_ccw(shapely.linearrings(hole))
    assert do("remove_hole", after, ["nordfeld-12"], ring=1) == FARM
    assert label("add_hole", FARM, ["nordfeld-12"], ring=degrees(box(10, 10, 20, 20))) == "Hole added in Nordfeld 12"
    assert label("remove_hole", after, ["nordfeld-12"], ring=1) == "Hole removed from Nordfeld 12"


@pytest.mark.parametrize(
    ("ring", "code"),
    [
        (box(-10, 10, 10, 20), "outside"),
        (box(0, 10, 10, 20), "outside"),
        (box(200, 10, 210, 20), "outside"),
        (box(45, 25, 55, 35), "meets_hole"),
        (box(60, 20, 70, 40), "meets_hole"),
        (box(30, 10, 70, 50), "meets_hole"),
        ([(5, 5), (15, 15), (15, 5), (5, 15)], "crosses_itself"),
        ([(5, 5), (15, 15)], "too_few_corners"),
    ],
)
def test_a_hole_that_cannot_be_is_refused(ring: list[tuple[float, float]], code: str) -> None:
    assert refused("add_hole", draft(HOLED), ["holed"], ring=degrees(ring)).code == code


def test_only_parcels_have_holes_to_add_or_remove() -> None:
    barn = draft(area("barn", box(0, 0, 50, 50), kind="building"))
    assert refused("add_hole", barn, ["barn"], ring=degrees(box(10, 10, 20, 20))).code == "not_a_parcel"
    assert refused("remove_hole", FARM, ["nordfeld-12"], ring=1).code == "no_hole"
    assert refused("remove_hole", draft(HOLED), ["holed"], ring=0).code == "bad_argument"
    assert refused("remove_hole", draft(HOLED), ["holed"], ring=2).code == "bad_argument"


def test_clip_takes_away_what_others_cover() -> None:
    over = draft(NORTH, area("over", box(90, -10, 150, 70)))
    assert metres(do("clip", over, ["nordfeld-12"], others=["over"])["nordfeld-12"]).area == pytest.approx(
        5400, rel=1e-4
    )
    assert label("clip", over, ["nordfeld-12"], others=["over"]) == "Nordfeld 12 cut back at Over"
    pole = draft(NORTH, point("pole", (50, 30), kind="obstacle", radius_m=2))
    assert len(do("clip", pole, ["nordfeld-12"], others=["pole"])["nordfeld-12"].geometry["coordinates"]) == 2


def test_clip_by_a_road_cuts_its_width_and_makes_two() -> None:
    through = draft(NORTH, line("way", [(40, -10), (40, 70)], width_m=4))
    after = do("clip", through, ["nordfeld-12"], others=["way"])
    assert metres(after["nordfeld-12"]).area == pytest.approx(58 * 60, rel=1e-3)
    assert metres(after["nordfeld-12-b"]).area == pytest.approx(38 * 60, rel=1e-3)


def test_clip_refuses_what_does_not_overlap_and_what_leaves_nothing() -> None:
    assert refused("clip", FARM, ["nordfeld-12"], others=["east"]).code == "nothing_to_do"
    assert refused("clip", FARM, ["nordfeld-12"], others=["nordfeld-12"]).code == "bad_argument"
    assert refused("clip", FARM, ["nordfeld-12"], others=["nowhere"]).code == "unknown_feature"
    assert (
        refused("clip", draft(NORTH, area("all", box(-9, -9, 200, 200))), ["nordfeld-12"], others=["all"]).code
        == "vanishes"
    )


def test_orient_turns_rings_round_and_keeps_the_first_corner() -> None:
    wrong = area("wrong", box(0, 0, 100, 60)[::-1], box(40, 20, 60, 40))
    after = do("orient", draft(wrong), ["wrong"])["wrong"]
    assert after.geometry == HOLED.geometry
    assert refused("orient", draft(HOLED), ["holed"]).code == "nothing_to_do"


def test_clean_takes_away_double_corners_and_spikes() -> None:
    messy = area("messy", [(0, 0), (50, 0), (50, 0.004), (100, 0), (100, 60), (100, 90), (100, 60), (0, 60), (0, 0)])
    after = do("clean", draft(messy), ["messy"])["messy"]
    assert len(after.geometry["coordinates"][0]) == 6
    assert metres(after).area == pytest.approx(6000, abs=0.5)
    assert refused("clean", draft(after), ["messy"]).code == "nothing_to_do"


def test_clean_drops_a_hole_that_is_only_a_spike_but_never_the_whole() -> None:
    spike = area("spike", box(0, 0, 100, 60), [(10, 10), (20, 10), (30, 10), (10, 10)])
    assert len(do("clean", draft(spike), ["spike"])["spike"].geometry["coordinates"]) == 1
    flat = area("flat", [(0, 0), (50, 0), (100, 0), (0, 0)])
    assert refused("clean", draft(flat), ["flat"]).code == "vanishes"


def test_untangle_joins_the_corners_in_another_order() -> None:
    after = do("untangle", draft(BOW), ["bow"])
    assert metres(after["bow"]).area == pytest.approx(3600, rel=1e-4)
    assert sorted(after["bow"].geometry["coordinates"][0][:-1]) == sorted(BOW.geometry["coordinates"][0][:-1])


def test_untangle_makes_one_of_holes_that_overlap() -> None:
    two = area("two", box(0, 0, 100, 60), box(10, 10, 30, 30)[::-1], box(20, 20, 40, 40)[::-1])
    after = do("untangle", draft(two), ["two"])["two"]
    assert len(after.geometry["coordinates"]) == 2
    assert metres(after).area == pytest.approx(6000 - 700, rel=1e-4)
    assert refused("untangle", FARM, ["nordfeld-12"]).code == "nothing_to_do"


def test_what_crosses_itself_is_to_be_untangled_first() -> None:
    both = draft(BOW, NORTH)
    for op, args in {
        "split": {"line": degrees([(-5, 5), (100, 5)])},
        "buffer": {"distance_m": 1},
        "simplify": {"tolerance_m": 1},
        "add_hole": {"ring": degrees(box(1, 1, 2, 2))},
        "clip": {"others": ["nordfeld-12"]},
    }.items():
        refusal = refused(op, draft(area("bow", [(0, 0), (60, 0), (0, 60), (60, 60), (0, 0)]), NORTH), ["bow"], **args)
        assert refusal.code == "crosses_itself", op
    assert refused("merge", both, ["bow", "nordfeld-12"]).code == "crosses_itself"


# snap_end, swap_axes


def test_a_road_end_is_brought_onto_the_other_road() -> None:
    short = line("short", [(20, 50), (20, -1.2)])
    after = do("snap_end", draft(LANE, short), ["short"], to="lane")["short"]
    assert metres(after).coords[-1] == pytest.approx((20, -2), abs=0.002)
    assert after.geometry["coordinates"][0] == short.geometry["coordinates"][0]
    joined = draft(LANE, after)
    assert refused("snap_end", joined, ["short"], to="lane").code == "nothing_to_do"


def test_a_road_end_too_far_away_is_refused() -> None:
    assert refused("snap_end", draft(LANE, line("far", [(20, 50), (20, 30)])), ["far"], to="lane").code == "too_far"
    assert refused("snap_end", FARM, ["lane"], to="east").code == "not_a_road"
    assert refused("snap_end", FARM, ["lane"], to="lane").code == "not_a_road"
    assert refused("snap_end", FARM, ["east"], to="lane").code == "not_a_road"


def test_a_road_end_reaches_a_yard() -> None:
    yard = area("yard", box(0, 0, 30, 30), kind="road")
    after = do("snap_end", draft(yard, line("lane", [(80, 15), (32, 15)])), ["lane"], to="yard")["lane"]
    assert metres(after).coords[-1] == pytest.approx((30, 15), abs=0.002)


def test_swapped_axes_are_exchanged_there_and_back() -> None:
    swapped = do("swap_axes", FARM, ["nordfeld-12", "lane"])
    assert swapped["lane"].geometry["coordinates"][0] == LANE.geometry["coordinates"][0][::-1]
    assert shapely.is_ccw(shapely.linearrings(swapped["nordfeld-12"].geometry["coordinates"][0]))
    assert do("swap_axes", swapped, ["nordfeld-12", "lane"]) == FARM
    east = parse_feature(raw("far", "home", {"type": "Point", "coordinates": [120.0, 30.0]}))
    assert refused("swap_axes", draft(east), ["far"]).code == "not_swapped"


def test_a_strip_is_given_to_one_parcel_and_the_other_stays_to_the_last_digit() -> None:
    east = area("east", box(100.3, 0, 150, 60), name="East")
    farm = draft(NORTH, east)
    after = do("close_gap", farm, ["nordfeld-12"], to="east")
    assert after["east"] == east
    assert metres(after["nordfeld-12"]).area == pytest.approx(100.3 * 60, abs=0.5)
    assert metres(after["nordfeld-12"]).distance(metres(east)) < 0.005
    assert label("close_gap", farm, ["nordfeld-12"], to="east") == "Gap between Nordfeld 12 and East closed"


def test_a_gap_that_is_none_or_too_wide_is_not_closed() -> None:
    assert refused("close_gap", FARM, ["nordfeld-12"], to="east").code == "nothing_to_do"
    wide = draft(NORTH, area("east", box(101, 0, 150, 60)))
    assert refused("close_gap", wide, ["nordfeld-12"], to="east").code == "nothing_to_do"
    assert refused("close_gap", FARM, ["nordfeld-12"], to="nordfeld-12").code == "bad_argument"
    assert metres(do("close_gap", wide, ["east"], to="nordfeld-12", width_m=2)["east"]).area == pytest.approx(
        3000, abs=1
    )


def test_an_area_across_longitude_180_becomes_one_on_each_side() -> None:
    ring = [[179.99, -16.8], [-179.98, -16.8], [-179.98, -16.7], [179.99, -16.7]]
    taveuni = parse_feature(raw("taveuni", "parcel", {"type": "Polygon", "coordinates": [ring]}, crop="Taro"))
    after = do("cut_antimeridian", draft(taveuni), ["taveuni"])
    east, west = after["taveuni"], after["taveuni-b"]
    assert [min(p[0] for p in one.geometry["coordinates"][0]) for one in (east, west)] == [-180.0, 179.99]
    assert west.properties == {"crop": "Taro"}
    assert refused("cut_antimeridian", FARM, ["east"]).code == "nothing_to_do"


def test_a_road_across_longitude_180_becomes_one_on_each_side_with_one_tap() -> None:
    places = [[179.98, -16.8], [179.99, -16.79], [-179.97, -16.75]]
    road = parse_feature(raw("ring", "road", {"type": "LineString", "coordinates": places}, width_m=4))
    fix = next(one.fix for one in check([road]) if one.code == "antimeridian")
    assert fix is not None
    assert (fix.label, fix.op) == ("Cut at 180°", "cut_antimeridian")
    after = do("cut_antimeridian", draft(road), ["ring"])
    east, west = after["ring"].geometry["coordinates"], after["ring-b"].geometry["coordinates"]
    assert [west[0], west[-1]] == [[179.98, -16.8], [180.0, west[-1][1]]]
    assert [east[0], east[-1]] == [[-180.0, west[-1][1]], [-179.97, -16.75]]
    assert west[-1][1] == pytest.approx(-16.78, abs=1e-8)
    assert not [one for one in check(list(after.values())) if one.code == "antimeridian"]
    lanes = {"type": "MultiLineString", "coordinates": [places, [[1, 2], [1, 3]]]}
    rows = parse_feature(raw("rows-9", "rows", lanes))
    assert next(one.fix for one in check([rows]) if one.code == "antimeridian") is None
    assert refused("cut_antimeridian", draft(rows), ["rows-9"]).code == "cannot_cut"


def test_a_removed_parcel_takes_its_rows_along() -> None:
    rows = line("rows-1", [(10, 5), (10, 50)], kind="rows", parcel_id="nordfeld-12")
    assert set(do("remove", FARM | {rows.id: rows}, ["nordfeld-12"])) == {"east", "lane"}
