"""Each operation on plain examples, and what it refuses."""

from __future__ import annotations

import math
from typing import Any

import pytest
import shapely

from hmi.mapping.errors import OperationRefused
from hmi.mapping.feature import MapFeature, parse_feature
from hmi.mapping.operations import OPERATIONS, apply
from tests.hmi.mapping.farms import HERE, area, box, degrees, do, draft, line, metres, point, raw

NORTH = area("nordfeld-12", box(0, 0, 100, 60), name="Nordfeld 12", crop="Wheat", row_bearing_deg=11.5)
EAST = area("east", box(100, 0, 150, 60), name="East")
HOLED = area("holed", box(0, 0, 100, 60), box(40, 20, 60, 40)[::-1], name="Holed")
BOW = area("bow", [(0, 0), (60, 0), (0, 60), (60, 60), (0, 0)], name="Bow")
LANE = line("lane", [(-50, -2), (0, -2), (120, -2)], name="Lane", width_m=4)
FARM = draft(NORTH, EAST, LANE)


def refused(op: str, features: dict[str, MapFeature], ids: list[str], **args: Any) -> OperationRefused:
    with pytest.raises(OperationRefused) as caught:
        apply(op, features, ids, args)
    assert caught.value.text.endswith(".")
    return caught.value


def label(op: str, features: dict[str, MapFeature], ids: list[str], **args: Any) -> str:
    return apply(op, features, ids, args).label


# split


def test_the_larger_piece_of_a_split_keeps_id_name_and_attributes() -> None:
    after = do("split", FARM, ["nordfeld-12"], line=degrees([(70, -5), (70, 65)]))
    assert metres(after["nordfeld-12"]).area == pytest.approx(70 * 60, rel=1e-4)
    piece = after["nordfeld-12-b"]
    assert metres(piece).area == pytest.approx(30 * 60, rel=1e-4)
    assert (piece.name, piece.kind, piece.properties) == ("Nordfeld 12 b", "parcel", NORTH.properties)


def test_a_split_says_into_how_many() -> None:
    assert label("split", FARM, ["nordfeld-12"], line=degrees([(70, -5), (70, 65)])) == "Split Nordfeld 12 in two"
    zigzag = degrees([(20, -5), (20, 65), (70, 65), (70, -5)])
    assert label("split", FARM, ["nordfeld-12"], line=zigzag) == "Split Nordfeld 12 in three"


def test_a_new_piece_never_takes_an_id_that_exists() -> None:
    taken = draft(NORTH, area("nordfeld-12-b", box(200, 0, 220, 20)))
    after = do("split", taken, ["nordfeld-12"], line=degrees([(70, -5), (70, 65)]))
    assert set(after) == {"nordfeld-12", "nordfeld-12-b", "nordfeld-12-c"}
    again = do("split", after, ["nordfeld-12-c"], line=degrees([(80, -5), (80, 65)]))
    assert set(again) - set(after) == {"nordfeld-12-d"}
    assert again["nordfeld-12-d"].name == "Nordfeld 12 d"


def test_the_longest_id_still_makes_room_for_a_letter() -> None:
    long = area("x" * 64, box(0, 0, 100, 60))
    after = do("split", draft(long), [long.id], line=degrees([(70, -5), (70, 65)]))
    assert set(after) == {"x" * 64, "x" * 62 + "-b"}


def test_a_split_line_that_ends_on_the_edge_cuts_through() -> None:
    assert len(do("split", FARM, ["nordfeld-12"], line=degrees([(70, 0), (70, 60)]))) == len(FARM) + 1


def test_a_split_through_a_hole_makes_two_bays() -> None:
    after = do("split", draft(HOLED), ["holed"], line=degrees([(50, -5), (50, 65)]))
    assert [len(one.geometry["coordinates"]) for one in after.values()] == [1, 1]
    assert sum(metres(one).area for one in after.values()) == pytest.approx(metres(HOLED).area, abs=0.5)


