"""A mission that cannot be planned yet is kept as a draft, seen by everybody, and becomes a mission or goes."""

from __future__ import annotations

import asyncio
from typing import Any

import httpx
import pytest

from hmi.commands.plan_wish import PlanOrder
from hmi.commands.refusal import OrderRefused
from hmi.domain.mission import MissionStatus
from hmi.domain.mission_plan import MissionRefused
from hmi.domain.role import Role
from hmi.store.missions import Missions
from tests.hmi.missions.rig import FARM, OTHER_FARM, Rig

PLAIN = {"name": "Beans, second pass", "wish": {}}
CHOSEN = {"width_m": 3.0, "field_id": "field-1", "robot_id": "weeder-01", "pattern": "spiral", "is_supervised": False}


async def kept(rig: Rig, body: dict[str, Any] | None = None) -> dict[str, Any]:
    async with rig.client(Role.PLANNER) as client:
        answer = await client.post("/missions/drafts", json=body or PLAIN)
    assert answer.status_code == 201, answer.text
    found: dict[str, Any] = answer.json()
    return found


async def put(client: httpx.AsyncClient, draft: dict[str, Any], wish: dict[str, Any], revision: int) -> httpx.Response:
    body = {"name": draft["name"], "wish": wish, "revision": revision}
    return await client.put(f"/missions/{draft['id']}/draft", json=body)


async def test_a_name_is_enough_and_everybody_sees_who_began_it(rig: Rig) -> None:
    draft = await kept(rig)
    assert (draft["status"], draft["name"], draft["sha256"]) == ("draft", "Beans, second pass", "")
    async with rig.client(Role.VIEWER) as client:
        [seen] = (await client.get("/missions")).json()["missions"]
        opened = (await client.get(f"/missions/{draft['id']}")).json()
    assert (seen["id"], seen["created_by"], seen["robot_id"], seen["field_name"]) == (
        draft["id"], "Planner Person", None, "",
    )  # fmt: skip
    assert opened["wish"] == {}
    assert [(one["status"], one["by"], one["why"]) for one in opened["log"]] == [
        ("draft", "Planner Person", "Kept as a draft.")
    ]


async def test_it_is_opened_completed_and_planned_under_its_own_id_and_outlives_a_restart(rig: Rig) -> None:
    draft = await kept(rig)
    async with rig.client(Role.PLANNER) as client:
        saved = (await put(client, draft, CHOSEN, 1)).json()
        assert (saved["field_name"], saved["robot_id"], saved["is_supervised"]) == ("Home field", "weeder-01", False)
        again = Missions(rig.database, rig.clock)
        again.load()
        assert again.known(draft["id"]) == rig.missions.known(draft["id"])
        answer = await client.post(
            "/missions/plan", json={**CHOSEN, "draft_id": draft["id"], "draft_revision": saved["revision"]}
        )
        planned, opened = answer.json(), (await client.get(f"/missions/{draft['id']}")).json()
    assert answer.status_code == 201, answer.text
    assert (planned["id"], planned["status"], planned["name"]) == (draft["id"], "validated", "Beans, second pass")
    assert (planned["revision"], planned["statistics"]["pattern"]) == (1, "spiral")
    assert "wish" not in opened
    assert [one["status"] for one in opened["log"]] == ["draft", "draft", "validated"]
    assert await rig.book.stored(FARM, draft["id"], "weeder-01") is not None


async def test_what_others_saved_meanwhile_is_neither_overwritten_nor_planned_over(rig: Rig) -> None:
    draft = await kept(rig)
    async with rig.client(Role.PLANNER) as client:
        assert (await put(client, draft, CHOSEN, 1)).status_code == 200
        late = await put(client, draft, {}, 1)
        over = await client.post("/missions/plan", json={**CHOSEN, "draft_id": draft["id"], "draft_revision": 1})
    assert (late.status_code, late.json()["code"]) == (409, "draft_changed")
    assert (over.status_code, over.json()["code"]) == (409, "draft_changed")
    known = rig.missions.known(draft["id"])
    assert known is not None
    assert (known.status, known.wish) == (MissionStatus.DRAFT, CHOSEN)


