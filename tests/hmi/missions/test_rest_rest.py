"""Going on with a mission and the checklist over REST: who may, what is asked, what is answered."""

from __future__ import annotations

from collections.abc import Callable
from datetime import timedelta
from typing import Any

import httpx
import pytest
from fastapi import FastAPI

from hmi.api import errors
from hmi.api.access import Access
from hmi.api.mission_rest import rest_routes
from hmi.commands.checklist_desk import ChecklistDesk
from hmi.domain.checklist import CHECKLISTS
from hmi.domain.robot import Family, Mode, OrderStatus
from hmi.domain.role import Role
from hmi.store.checklists import Checklists
from tests.hmi.missions.rig import OTHER_FARM, Door, NoTokens, Rig, lon_lat
from tests.hmi.missions.test_rest_book import Desk

Visitor = Callable[..., httpx.AsyncClient]
ALL = [one.id for one in CHECKLISTS[Family.OTHER]]


@pytest.fixture
def desk(rig: Rig) -> Desk:
    return Desk(rig)


@pytest.fixture
def lists(rig: Rig) -> Checklists:
    return Checklists(rig.database, rig.clock)


@pytest.fixture
def come_as(rig: Rig, desk: Desk, lists: Checklists) -> Visitor:
    checklists = ChecklistDesk(
        lists,
        rig.missions,
        rig.database,
        rig.fleet,
        rig.audit,
        rig.authorize,
        rig.clock,
        is_required=True,
        valid_hours=12,
    )

    def come(role: Role | None, farm_id: str = "farm") -> httpx.AsyncClient:
        app = FastAPI()
        app.state.access = Access(Door(None if role is None else rig.person(role, farm_id)), NoTokens(), rig.authorize)
        app.include_router(rest_routes(desk.rests, checklists))
        errors.install(app)
        return httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://console.local")

    return come


async def test_the_rest_is_read_previewed_and_sent(come_as: Visitor, desk: Desk) -> None:
    async with come_as(Role.SUPERVISOR) as client:
        left = (await client.get("/missions/m-1/rest")).json()
        assert (left["is_live"], left["pieces"][0]["row"], left["pieces"][0]["is_present"]) == (True, 2, True)
        assert left["forgets"] == "row 2 of 4, 0.01 ha done"
        wish = {"kind": "change", "leave_out": [left["pieces"][2]["number"]]}
        shown = (await client.post("/missions/m-1/rest/preview", json=wish)).json()
        assert shown["progress"] == left["progress"]
        assert shown["left_out"] == ["Row 4"]
        assert shown["after"]["area_m2"] < shown["before"]["area_m2"]
        assert shown["geometry"]["features"]
        sent = (await client.post("/missions/m-1/rest", json={"sha256": shown["sha256"], "tick": "t"})).json()
        assert (sent["outcome"], sent["sha256"]) == ("accepted", shown["sha256"])


OBSTACLE = {"kind": "obstacle", "outline": lon_lat((21, 30), (22, 30), (22, 31), (21, 31)), "clearance_m": 0.5}


async def test_ground_drawn_on_the_rest_stays_with_the_mission_until_it_starts_fresh(
    come_as: Visitor, desk: Desk, rig: Rig
) -> None:
    desk.reports(OrderStatus.PAUSED, Mode.PAUSED)
    async with come_as(Role.SUPERVISOR) as client:
        shown = (await client.post("/missions/m-1/rest/preview", json={"kind": "change", "areas": [OBSTACLE]})).json()
        assert any("something stands there" in note for note in shown["notes"])
        sent = (await client.post("/missions/m-1/rest", json={"sha256": shown["sha256"], "tick": "t"})).json()
        assert sent["outcome"] == "accepted"
        left = (await client.get("/missions/m-1/rest")).json()
        assert left["areas"] == [OBSTACLE]
        assert left["forgets"].endswith("1 obstacle")
        desk.reports(OrderStatus.ABORTED, Mode.IDLE)
        later = (await client.post("/missions/m-1/rest/preview", json={"kind": "later"})).json()
        assert later["sha256"]
        assert any("drawn: 1 obstacle" in why for _, why in desk.log())
        fresh = (await client.post("/missions/m-1/fresh", json={"tick": "t"})).json()
        assert fresh["outcome"] == "accepted"
        assert fresh["text"].endswith("It knows nothing of what was drawn: 1 obstacle.")
        assert (await client.get("/missions/m-1/rest")).json()["areas"] == []
    assert "Forgotten: 1 obstacle." in desk.log()[-1][1]