def test_a_line_that_does_not_cut_through_is_refused() -> None:
    assert refused("split", FARM, ["nordfeld-12"], line=degrees([(70, -5), (70, 30)])).code == "no_cut"
    assert refused("split", FARM, ["nordfeld-12"], line=degrees([(170, -5), (170, 30)])).code == "no_cut"
    assert refused("split", draft(HOLED), ["holed"], line=degrees([(50, -5), (50, 30)])).code == "no_cut"


def test_a_split_that_cuts_off_a_crumb_is_refused() -> None:
    assert refused("split", FARM, ["nordfeld-12"], line=degrees([(-5, 59.999), (105, 59.999)])).code == "crumb"


def test_a_road_is_split_where_it_is_crossed() -> None:
    after = do("split", FARM, ["lane"], line=degrees([(20, -10), (20, 10)]))
    assert metres(after["lane"]).length == pytest.approx(100, abs=0.01)
    assert metres(after["lane-b"]).length == pytest.approx(70, abs=0.01)
    assert after["lane"].geometry["coordinates"][0] == after["lane-b"].geometry["coordinates"][-1]
    assert refused("split", FARM, ["lane"], line=degrees([(20, 10), (20, 20)])).code == "no_cut"


def test_rows_follow_the_piece_they_lie_in() -> None:
    rows = line("ab", [(80, 5), (80, 55)], kind="rows", parcel_id="nordfeld-12", type="a-b")
    after = do("split", draft(NORTH, rows), ["nordfeld-12"], line=degrees([(70, -5), (70, 65)]))
    assert after["ab"].properties["parcel_id"] == "nordfeld-12-b"
    merged = do("merge", after, ["nordfeld-12", "nordfeld-12-b"])
    assert merged == draft(merged["nordfeld-12"], rows)


def test_points_and_bundles_of_rows_cannot_be_split() -> None:
    rows = parse_feature(
        raw(
            "rows",
            "rows",
            {"type": "MultiLineString", "coordinates": [degrees([(0, 0), (9, 0)]), degrees([(0, 1), (9, 1)])]},
        )
    )
    for one in (point("home", (0, 0)), rows):
        assert refused("split", draft(one), [one.id], line=degrees([(5, -5), (5, 5)])).code == "cannot_split"


# merge


def test_merged_neighbours_are_one_parcel_with_the_larger_one_s_name() -> None:
    after = do("merge", FARM, ["east", "nordfeld-12"])
    assert set(after) == {"nordfeld-12", "lane"}
    assert metres(after["nordfeld-12"]).area == pytest.approx(150 * 60, rel=1e-4)
    assert after["nordfeld-12"].properties == NORTH.properties
    assert label("merge", FARM, ["east", "nordfeld-12"]) == "Merged East and Nordfeld 12"


def test_a_small_gap_is_filled_and_a_large_one_refused() -> None:
    gap = draft(NORTH, area("east", box(100.3, 0, 150, 60)))
    after = do("merge", gap, ["nordfeld-12", "east"])
    assert metres(after["nordfeld-12"]).area == pytest.approx(150 * 60, rel=1e-4)
    assert len(after["nordfeld-12"].geometry["coordinates"]) == 1
    refusal = refused("merge", gap, ["nordfeld-12", "east"], gap_m=0.1)
    assert refusal.code == "apart"
    assert "0.3 m apart" in refusal.text


def test_overlapping_parcels_merge_and_keep_their_holes() -> None:
    other = area("other", box(90, 0, 150, 60), box(120, 20, 130, 30)[::-1])
    after = do("merge", draft(HOLED, other), ["holed", "other"])
    assert len(after["holed"].geometry["coordinates"]) == 3
    assert metres(after["holed"]).area == pytest.approx(150 * 60 - 400 - 100, rel=1e-4)


def test_merge_needs_two_of_one_kind() -> None:
    farm = draft(NORTH, area("barn", box(100, 0, 110, 9), kind="building"), LANE)
    assert refused("merge", farm, ["nordfeld-12"]).code == "two_or_more"
    assert refused("merge", farm, ["nordfeld-12", "barn"]).code == "different_kinds"
    assert refused("merge", draft(LANE, line("b", [(0, 0), (9, 9)])), ["lane", "b"]).code == "not_a_polygon"


# buffer


