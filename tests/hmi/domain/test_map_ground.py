"""How high things on the map stand, for what flies over them."""

from __future__ import annotations

import math
from typing import Any

import pytest

from hmi.domain.map_ground import CLOSED_KINDS, FLOWN_OVER_KINDS, object_height_m
from hmi.mapping.kinds import KINDS


def test_a_height_is_told_of_what_stands_up_and_of_nothing_else() -> None:
    told = {kind for kind in KINDS if object_height_m(kind, {"height_m": 12}) == 12.0}
    assert told == set(FLOWN_OVER_KINDS) == {kind for kind, one in KINDS.items() if "height_m" in one.attributes}
    assert told < set(CLOSED_KINDS)


@pytest.mark.parametrize("height", [None, 0, -3, 300.1, math.nan, math.inf, True, "12", [12], 10**400])
def test_what_is_no_height_is_not_known(height: Any) -> None:
    assert object_height_m("building", {"height_m": height}) is None


def test_what_nobody_said_is_not_known() -> None:
    assert object_height_m("tree", {}) is None
    assert object_height_m("tree", {"height_m": 300}) == 300.0
