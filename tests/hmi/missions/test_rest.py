"""Missions and map over REST."""

from __future__ import annotations

from typing import Any

import pytest

from hmi.domain.mission import MissionStatus, Mover
from hmi.domain.robot import OrderStatus
from hmi.domain.role import Role
from hmi.store.features import Feature
from tests.hmi.missions.rig import FARM, OTHER_FARM, Rig, lon_lat, order
from tests.hmi.missions.test_store import put

PLAN = {"field_id": "field-1", "robot_id": "weeder-01", "width_m": 3.0}


async def test_a_planner_plans_lists_reads_renames_copies_and_deletes(rig: Rig) -> None:
    async with rig.client(Role.PLANNER) as client:
        made = await client.post("/missions/plan", json=PLAN)
        assert made.status_code == 201
        mission = made.json()
        assert mission["status"] == "validated"
        assert mission["row_bearing_deg"] == 90.0
        assert mission["statistics"]["rows"] > 5
        path = f"/missions/{mission['id']}"
        renamed = await client.patch(path, json={"name": "Beets  north"})
        assert renamed.json()["name"] == "Beets north"
        copy = (await client.post(f"{path}/copy", json={})).json()
        listed = (await client.get("/missions")).json()["missions"]
        assert {one["id"] for one in listed} == {mission["id"], copy["id"]}
        assert (await client.delete(path)).status_code == 204
        assert (await client.get(path)).status_code == 404
        log = (await client.get(f"/missions/{copy['id']}")).json()["log"]
        assert [one["status"] for one in log] == ["validated"]


async def test_rows_follow_a_line_of_the_map_when_asked_and_the_fields_say_which_there_are(rig: Rig) -> None:
    curve = {"type": "LineString", "coordinates": lon_lat((-2, 14), (10, 20), (30, 20), (42, 14))}
    line = Feature("bend", FARM, "rows", "Bend", curve, {"parcel_id": "field-1", "type": "curve"})
    rig.features.put([line])
    async with rig.client(Role.PLANNER) as client:
        places = (await client.get("/fields")).json()["fields"]
        assert {one["id"]: one["lines"] for one in places}["field-1"] == {"guide_line": 1}
        made = (await client.post("/missions/plan", json={**PLAN, "rows": "guide_line"})).json()
        assert made["statistics"]["rows_along"] == "guide_line"
        whole = (await client.get(f"/missions/{made['id']}")).json()
        assert whole["row_bearing_deg"] == pytest.approx(90, abs=5)
        refused = await client.post("/missions/plan", json={**PLAN, "rows": "recorded_rows"})
        assert (refused.status_code, refused.json()["code"], refused.json()["field"]) == (422, "no_lines", "rows")


async def test_a_preview_brings_numbers_and_geometry_and_stores_nothing(rig: Rig) -> None:
    async with rig.client(Role.PLANNER) as client:
        answer = (await client.post("/missions/preview", json=PLAN)).json()
        assert answer["geometry"]["features"][0]["properties"]["kind"] == "parcel"
        assert answer["statistics"]["duration_s"] > 60
        assert (await client.get("/missions")).json() == {"missions": []}


@pytest.mark.parametrize(
    ("change", "status", "code", "field"),
    [
        ({"width_m": 0.0}, 422, "width_not_positive", "width_m"),
        ({"width_m": 900.0}, 422, "width_absurd", "width_m"),
        ({"width_m": "3"}, 422, "invalid", "width_m"),
        ({"field_id": "bow-tie"}, 422, "bad_field", "field_id"),
        ({"field_id": "nowhere"}, 404, "not_found", None),
        ({"robot_id": "weeder-77"}, 403, "not_registered", None),
        ({"headland_passes": 9}, 422, "field_too_small", "headland_passes"),
        ({"colour": "red"}, 422, "invalid", "colour"),
    ],
)
async def test_what_cannot_be_planned_says_why_and_where(
    rig: Rig, change: dict[str, Any], status: int, code: str, field: str | None
) -> None:
    async with rig.client(Role.PLANNER) as client:
        answer = await client.post("/missions/plan", json={**PLAN, **change})
    body = answer.json()
    assert (answer.status_code, body["code"], body["field"]) == (status, code, field)
    assert body["text"].endswith(".")


async def test_not_a_number_is_refused(rig: Rig) -> None:
    async with rig.client(Role.PLANNER) as client:
        body = '{"field_id":"field-1","robot_id":"weeder-01","width_m":NaN}'
        answer = await client.post("/missions/plan", content=body, headers={"Content-Type": "application/json"})
    assert answer.status_code == 422