def test_an_inset_and_an_outset_move_every_edge() -> None:
    after = do("buffer", FARM, ["nordfeld-12"], distance_m=-2)
    assert metres(after["nordfeld-12"]).area == pytest.approx(96 * 56, rel=1e-4)
    after = do("buffer", FARM, ["nordfeld-12", "east"], distance_m=1.5)
    assert metres(after["nordfeld-12"]).area == pytest.approx(103 * 63, rel=1e-4)
    assert label("buffer", FARM, ["nordfeld-12"], distance_m=-2) == "Nordfeld 12 shrunk by 2 m"
    assert label("buffer", FARM, ["nordfeld-12", "east"], distance_m=1.5) == "Nordfeld 12 and East grown by 1.5 m"


def test_an_inset_that_cuts_a_parcel_apart_makes_two() -> None:
    waist = [
        (0, 0),
        (40, 0),
        (40, 18),
        (60, 18),
        (60, 0),
        (90, 0),
        (90, 40),
        (60, 40),
        (60, 22),
        (40, 22),
        (40, 40),
        (0, 40),
        (0, 0),
    ]
    after = do("buffer", draft(area("waist", waist)), ["waist"], distance_m=-3)
    assert set(after) == {"waist", "waist-b"}


def test_an_inset_that_leaves_nothing_is_refused() -> None:
    assert refused("buffer", FARM, ["nordfeld-12"], distance_m=-31).code == "vanishes"
    assert refused("buffer", FARM, ["lane"], distance_m=-2).code == "vanishes"


def test_a_road_grown_is_a_yard_past_its_width() -> None:
    after = do("buffer", FARM, ["lane"], distance_m=1)["lane"]
    assert after.geometry["type"] == "Polygon"
    assert "width_m" not in after.properties
    assert metres(after).bounds == pytest.approx((-53, -5, 123, 1), abs=0.01)


def test_a_round_obstacle_grows_by_its_radius() -> None:
    pole = point("pole", (5, 5), kind="obstacle", radius_m=1.5)
    assert do("buffer", draft(pole), ["pole"], distance_m=0.5)["pole"].properties["radius_m"] == 2.0
    assert refused("buffer", draft(pole), ["pole"], distance_m=-1.5).code == "vanishes"
    assert refused("buffer", draft(point("home", (0, 0))), ["home"], distance_m=1).code == "no_edge"


# straighten, simplify


def test_straighten_leaves_out_the_corners_between() -> None:
    bent = area("bent", [(0, 0), (30, 2), (60, -2), (100, 0), (100, 60), (0, 60), (0, 0)])
    after = do("straighten", draft(bent), ["bent"], **{"from": 0, "to": 3})["bent"]
    assert metres(after).equals_exact(shapely.Polygon(box(0, 0, 100, 60)), 0.01)


def test_straighten_goes_on_past_the_end_of_a_ring() -> None:
    bent = area("bent", [(30, 2), (60, -2), (100, 0), (100, 60), (0, 60), (0, 0), (30, 2)])
    after = do("straighten", draft(bent), ["bent"], **{"from": 5, "to": 2})["bent"]
    assert metres(after).area == pytest.approx(6000, rel=1e-4)


def test_straighten_refuses_neighbours_crossings_and_what_leaves_nothing() -> None:
    assert refused("straighten", FARM, ["nordfeld-12"], **{"from": 0, "to": 1}).code == "nothing_to_do"
    assert refused("straighten", FARM, ["nordfeld-12"], **{"from": 0, "to": 3}).code == "vanishes"
    assert refused("straighten", FARM, ["nordfeld-12"], **{"from": 0, "to": 4}).code == "bad_argument"
    assert refused("straighten", FARM, ["nordfeld-12"], **{"from": 0, "to": 2, "ring": 1}).code == "bad_argument"
    deep = area("deep", [(0, 0), (50, -40), (100, 0), (100, 60), (50, -10), (0, 60), (0, 0)])
    assert refused("straighten", draft(deep), ["deep"], **{"from": 0, "to": 2}).code == "would_cross"
    assert do("straighten", FARM, ["lane"], **{"from": 2, "to": 0})["lane"].geometry["coordinates"] == [
        LANE.geometry["coordinates"][0],
        LANE.geometry["coordinates"][2],
    ]


