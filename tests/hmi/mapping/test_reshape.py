"""Growing, straightening, simplifying and moving shapes."""

from __future__ import annotations

import math

import pytest
import shapely

from hmi.mapping.feature import parse_feature
from tests.hmi.mapping.farms import area, box, do, draft, metres, point, raw
from tests.hmi.mapping.small_farm import FARM, LANE, NORTH, label, refused


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


def test_all_nearly_straight_edges_become_straight_and_true_corners_stay_exactly() -> None:
    wobbly = area(
        "wobbly", [(0, 0), (30, 0.4), (60, -0.3), (100, 0), (100, 30), (100.3, 45), (100, 60), (0, 60), (0, 0)]
    )
    after = do("straighten_all", draft(wobbly), ["wobbly"])["wobbly"]
    corners = wobbly.geometry["coordinates"][0]
    assert sorted(after.geometry["coordinates"][0][:-1]) == sorted([corners[0], corners[3], corners[6], corners[7]])
    assert label("straighten_all", draft(wobbly), ["wobbly"]) == "Edges of Wobbly straightened, 4 corners fewer"


def test_a_soft_bend_is_a_bend_however_softly_it_turns() -> None:
    arc = [(100 * math.cos(k * math.pi / 180), 100 * math.sin(k * math.pi / 180)) for k in range(0, 181, 2)]
    half = area("half", [*arc, arc[0]])
    after = do("straighten_all", draft(half), ["half"], within_deg=4)["half"]
    assert metres(after).boundary.hausdorff_distance(metres(half).boundary) < 2
    assert len(after.geometry["coordinates"][0]) > 15


def test_a_field_of_true_corners_has_nothing_to_straighten() -> None:
    assert refused("straighten_all", FARM, ["east"]).code == "nothing_to_do"
    assert refused("straighten_all", FARM, ["east"], within_deg=90).code == "bad_argument"
