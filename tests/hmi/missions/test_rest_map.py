"""The rest of a mission keeps to the field as the map shows it now."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import shapely

from hmi.commands.mission_rest import RestOrder
from hmi.commands.plan_wish import PlanOrder
from hmi.domain.map_log import FeatureChange, Transaction
from hmi.domain.mission_document import Document
from hmi.domain.mission_plan import MissionRefused, PlanRefused
from hmi.domain.robot import Mode, OrderStatus
from hmi.domain.role import Role
from hmi.planning.mission_map import mission_geojson
from hmi.planning.projection import LocalFrame
from hmi.store.maps import Maps
from tests.hmi.missions.rig import FARM, FRAME, Rig, lon_lat
from tests.hmi.missions.test_map_watch import publish
from tests.hmi.missions.test_rest_book import Desk

HOLE = shapely.box(22, 24, 30, 34)
NEW = shapely.box(0, 0, 40, 36).difference(HOLE)


def published(rig: Rig, feature_id: str, change: Callable[[dict[str, Any]], dict[str, Any] | None]) -> None:
    """Change a feature of the map and publish it."""
    maps = Maps(rig.database, rig.clock)
    maps.open(FARM, "anna", "Anna")
    before = maps.features_of(FARM, maps.published(FARM).number)[feature_id]
    done = FeatureChange(feature_id, before, change(before))
    maps.append(FARM, "anna", Transaction(f"ref-{feature_id}", "Changed", "Anna", rig.clock.utc(), (done,)))
    maps.publish(FARM, "anna", "Anna", "")


def smaller(raw: dict[str, Any]) -> dict[str, Any]:
    rings = [lon_lat(*ring.coords) for ring in (NEW.exterior, *NEW.interiors)]
    return {**raw, "geometry": {"type": "Polygon", "coordinates": rings}}


def narrower(raw: dict[str, Any]) -> dict[str, Any]:
    return {
        **raw,
        "geometry": {"type": "Polygon", "coordinates": [lon_lat((0, 0), (30, 0), (30, 40), (0, 40), (0, 0))]},
    }


def split(raw: dict[str, Any]) -> dict[str, Any]:
    parts = [shapely.box(0, 0, 40, 36), shapely.box(0, 38, 40, 40)]
    return {
        **raw,
        "geometry": {"type": "MultiPolygon", "coordinates": [[lon_lat(*one.exterior.coords)] for one in parts]},
    }


@pytest.fixture
async def desk(rig: Rig) -> Desk:
    """Return a desk whose mission was planned on the rig's map."""
    mission = await rig.book.plan(rig.person(Role.PLANNER), PlanOrder("field-1", "weeder-01", 3.0))
    return Desk(rig, mission.id)


def off_the_field_m(document: Document) -> float:
    """Return how far the robot's base comes off the field after the path that stays, without the ways."""
    frame = LocalFrame(document["datum"]["lat_deg"], document["datum"]["lon_deg"])
    outside = shapely.box(-500, -500, 500, 500).difference(NEW)
    new = document["segments"][document["continues"]["segments"] :]
    lines = (FRAME.to_local(frame.to_lon_lat(np.asarray(one["points"]))) for one in new if one["kind"] != "exit")
    return sum(shapely.LineString(line).intersection(outside).length for line in lines)


async def test_what_is_resumed_later_stays_on_the_field_as_it_is_now(desk: Desk) -> None:
    desk.reports(OrderStatus.ABORTED, Mode.IDLE)
    published(desk.rig, "field-1", smaller)
    planned = await desk.rests.preview(desk.supervisor, desk.id, RestOrder("later"))
    assert planned.document["map_version"]["number"] == 2
    assert off_the_field_m(planned.document) == 0
    assert any("laid anew along the edge of the field" in note for note in planned.difference["notes"])


async def test_it_carries_the_field_of_the_map_it_was_planned_on_and_so_does_its_picture(desk: Desk) -> None:
    desk.reports(OrderStatus.ABORTED, Mode.IDLE)
    before = await desk.rests.preview(desk.supervisor, desk.id, RestOrder("later"))
    assert before.document["parcel"] == desk.rig.missions.document(FARM, desk.id)["parcel"]
    published(desk.rig, "field-1", smaller)
    planned = await desk.rests.preview(desk.supervisor, desk.id, RestOrder("later"))
    shown = mission_geojson(planned.document)["features"][0]["geometry"]
    rings = [FRAME.to_local([(p[0], p[1]) for p in ring]) for ring in shown["coordinates"]]
    assert (
        shapely.Polygon(rings[0], rings[1:]).symmetric_difference(NEW).area < 1
    )  # the map of these tests is flat to half a centimetre