def test_simplify_stays_within_the_tolerance_and_keeps_corners_exactly() -> None:
    ring = [(100 * math.cos(n / 50 * math.pi), 100 * math.sin(n / 50 * math.pi)) for n in range(100)]
    circle = area("circle", ring)
    after = do("simplify", draft(circle), ["circle"], tolerance_m=1)["circle"]
    assert metres(after).boundary.hausdorff_distance(metres(circle).boundary) <= 1.01
    corners = after.geometry["coordinates"][0]
    assert len(corners) < 40
    assert all(corner in circle.geometry["coordinates"][0] for corner in corners)
    assert label("simplify", draft(circle), ["circle"], tolerance_m=1).startswith("Circle simplified from 100 to ")
    assert (
        do("simplify", FARM, ["lane"], tolerance_m=0.5)["lane"].geometry["coordinates"][0]
        == LANE.geometry["coordinates"][0]
    )
    assert refused("simplify", FARM, ["nordfeld-12"], tolerance_m=1).code == "nothing_to_do"


# shift, turn


def test_shift_moves_all_as_one_piece() -> None:
    after = do("shift", FARM, ["nordfeld-12", "east"], east_m=3, north_m=-4)
    assert metres(after["nordfeld-12"]).bounds == pytest.approx((3, -4, 103, 56), abs=0.002)
    shared = set(map(tuple, after["nordfeld-12"].geometry["coordinates"][0])) & set(
        map(tuple, after["east"].geometry["coordinates"][0])
    )
    assert len(shared) == 2
    assert label("shift", FARM, ["east"], east_m=3, north_m=-4) == "East moved 5.00 m south-east"
    assert refused("shift", FARM, ["east"], east_m=0, north_m=0).code == "nothing_to_do"


def test_turn_is_clockwise_about_the_middle_and_takes_directions_along() -> None:
    tall = do("turn", FARM, ["nordfeld-12"], angle_deg=90)["nordfeld-12"]
    assert metres(tall).bounds == pytest.approx((20, -20, 80, 80), abs=0.002)
    assert tall.properties["row_bearing_deg"] == 101.5
    home = point("home", (0, 0), heading_deg=10)
    turned = do("turn", draft(home, NORTH), ["home", "nordfeld-12"], angle_deg=30)
    assert turned["home"].properties["heading_deg"] == 340
    assert label("turn", FARM, ["nordfeld-12"], angle_deg=-2.5) == "Nordfeld 12 turned 2.5 degrees counter-clockwise"
    # the south-west corner goes north-west
    assert metres(tall).exterior.coords[0] == pytest.approx((20, 80), abs=0.002)


def test_sites_far_apart_do_not_move_as_one() -> None:
    spain = parse_feature(raw("spain", "home", {"type": "Point", "coordinates": [-3.48, 40.31]}))
    assert refused("shift", draft(NORTH, spain), ["nordfeld-12", "spain"], east_m=1, north_m=0).code == "too_far_apart"


# holes, clip


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


# orient, clean, untangle


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


# arguments