@pytest.mark.parametrize(
    "bad",
    [
        {"outline": [[4.26, 51.78], [4.27, 51.78]]},
        {"outline": [[4.26, 51.78], [4.27, 51.78], [4.27]]},
        {"outline": [[4.26, 51.78], [4.27, 51.78], [4.27, 91.0]]},
        {"clearance_m": -1},
        {"kind": "wall"},
    ],
)
async def test_ground_that_is_none_is_refused(come_as: Visitor, bad: dict[str, Any]) -> None:
    async with come_as(Role.SUPERVISOR) as client:
        wish = {"kind": "change", "areas": [{**OBSTACLE, **bad}]}
        assert (await client.post("/missions/m-1/rest/preview", json=wish)).status_code == 422


@pytest.mark.parametrize(
    "bad",
    [{}, {"kind": "other"}, {"kind": "change", "row_speed_mps": -1}, {"kind": "later", "more": 1}],
)
async def test_a_wish_that_is_none_is_refused(come_as: Visitor, bad: dict[str, Any]) -> None:
    async with come_as(Role.SUPERVISOR) as client:
        assert (await client.post("/missions/m-1/rest/preview", json=bad)).status_code == 422


async def test_who_may_not_gets_nothing_done(come_as: Visitor) -> None:
    fresh, wish = {"tick": "t"}, {"kind": "later"}
    async with come_as(Role.VIEWER) as client:
        assert (await client.get("/missions/m-1/rest")).status_code == 200
        assert (await client.post("/missions/m-1/rest/preview", json=wish)).status_code == 403
        assert (await client.post("/missions/m-1/fresh", json=fresh)).status_code == 403
        assert (await client.post("/robots/weeder-01/checklist", json={"ticked": ALL})).status_code == 403
    async with come_as(Role.PLANNER) as client:
        assert (await client.post("/robots/weeder-01/checklist", json={"ticked": ALL})).status_code == 403
    async with come_as(Role.SUPERVISOR, OTHER_FARM) as client:
        assert (await client.get("/missions/m-1/rest")).status_code == 404
        assert (await client.post("/missions/m-1/fresh", json=fresh)).status_code == 404
    async with come_as(None) as client:
        assert (await client.post("/missions/m-1/fresh", json=fresh)).status_code == 401


async def test_what_is_not_possible_now_says_why(come_as: Visitor) -> None:
    async with come_as(Role.SUPERVISOR) as client:
        answer = await client.post("/missions/m-1/rest/preview", json={"kind": "later"})
        assert (answer.status_code, answer.json()["code"]) == (409, "not_interrupted")
        answer = await client.post("/missions/m-1/fresh", json={"tick": "t"})
        assert (answer.status_code, answer.json()["code"]) == (409, "under_way")


async def test_a_ticked_list_is_recorded_with_who_and_when_and_runs_out(
    come_as: Visitor, desk: Desk, lists: Checklists, rig: Rig
) -> None:
    desk.reports(OrderStatus.LOADED, Mode.IDLE)
    async with come_as(Role.OPERATOR) as client:
        shown = (await client.get("/robots/weeder-01/checklist")).json()
        assert [one["id"] for one in shown["items"]] == ALL
        assert (shown["is_required"], shown["record"]) == (True, None)
        record = (await client.post("/robots/weeder-01/checklist", json={"ticked": ALL})).json()["record"]
        assert record["by"] == "Operator Person"
        assert (await client.get("/robots/weeder-01/checklist")).json()["record"] == record
    person = rig.person(Role.OPERATOR)
    assert lists.is_valid("farm", "weeder-01", person.user_id, record["id"])
    assert not lists.is_valid("farm", "weeder-02", person.user_id, record["id"])
    assert not lists.is_valid("farm", "weeder-01", "somebody-else", record["id"])
    assert rig.audit.entries[-1].kind == "checklist"
    assert any("Checked before the start" in why for _, why in desk.log())
    again = Checklists(rig.database, rig.clock)
    again.load()
    assert again.is_valid("farm", "weeder-01", person.user_id, record["id"])
    rig.clock.advance(timedelta(hours=12).total_seconds() + 1)
    assert not again.is_valid("farm", "weeder-01", person.user_id, record["id"])


async def test_a_list_with_a_line_missing_is_not_recorded(come_as: Visitor) -> None:
    async with come_as(Role.OPERATOR) as client:
        answer = await client.post("/robots/weeder-01/checklist", json={"ticked": ALL[1:]})
        assert (answer.status_code, answer.json()["code"]) == (409, "not_ticked")
        assert (await client.get("/robots/weeder-01/checklist")).json()["record"] is None
