"""Rows further apart than the tool is wide leave ground between them, and the plan says so."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
import shapely

from hmi.domain.mission_plan import PlanWish, RowLine, Rows
from hmi.domain.mission_rest import Progress, RestWish
from hmi.domain.robot import Factsheet, Family
from hmi.planning.coverage import plan_coverage
from hmi.planning.given_path import checked_candidate, segments_of
from hmi.planning.mission import job_of, plan_candidate, plan_mission
from hmi.planning.mission_map import mission_geojson
from hmi.planning.rest import plan_rest
from tests.hmi.missions.rig import FRAME, lon_lat, parcel_geometry
from tests.hmi.presenters.robots import SHEET

SIDE_M = 60.0


def wish(width_m: float, robot: Factsheet | None = SHEET, **more: Any) -> PlanWish:
    """Return the wish for a square field; the tool of ``SHEET`` takes 1.5 m."""
    return PlanWish(
        mission_id="m-1",
        name="Home field",
        robot_id="weeder-01",
        field_name="Home field",
        parcel=parcel_geometry(SIDE_M),
        width_m=width_m,
        datum_lat_deg=FRAME.lat_deg,
        datum_lon_deg=FRAME.lon_deg,
        robot=robot,
        **more,
    )


def test_what_lies_between_rows_wider_than_the_tool_is_not_called_covered() -> None:
    found = plan_mission(wish(6.0))
    figures = found.statistics
    assert figures["covered_m2"] == pytest.approx(0.25 * SIDE_M**2, rel=0.05)
    assert figures["missed_m2"] == pytest.approx(figures["wanted_m2"] - figures["covered_m2"])
    assert found.document["area_m2"] == pytest.approx(figures["covered_m2"], abs=0.1)
    [note] = [one for one in figures["notes"] if "untreated" in one]
    share = figures["missed_m2"] / figures["wanted_m2"]
    assert note == f"The tool takes 1.5 m; rows are 6 m apart: {share:.0%} of the field stays untreated."
    parcel = mission_geojson(found.document, figures)["features"][0]["properties"]
    assert parcel["width_m"] == 1.5, "the map draws what was worked that wide"


def test_the_picture_shows_the_ground_between_as_missed() -> None:
    drawn = plan_candidate(wish(6.0)).drawing
    missed = sum(shapely.Polygon(rings[0], rings[1:]).area for rings in drawn["ground"]["missed"])
    assert missed > 0.7 * SIDE_M**2
    assert drawn["machine"]["tool_width_m"] == 1.5


@pytest.mark.parametrize(
    ("width_m", "robot"),
    [
        (1.5, SHEET),
        (6.0, None),
        (6.0, replace(SHEET, tool_width_m=0.0)),
        (6.0, replace(SHEET, tool_width_m=20.0)),
        (6.0, replace(SHEET, family=Family.PLANTER, tool_kind="planter", tool_width_m=4.0)),
    ],
    ids=["as wide", "no factsheet", "no tool", "wider", "planter"],
)
def test_no_word_of_it_where_the_tool_takes_the_rows_or_is_not_known(width_m: float, robot: Factsheet | None) -> None:
    figures = plan_mission(wish(width_m, robot)).statistics
    assert figures["covered_m2"] > 0.9 * SIDE_M**2
    assert not any("tool takes" in note for note in figures["notes"])


def test_recorded_rows_are_still_driven_as_many_at_a_time_as_was_asked() -> None:
    lines = tuple(RowLine(f"row {x}", tuple(lon_lat((x, -2.0), (x, SIDE_M + 2.0)))) for x in range(2, 60, 2))  # type: ignore[arg-type]
    asked = {"rows": Rows.RECORDED_ROWS, "row_lines": lines, "row_spacing_m": 2.0}
    assert (
        plan_mission(wish(6.0, **asked)).statistics["rows"] == plan_mission(wish(6.0, None, **asked)).statistics["rows"]
    )


def test_a_path_from_elsewhere_is_counted_alike() -> None:
    asked = wish(7.0)
    plan = plan_coverage(job_of(asked))
    figures = checked_candidate(asked, segments_of(plan.legs), ()).statistics
    assert figures["covered_m2"] == pytest.approx(plan.figures.covered_m2, rel=0.01)
    assert any("The tool takes 1.5 m" in note for note in figures["notes"])


def test_a_rest_counts_the_ground_the_tool_takes() -> None:
    base = plan_mission(wish(6.0))
    made = plan_rest(RestWish(base.document, base.sha256, 2, Progress(base.sha256, 0, 0.0), robot=SHEET))
    assert made.difference["before"]["area_m2"] == pytest.approx(1.5 * base.statistics["working_length_m"], rel=0.01)
