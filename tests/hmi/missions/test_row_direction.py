"""Which way the rows of a plan run."""

from __future__ import annotations

import math
from typing import Any

import pytest

from hmi.commands.plan_wish import PlanOrder, wish_for
from hmi.commands.row_direction import lines_of
from hmi.domain.mission_plan import PlanRefused, Rows
from hmi.store.features import Feature
from tests.hmi.missions.rig import lon_lat, parcel_geometry

ORDER = PlanOrder("home-field", "weeder-01", 3.0)


def field(**properties: Any) -> Feature:
    return Feature("home-field", "polder", "parcel", "Home field", parcel_geometry(40.0), properties)


def recorded(*rows: tuple[tuple[float, float], ...]) -> Feature:
    lines = {"type": "MultiLineString", "coordinates": [lon_lat(*row) for row in rows]}
    return Feature("maize", "polder", "rows", "Maize", lines, {"parcel_id": "home-field", "type": "recorded"})


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


def test_what_is_chosen_takes_the_lines_of_that_kind_only() -> None:
    ab, guide = drawn((5, 5), (15, 25)), drawn((5, 5), (15, 15), (35, 20), name="curve")
    rows = recorded(((2, 2), (2, 30)), ((4, 2), (4, 30)))
    everything = [field(row_bearing_deg=90.0), ab, guide, rows]

    def wish(chosen: Rows) -> Any:
        return wish_for(PlanOrder("home-field", "weeder-01", 3.0, rows=chosen), "m-1", everything[0], everything, None)

    assert wish(Rows.AB_LINE).angle_rad == pytest.approx(math.atan2(20, 10), abs=0.01)
    assert [len(line.points) for line in wish(Rows.GUIDE_LINE).row_lines] == [3]
    assert [line.name for line in wish(Rows.RECORDED_ROWS).row_lines] == ["row 1 of Maize", "row 2 of Maize"]
    for chosen in (Rows.BEST_ANGLE, Rows.ALONG_EDGE):
        assert (wish(chosen).rows, wish(chosen).angle_rad, wish(chosen).row_lines) == (chosen, None, ())


def test_lines_without_a_type_are_known_by_their_shape() -> None:
    for places, kind in (((5, 5), (15, 25)), Rows.AB_LINE), (((5, 5), (9, 9), (15, 25)), Rows.GUIDE_LINE):
        line = {"type": "LineString", "coordinates": lon_lat(*places)}
        one = Feature("x", "polder", "rows", "", line, {"parcel_id": "home-field"})
        assert len(list(lines_of(field(), [one], kind))) == 1


def test_lines_a_field_does_not_have_and_two_directions_at_once_are_refused() -> None:
    def refused(**choices: Any) -> PlanRefused:
        with pytest.raises(PlanRefused) as refusal:
            wish_for(PlanOrder("home-field", "weeder-01", 3.0, **choices), "m-1", field(), [field()], None)
        return refusal.value

    missing = refused(rows=Rows.RECORDED_ROWS)
    assert (missing.code, missing.field) == ("no_lines", "rows")
    assert missing.text.startswith("The field has no recorded rows. Draw or record one under Maps")
    assert refused(rows=Rows.BEST_ANGLE, row_bearing_deg=10.0).code == "two_directions"