async def test_a_name_that_somebody_gave_meanwhile_is_not_overwritten(rig: Rig) -> None:
    draft = await kept(rig)
    async with rig.client(Role.PLANNER) as client:
        renamed = await client.patch(f"/missions/{draft['id']}", json={"name": "Beans, north"})
        late = await put(client, draft, CHOSEN, 1)
    assert renamed.json()["revision"] == 2
    assert (late.status_code, late.json()["code"]) == (409, "draft_changed")
    known = rig.missions.known(draft["id"])
    assert known is not None
    assert known.name == "Beans, north"


async def test_a_draft_that_was_planned_or_deleted_is_one_no_more(rig: Rig) -> None:
    draft = await kept(rig)
    plan = {**CHOSEN, "draft_id": draft["id"], "draft_revision": 1}
    async with rig.client(Role.PLANNER) as client:
        first, second = await asyncio.gather(*(client.post("/missions/plan", json=plan) for _ in range(2)))
        assert sorted((first.status_code, second.status_code)) == [201, 409]
        assert (await put(client, draft, {}, 1)).json()["code"] == "no_draft"
        other = await kept(rig)
        assert (await client.delete(f"/missions/{other['id']}")).status_code == 204
        gone = await client.post("/missions/plan", json={**plan, "draft_id": other["id"]})
        assert gone.status_code == 404
    assert rig.missions.known(other["id"]) is None


async def test_it_is_never_sent_and_has_no_path_to_show(rig: Rig) -> None:
    draft = await kept(rig, {"name": "Later", "wish": CHOSEN})
    with pytest.raises(OrderRefused, match=r"Later is a draft\. Open it and plan it first\."):
        await rig.book.stored(FARM, draft["id"], "weeder-01")
    with pytest.raises(MissionRefused, match="is a draft"):
        await rig.book.document(rig.person(Role.PLANNER), draft["id"])
    async with rig.client(Role.PLANNER) as client:
        for path in ("document", "map.geojson"):
            answer = await client.get(f"/missions/{draft['id']}/{path}")
            assert (answer.status_code, answer.json()["code"]) == (409, "draft")


async def test_it_is_renamed_copied_and_given_to_another_robot_as_a_draft(rig: Rig) -> None:
    draft = await kept(rig, {"name": "Later", "wish": CHOSEN})
    async with rig.client(Role.PLANNER) as client:
        named = (await client.patch(f"/missions/{draft['id']}", json={"name": "Sooner"})).json()
        moved = (await client.patch(f"/missions/{draft['id']}", json={"robot_id": "weeder-02"})).json()
        copy = (await client.post(f"/missions/{draft['id']}/copy", json={})).json()
        opened = (await client.get(f"/missions/{copy['id']}")).json()
        # whoever had it open before the robot was changed does not put the old one back
        assert (await put(client, draft, CHOSEN, 1)).status_code == 409
    assert (named["name"], moved["robot_id"], moved["status"]) == ("Sooner", "weeder-02", "draft")
    assert (copy["status"], copy["name"]) == ("draft", "Sooner, copy")
    assert opened["wish"]["robot_id"] == "weeder-02"


async def test_who_may_not_plan_keeps_none_and_other_farms_see_none(rig: Rig) -> None:
    draft = await kept(rig)
    async with rig.client(Role.OPERATOR) as client:
        assert (await client.post("/missions/drafts", json=PLAIN)).status_code == 403
        assert (await put(client, draft, {}, 1)).status_code == 403
    async with rig.client(Role.PLANNER, OTHER_FARM) as client:
        assert (await put(client, draft, {}, 1)).status_code == 404
        assert (await client.get(f"/missions/{draft['id']}")).status_code == 404


@pytest.mark.parametrize(
    "wish", [{"width_m": -1}, {"overlap": 0.9}, {"name": 4}, {"width_m": 99.0}, {"nonsense": 1}, {"robot_id": "No Id"}]
)
async def test_choices_that_cannot_be_are_refused_at_once(rig: Rig, wish: dict[str, Any]) -> None:
    async with rig.client(Role.PLANNER) as client:
        assert (await client.post("/missions/drafts", json={"name": "X", "wish": wish})).status_code == 422


async def test_a_plan_that_is_refused_leaves_the_draft(rig: Rig) -> None:
    draft = await kept(rig)
    order = PlanOrder("bow-tie", "weeder-01", 3.0)
    with pytest.raises(Exception, match="crosses itself"):
        await rig.book.plan(rig.person(Role.PLANNER), order, draft["id"], 1)
    known = rig.missions.known(draft["id"])
    assert known is not None
    assert known.status is MissionStatus.DRAFT
