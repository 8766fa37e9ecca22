"""Planning templates over REST."""

from __future__ import annotations

import httpx
import pytest
from fastapi import FastAPI

from hmi.api import errors, plan_body
from hmi.api.access import Access
from hmi.api.templates import template_routes
from hmi.commands.template_book import TemplateBook
from hmi.domain.role import Role
from hmi.planning import job
from hmi.store.templates import Templates
from tests.hmi.missions.rig import FARM, OTHER_FARM, Door, NoTokens, Rig

WISH = {"width_m": 1.35, "pattern": "skip_rows", "overlap": 0.04}


def client(rig: Rig, role: Role | None, farm: str = FARM) -> httpx.AsyncClient:
    """Return a browser of somebody, or of nobody."""
    book = TemplateBook(Templates(rig.database, rig.clock), rig.database, rig.audit, rig.authorize)
    app = FastAPI()
    app.state.access = Access(Door(None if role is None else rig.person(role, farm)), NoTokens(), rig.authorize)
    app.include_router(template_routes(book))
    errors.install(app)
    return httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://console.local")


async def test_a_template_is_saved_listed_renamed_and_deleted(rig: Rig) -> None:
    async with client(rig, Role.PLANNER) as planner:
        saved = await planner.post("/plan-templates", json={"name": "Beet  4-leaf", "wish": WISH})
        assert saved.status_code == 201
        path = f"/plan-templates/{saved.json()['id']}"
        assert (saved.json()["name"], saved.json()["wish"]) == ("Beet 4-leaf", WISH)
        assert (await planner.patch(path, json={"name": "Beet"})).json()["name"] == "Beet"
        listed = (await planner.get("/plan-templates")).json()["templates"]
        assert [(one["name"], one["wish"]) for one in listed] == [("Beet", WISH)]
        assert (await planner.delete(path)).status_code == 204
        assert (await planner.get("/plan-templates")).json() == {"templates": []}
    assert [entry.outcome for entry in rig.audit.entries] == ["saved", "renamed", "deleted"]


async def test_a_name_is_used_once(rig: Rig) -> None:
    async with client(rig, Role.PLANNER) as planner:
        await planner.post("/plan-templates", json={"name": "Beet", "wish": WISH})
        again = await planner.post("/plan-templates", json={"name": "Beet", "wish": WISH})
    assert (again.status_code, again.json()["code"]) == (409, "already_exists")


async def test_a_template_may_carry_field_and_robot(rig: Rig) -> None:
    bound = {**WISH, "field_id": "field-1", "robot_id": "weeder-01"}
    async with client(rig, Role.PLANNER) as planner:
        saved = await planner.post("/plan-templates", json={"name": "Home field", "wish": bound})
    assert saved.json()["wish"] == bound


async def test_a_name_of_blanks_is_none(rig: Rig) -> None:
    async with client(rig, Role.PLANNER) as planner:
        answer = await planner.post("/plan-templates", json={"name": "   ", "wish": WISH})
    assert answer.status_code == 422
    assert "it is empty: give it a name that people know" in answer.text


def test_a_template_takes_the_widths_that_the_planner_takes() -> None:
    assert (plan_body.LEAST_WIDTH_M, plan_body.MOST_WIDTH_M) == (job.MIN_WIDTH_M, job.MAX_WIDTH_M)


@pytest.mark.parametrize(
    "wish", [{}, {"width_m": 1.0, "colour": "red"}, {"width_m": 1.0, "overlap": 2}, {"width_m": -3.0}]
)
async def test_what_could_not_be_planned_with_is_not_kept(rig: Rig, wish: dict[str, object]) -> None:
    async with client(rig, Role.PLANNER) as planner:
        assert (await planner.post("/plan-templates", json={"name": "Odd", "wish": wish})).status_code == 422


@pytest.mark.parametrize(("role", "status"), [(None, 401), (Role.VIEWER, 403), (Role.OPERATOR, 403)])
async def test_saving_needs_the_right_to_plan(rig: Rig, role: Role | None, status: int) -> None:
    async with client(rig, role) as someone:
        assert (await someone.post("/plan-templates", json={"name": "Beet", "wish": WISH})).status_code == status


async def test_another_farm_sees_none_of_it(rig: Rig) -> None:
    async with client(rig, Role.PLANNER) as planner:
        made = (await planner.post("/plan-templates", json={"name": "Beet", "wish": WISH})).json()
    async with client(rig, Role.PLANNER, OTHER_FARM) as stranger:
        assert (await stranger.get("/plan-templates")).json() == {"templates": []}
        assert (await stranger.delete(f"/plan-templates/{made['id']}")).status_code == 404
