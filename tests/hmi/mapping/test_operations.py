"""What holds for every operation: arguments, the table, nothing touched that need not be."""

from __future__ import annotations

import math
from typing import Any

import pytest

from hmi.mapping.feature import parse_feature
from hmi.mapping.operations import OPERATIONS
from tests.hmi.mapping.farms import HERE, area, box, degrees, do, draft, line, raw
from tests.hmi.mapping.small_farm import FARM, NORTH, refused


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
        "orient", "clean", "untangle", "snap_end", "swap_axes", "straighten_all", "close_gap", "cut_antimeridian",
        "remove",
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
