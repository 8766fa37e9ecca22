"""How far apart a planter plants: what a person enters reaches the robot, and the rest keeps it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import msgspec
import pytest

from backend_clients.edge import messages_down as down
from backend_clients.edge.codec import mission_hash
from hmi.domain.mission_document import mission_sha256
from hmi.domain.mission_plan import PlannedMission, PlanWish
from hmi.domain.mission_rest import PlannedRest, Progress, RestWish
from hmi.domain.robot import Factsheet, Family
from hmi.planning.mission import plan_mission
from hmi.planning.rest import plan_rest
from tests.hmi.missions.rig import FRAME, parcel_geometry
from tests.hmi.presenters.robots import SHEET

PLANTER = replace(SHEET, family=Family.PLANTER, tool_kind="planter", tool_width_m=4.0)


def planned(spacing_m: float | None, robot: Factsheet | None = PLANTER) -> PlannedMission:
    return plan_mission(
        PlanWish(
            mission_id="m-1",
            name="Home field",
            robot_id="planter-01",
            field_name="Home field",
            parcel=parcel_geometry(40.0),
            width_m=4.0,
            datum_lat_deg=FRAME.lat_deg,
            datum_lon_deg=FRAME.lon_deg,
            robot=robot,
            plant_spacing_m=spacing_m,
        )
    )


def rest(base: PlannedMission, **more: Any) -> PlannedRest:
    wish = RestWish(base.document, base.sha256, 2, Progress(base.sha256, 0, 5.0), robot=PLANTER)
    return plan_rest(replace(wish, **more))


def test_the_robot_is_told_what_was_entered() -> None:
    found = planned(2.0)
    wire = msgspec.convert(found.document, down.Mission)
    assert wire.plant_spacing_m == 2.0
    assert mission_hash(wire) == found.sha256 == mission_sha256(found.document)


@pytest.mark.parametrize(("spacing_m", "robot"), [(None, PLANTER), (2.0, SHEET), (2.0, None)])
def test_where_nobody_entered_one_or_nothing_is_planted_it_is_left_out(
    spacing_m: float | None, robot: Factsheet | None
) -> None:
    found = planned(spacing_m, robot)
    assert "plant_spacing_m" not in found.document
    assert mission_hash(msgspec.convert(found.document, down.Mission)) == found.sha256


@pytest.mark.parametrize("spacing_m", [None, 4.0])
def test_a_rest_takes_as_long_as_was_planned_and_goes_on_with_the_same(spacing_m: float | None) -> None:
    base = planned(spacing_m)
    made = rest(base)
    before = made.difference["before"]["duration_s"]
    assert before == pytest.approx(base.statistics["duration_s"], rel=0.05)
    assert made.document.get("plant_spacing_m") == spacing_m
    assert made.statistics["plant_spacing_m"] == base.statistics["plant_spacing_m"]


def test_a_shorter_rest_takes_fewer_seedlings() -> None:
    base = planned(4.0)
    row = next(k for k, one in enumerate(base.document["segments"]) if one["row"] == 3)
    made = rest(base, leave_out=(row,))
    assert made.statistics["seedlings"] < base.statistics["seedlings"]
    assert made.statistics["seedlings"] == round(made.statistics["working_length_m"] / 4.0)