@pytest.mark.parametrize(
    ("op", "ids", "args", "code"),
    [
        ("explode", ["lane"], {}, "unknown_operation"),
        ("buffer", [], {"distance_m": 1}, "nothing_chosen"),
        ("buffer", ["east", "east"], {"distance_m": 1}, "chosen_twice"),
        ("buffer", ["west"], {"distance_m": 1}, "unknown_feature"),
        ("buffer", ["east"], {}, "bad_argument"),
        ("buffer", ["east"], {"distance_m": "1"}, "bad_argument"),
        ("buffer", ["east"], {"distance_m": True}, "bad_argument"),
        ("buffer", ["east"], {"distance_m": None}, "bad_argument"),
        ("buffer", ["east"], {"distance_m": math.nan}, "bad_argument"),
        ("buffer", ["east"], {"distance_m": math.inf}, "bad_argument"),
        ("buffer", ["east"], {"distance_m": 1e9}, "bad_argument"),
        ("buffer", ["east"], {"distance_m": 10**400}, "bad_argument"),
        ("buffer", ["east"], {"distance_m": 0}, "nothing_to_do"),
        ("buffer", ["east"], {"distance_m": 1, "joins": "round"}, "bad_argument"),
        ("orient", ["east"], {"way": "left"}, "bad_argument"),
        ("split", ["east", "lane"], {"line": [[4.2, 51.7], [4.3, 51.7]]}, "one_only"),
        ("split", ["east"], {}, "bad_coordinates"),
        ("split", ["east"], {"line": [[4.2, 51.7]]}, "too_few_corners"),
        ("split", ["east"], {"line": [[4.2, 51.7], [4.2, 151.7]]}, "bad_coordinates"),
        ("split", ["east"], {"line": "across"}, "bad_coordinates"),
        ("clip", ["east"], {"others": "lane"}, "bad_argument"),
        ("clip", ["east"], {"others": []}, "bad_argument"),
        ("clip", ["east"], {"others": [7]}, "bad_argument"),
        ("snap_end", ["lane"], {"to": 7}, "bad_argument"),
        ("straighten", ["east"], {"from": 0.0, "to": 2}, "bad_argument"),
        ("straighten", ["east"], {"from": True, "to": 2}, "bad_argument"),
        ("straighten", ["east"], {"from": -1, "to": 2}, "bad_argument"),
        ("simplify", ["east"], {"tolerance_m": 0}, "bad_argument"),
        ("shift", ["east"], {"east_m": 1}, "bad_argument"),
        ("turn", ["east"], {"angle_deg": 361}, "bad_argument"),
    ],
)
def test_a_bad_argument_is_refused(op: str, ids: list[str], args: dict[str, Any], code: str) -> None:
    assert refused(op, FARM, ids, **args).code == code


def test_the_table_of_operations_is_that_of_the_contract() -> None:
    assert set(OPERATIONS) == {
        "split", "merge", "buffer", "straighten", "simplify", "shift", "turn", "add_hole", "remove_hole", "clip",
        "orient", "clean", "untangle", "snap_end", "swap_axes",
    }  # fmt: skip


def test_an_operation_leaves_the_draft_alone() -> None:
    before = draft(area("a", box(0, 0, 100, 60)))
    after = do("shift", before, ["a"], east_m=1, north_m=0)
    after["a"].geometry["coordinates"][0][0][0] = 0.0
    after["a"].properties["x"] = 1
    assert before == draft(area("a", box(0, 0, 100, 60)))


def test_a_corner_that_nobody_touched_stays_to_the_last_digit() -> None:
    after = do("split", FARM, ["nordfeld-12"], line=degrees([(70, -5), (70, 65)]))
    corners = [p for one in ("nordfeld-12", "nordfeld-12-b") for p in after[one].geometry["coordinates"][0]]
    assert all(p in corners for p in NORTH.geometry["coordinates"][0])
    assert HERE.to_local(corners).shape[1] == 2


def test_arguments_on_the_other_side_of_the_earth_are_refused() -> None:
    far = [[-175.8, -51.7], [-175.7, -51.7], [-175.7, -51.6]]
    assert refused("split", FARM, ["nordfeld-12"], line=far).code == "no_cut"
    assert refused("add_hole", FARM, ["nordfeld-12"], ring=far).code in ("outside", "crosses_itself")
    away = parse_feature(raw("away", "parcel", {"type": "Polygon", "coordinates": [far]}))
    both = draft(NORTH, away, line("lane", [(0, 0), (9, 9)]))
    assert refused("merge", both, ["nordfeld-12", "away"]).code == "apart"
    assert refused("clip", both, ["nordfeld-12"], others=["away"]).code == "nothing_to_do"


def test_parcels_that_meet_in_a_corner_only_are_no_one_parcel() -> None:
    diamond = area("diamond", [(20, 0), (0, 20), (-20, 0), (0, -20), (20, 0)])
    east = area("east", box(20, -40, 220, 90))
    refusal = refused("merge", draft(diamond, east), ["diamond", "east"])
    assert refusal.code == "apart"
    assert "meet in a corner only" in refusal.text
