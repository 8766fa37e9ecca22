"""Which way the rows of a plan run."""

from __future__ import annotations

import math
from typing import Any

import pytest

from hmi.commands.plan_wish import PlanOrder, wish_for
from hmi.store.features import Feature
from tests.hmi.missions.rig import lon_lat, parcel_geometry

ORDER = PlanOrder("home-field", "weeder-01", 3.0)


def field(**properties: Any) -> Feature:
    return Feature("home-field", "polder", "parcel", "Home field", parcel_geometry(40.0), properties)


def drawn(*places: tuple[float, float], parcel: str = "home-field", name: str = "a-b") -> Feature:
    line = {"type": "LineString", "coordinates": lon_lat(*places)}
    return Feature(name, "polder", "rows", "", line, {"parcel_id": parcel, "type": name})


def angle(order: PlanOrder, parcel: Feature, *others: Feature) -> float | None:
    return wish_for(order, "m-1", parcel, [parcel, *others], None).angle_rad


def test_a_line_drawn_in_the_field_gives_its_direction() -> None:
    assert angle(ORDER, field(), drawn((5, 5), (15, 25))) == pytest.approx(math.atan2(20, 10), abs=0.01)


def test_recorded_rows_driven_to_and_fro_count_as_one_direction_and_long_ones_more() -> None:
    rows = (drawn((5, 5), (5, 35)), drawn((8, 35), (8, 5), name="row"), drawn((10, 5), (11, 6), name="bit"))
    found = angle(ORDER, field(), *rows)
    assert found is not None
    assert abs(math.remainder(found - math.pi / 2, math.pi)) < 0.03


def test_what_is_asked_for_or_set_on_the_field_wins_and_lines_of_others_do_not_count() -> None:
    line = drawn((5, 5), (15, 25))
    assert angle(ORDER, field(row_bearing_deg=90.0), line) == pytest.approx(0.0)
    assert angle(PlanOrder("home-field", "weeder-01", 3.0, row_bearing_deg=0.0), field(), line) == pytest.approx(
        math.pi / 2
    )
    assert angle(ORDER, field(), drawn((5, 5), (15, 25), parcel="other")) is None