async def test_a_field_in_several_parts_has_no_one_outline_and_keeps_the_planned_one(desk: Desk) -> None:
    desk.reports(OrderStatus.ABORTED, Mode.IDLE)
    planned = desk.rig.missions.document(FARM, desk.id)["parcel"]
    published(desk.rig, "field-1", split)
    rest = await desk.rests.preview(desk.supervisor, desk.id, RestOrder("later"))
    assert rest.document["parcel"] == planned


async def test_a_change_of_the_rest_stays_on_it_too(desk: Desk) -> None:
    published(desk.rig, "field-1", smaller)
    assert off_the_field_m((await desk.change()).document) == 0


async def test_the_rest_of_a_rest_stays_on_it_as_well(desk: Desk) -> None:
    published(desk.rig, "field-1", smaller)
    planned = await desk.change()
    sent = await desk.rests.send(desk.supervisor, desk.id, planned.sha256, "tick")
    assert sent.outcome.value == "accepted"
    for status, mode in ((OrderStatus.RUNNING, Mode.AUTO), (OrderStatus.PAUSED, Mode.IDLE)):
        desk.reports(status, mode)
        again = await desk.change(leave_out=(desk.row(5),))
        assert 5 not in {one["row"] for one in again.document["segments"]}
        assert off_the_field_m(again.document) == 0


async def test_a_robot_that_would_leave_the_field_before_the_new_path_is_paused_first(desk: Desk) -> None:
    published(desk.rig, "field-1", narrower)
    with pytest.raises(PlanRefused, match="new edge of the field") as caught:
        await desk.change()
    assert caught.value.code == "obstacle_ahead"


async def test_a_robot_that_would_meet_what_was_just_published_is_paused_first(desk: Desk) -> None:
    document = desk.rig.missions.document(FARM, desk.id)
    frame = LocalFrame(document["datum"]["lat_deg"], document["datum"]["lon_deg"])
    row = np.asarray(document["segments"][desk.row_2]["points"])
    along = shapely.LineString(FRAME.to_local(frame.to_lon_lat(row)))
    assert (await desk.change()).document["continues"]["segments"] > desk.row_2  # row 2 stays
    ahead = along.interpolate(15.0)
    publish(desk.rig, "ditch", ahead.x, ahead.y)
    with pytest.raises(PlanRefused, match="ahead: Ditch is on the path before the new one begins") as caught:
        await desk.change()
    assert caught.value.code == "obstacle_ahead"
    desk.reports(OrderStatus.PAUSED, Mode.PAUSED)
    assert (await desk.change()).difference["notes"]


async def test_what_is_published_elsewhere_keeps_no_running_robot_from_its_new_rest(desk: Desk) -> None:
    publish(desk.rig, "ditch", -20.0, 30.0)
    assert (await desk.change()).document["map_version"]["number"] == 2


async def test_the_rest_of_a_field_that_is_no_more_is_refused(desk: Desk) -> None:
    desk.reports(OrderStatus.ABORTED, Mode.IDLE)
    published(desk.rig, "field-1", lambda _raw: None)
    with pytest.raises(MissionRefused, match="Home field is no field on the map any more") as caught:
        await desk.rests.preview(desk.supervisor, desk.id, RestOrder("later"))
    assert caught.value.code == "field_gone"


async def test_a_map_that_changes_after_the_rest_was_shown_keeps_it_from_being_sent(desk: Desk) -> None:
    desk.reports(OrderStatus.ABORTED, Mode.IDLE)
    planned = await desk.rests.preview(desk.supervisor, desk.id, RestOrder("later"))
    published(desk.rig, "field-1", smaller)
    sent = await desk.rests.send(desk.supervisor, desk.id, planned.sha256, "tick")
    assert (sent.outcome.value, sent.code) == ("rejected", "map_changed")
    assert desk.wire.sent == []


async def test_a_field_that_did_not_change_gives_the_same_rest(desk: Desk) -> None:
    desk.reports(OrderStatus.ABORTED, Mode.IDLE)
    before = await desk.rests.preview(desk.supervisor, desk.id, RestOrder("later"))
    published(desk.rig, "field-1", lambda raw: {**raw, "properties": {**raw["properties"], "crop": "Maize"}})
    after = await desk.rests.preview(desk.supervisor, desk.id, RestOrder("later"))
    assert after.document["segments"] == before.document["segments"]