@pytest.mark.parametrize(("role", "status"), [(None, 401), (Role.VIEWER, 403), (Role.OPERATOR, 403)])
async def test_planning_needs_the_right(rig: Rig, role: Role | None, status: int) -> None:
    put(rig)
    async with rig.client(role) as client:
        assert (await client.post("/missions/plan", json=PLAN)).status_code == status
        assert (await client.patch("/missions/m-1", json={"name": "x"})).status_code == status
        assert (await client.delete("/missions/m-1")).status_code == status
        assert (await client.get("/missions")).status_code == (401 if role is None else 200)


async def test_the_map_of_a_mission_is_kept_by_the_browser_until_it_changes(rig: Rig) -> None:
    put(rig)
    async with rig.client(Role.VIEWER) as client:
        first = await client.get("/missions/m-1/map.geojson")
        assert first.headers["content-type"] == "application/geo+json"
        again = await client.get("/missions/m-1/map.geojson", headers={"If-None-Match": first.headers["etag"]})
        assert (first.status_code, again.status_code, again.content) == (200, 304, b"")


async def test_the_geometry_of_what_a_robot_drives(rig: Rig) -> None:
    mission = put(rig)
    rig.fleet.report("weeder-01", order("m-1", mission.sha256, OrderStatus.RUNNING), 1.0)
    async with rig.client(Role.VIEWER) as client:
        answer = await client.get("/robots/weeder-01/mission.geojson")
    assert answer.status_code == 200
    assert answer.headers["etag"] == f'"{mission.sha256}"'
    assert {one["properties"]["kind"] for one in answer.json()["features"]} >= {"parcel", "row", "turn", "headland"}


@pytest.mark.parametrize("robot", ["weeder-01", "weeder-77"])
async def test_a_robot_without_a_mission_has_no_geometry(rig: Rig, robot: str) -> None:
    async with rig.client(Role.VIEWER) as client:
        assert (await client.get(f"/robots/{robot}/mission.geojson")).status_code == 404


async def test_another_version_than_the_stored_one_is_not_drawn(rig: Rig) -> None:
    put(rig)
    rig.fleet.report("weeder-01", order("m-1", "d" * 64, OrderStatus.RUNNING), 1.0)
    async with rig.client(Role.VIEWER) as client:
        answer = await client.get("/robots/weeder-01/mission.geojson")
    assert answer.status_code == 404
    assert "another version" in answer.json()["text"]


async def test_the_farm_map_and_its_fields(rig: Rig) -> None:
    async with rig.client(Role.VIEWER) as client:
        collection = (await client.get("/features")).json()
        fields = (await client.get("/fields")).json()
    assert {one["properties"]["kind"] for one in collection["features"]} == {"parcel", "road", "home", "obstacle"}
    assert [one["id"] for one in fields["fields"]] == ["bow-tie", "field-1"]
    assert [one["id"] for one in fields["homes"]] == ["home-1"]


async def test_another_farm_sees_none_of_it(rig: Rig) -> None:
    put(rig)
    async with rig.client(Role.ADMIN, OTHER_FARM) as client:
        assert (await client.get("/missions")).json() == {"missions": []}
        assert (await client.get("/features")).json()["features"] == []
        for path in ("/missions/m-1", "/missions/m-1/map.geojson", "/missions/m-1/document"):
            assert (await client.get(path)).status_code == 404
        assert (await client.delete("/missions/m-1")).status_code == 404


async def test_a_mission_is_marked_unattended_and_given_to_another_robot_but_not_while_a_robot_holds_it(
    rig: Rig,
) -> None:
    put(rig, "m-1")
    async with rig.client(Role.PLANNER) as client:
        changed = await client.patch("/missions/m-1", json={"is_supervised": False, "robot_id": "weeder-02"})
        nothing = await client.patch("/missions/m-1", json={})
        rig.missions.move(FARM, "m-1", MissionStatus.SENT, Mover.PERSON, "Pieter")
        held = await client.patch("/missions/m-1", json={"is_supervised": True})
    assert (changed.json()["is_supervised"], changed.json()["robot_id"]) == (False, "weeder-02")
    assert rig.missions.document(FARM, "m-1")["robot"] == "weeder-02"
    assert (nothing.status_code, nothing.json()["field"]) == (422, "name")
    assert (held.status_code, held.json()["code"]) == (409, "in_use")
    async with rig.client(Role.OPERATOR) as client:
        assert (await client.patch("/missions/m-1", json={"is_supervised": False})).status_code == 403
