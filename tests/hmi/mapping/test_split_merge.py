"""Splitting and merging, and what they refuse."""

from __future__ import annotations

import math
from typing import Any

import pytest

from hmi.mapping.checks import check
from hmi.mapping.feature import parse_feature
from tests.hmi.mapping.farms import XY, area, box, degrees, do, draft, line, metres, point, raw
from tests.hmi.mapping.small_farm import FARM, HOLED, LANE, NORTH, label, refused


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


@pytest.mark.parametrize("letters", [78, 79, 80])
def test_the_longest_name_still_makes_room_for_a_letter(letters: int) -> None:
    long = area("long", box(0, 0, 100, 60), name="n" * letters)
    after = do("split", draft(long), ["long"], line=degrees([(70, -5), (70, 65)]))
    assert (after["long"].name, after["long-b"].name) == ("n" * letters, "n" * 78 + " b")


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


@pytest.mark.parametrize(("heights", "after"), [((8, 20), 20), ((20, 8), 20), ((8, None), None), ((None, 20), None)])
def test_merged_buildings_are_as_high_as_the_highest_and_unknown_if_one_is(heights: Any, after: float | None) -> None:
    own = [{} if height is None else {"height_m": height} for height in heights]
    large = area("large", box(0, 0, 30, 10), kind="building", category="Barn", **own[0])
    small = area("small", box(30, 0, 40, 10), kind="building", category="Silo", **own[1])
    [whole] = do("merge", draft(large, small), ["large", "small"]).values()
    assert whole.properties == {"category": "Barn", **({} if after is None else {"height_m": after})}


def test_a_split_building_keeps_its_height_in_both_halves() -> None:
    barn = area("barn", box(0, 0, 30, 10), kind="building", height_m=8)
    halves = do("split", draft(barn), ["barn"], line=degrees([(20, -5), (20, 15)]))
    assert [one.properties for one in halves.values()] == [{"height_m": 8}] * 2


@pytest.mark.parametrize("turned_deg", [0, 11.3, 37, 64.5])
@pytest.mark.parametrize("apart_m", [-9.3, 0, 0.2])
def test_what_is_merged_or_cut_back_has_no_double_corners_and_no_spikes(turned_deg: float, apart_m: float) -> None:
    def turned(ring: list[XY]) -> list[XY]:
        c, s = math.cos(math.radians(turned_deg)), math.sin(math.radians(turned_deg))
        return [(x * c - y * s + 3000, x * s + y * c + 500) for x, y in ring]

    pair = draft(area("a", turned(box(0, 0, 100, 100))), area("b", turned(box(100 + apart_m, 0, 160, 60))))
    results = [do("merge", pair, ["a", "b"])]
    if apart_m < 0:
        results.append(do("clip", pair, ["a"], others=["b"]))
    for after in results:
        assert [one.text for one in check(after.values()) if one.code == "needless_corner"] == []
