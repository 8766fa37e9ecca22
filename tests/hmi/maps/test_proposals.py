"""Changes from the cloud over REST: a person takes them into a draft or refuses them; the broker posts hints."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import httpx
import pytest
from fastapi import FastAPI

from hmi.api import errors
from hmi.api.access import Access
from hmi.api.cloud import proposal_routes
from hmi.api.cloud_notify import CloudNotify
from hmi.api.maps import map_routes
from hmi.cloud.proposals import Proposal, ProposalBook
from hmi.commands.map_book import parsed
from hmi.commands.map_proposals import MapProposals
from hmi.domain.role import Role
from hmi.fiware.map_change import signed
from hmi.fiware.parcel import parcel_entity
from hmi.fiware.urn import Urns
from hmi.mapping.feature import MapFeature
from tests.hmi.maps.conftest import MapRig
from tests.hmi.missions.rig import FARM, Door, NoTokens

URNS = Urns("farm")


class Cloud:
    """What the routes need of the cloud's room."""

    def __init__(self) -> None:
        self.book = ProposalBook(URNS)
        self.hints: list[bytes] = []
        self.told = 0

    def proposals(self) -> list[dict[str, Any]]:
        """Return ids."""
        return [{"id": one.id} for one in self.book.all()]

    def lets_in(self, secret: str, source: str) -> bool:
        """Let in who has the right secret."""
        return secret == "right"

    def hint(self, body: bytes, headers: dict[str, str]) -> bool:
        """Take a hint."""
        self.hints.append(body)
        return body == b"{}"

    def refused(self) -> None:
        """Count what was refused."""
        self.told += 1


def browser(rig: MapRig, cloud: Cloud, role: Role) -> httpx.AsyncClient:
    """Return somebody's browser, at the routes of the map and of proposals."""
    app = FastAPI()
    app.state.access = Access(Door(rig.person(role, FARM)), NoTokens(), rig.authorize)
    app.include_router(map_routes(rig.map_book, rig.review, rig.exchange))
    proposals = MapProposals(cloud.book, rig.map_book, rig.authorize, rig.audit, cloud.refused)
    app.include_router(proposal_routes(cloud, proposals))  # type: ignore[arg-type]  # what these routes ask for
    errors.install(app)
    return httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://console.local")


async def wished(rig: MapRig, cloud: Cloud) -> Proposal:
    """Let somebody rename a field in the cloud."""
    ours: dict[str, MapFeature] = parsed(rig.maps.features_of(FARM, rig.maps.published(FARM).number))
    entity = {**signed(parcel_entity(URNS, ours["field-1"])), "name": "Renamed there"}
    assert cloud.book.look([entity], ours, rig.clock.utc())
    (one,) = cloud.book.all()
    return one


@pytest.fixture
def cloud() -> Cloud:
    """Return a cloud that wants nothing yet."""
    return Cloud()


async def test_a_change_from_the_cloud_goes_into_the_draft_as_a_step_that_can_be_undone(
    rig: MapRig, cloud: Cloud
) -> None:
    async with browser(rig, cloud, Role.PLANNER) as client:
        one = await wished(rig, cloud)
        early = await client.post(f"/map/proposals/{one.id}/take", json={"id": "ref-early-1"})
        assert early.status_code == 404, "there is no draft to put it into"
        await client.post("/map/draft", json={})
        answer = await client.post(f"/map/proposals/{one.id}/take", json={"id": "ref-take-1"})
        assert answer.status_code == 200, answer.text
        (change,) = answer.json()["changes"]
        assert change["after"]["properties"]["name"] == "Renamed there"
        assert answer.json()["draft"]["undo"].startswith("From the cloud: ")
        editor = answer.json()["draft"]["editor"]["name"]
        assert await in_draft_by(client) == editor
        whole = (await client.get("/map")).json()
        published = {item["id"]: item for item in whole["features"]["features"]}
        assert published["field-1"]["properties"]["name"] != "Renamed there"
        undone = (await client.post("/map/draft/undo")).json()
        assert undone["changes"][0]["after"]["properties"]["name"] == one.name
        assert await in_draft_by(client) == ""
        await client.post("/map/draft/redo")
        assert await in_draft_by(client) == editor
        assert (await client.delete("/map/draft")).is_success
        assert await in_draft_by(client) == ""
    assert [entry.outcome for entry in rig.audit.entries if entry.ref == one.id][-1] == "taken"


async def in_draft_by(client: httpx.AsyncClient) -> str:
    """Return in whose draft the one proposal is, empty for nobody's."""
    [one] = (await client.get("/map/proposals")).json()["proposals"]
    return str(one["in_draft_by"])


async def test_a_wish_that_changed_after_it_was_taken_is_not_in_the_draft(rig: MapRig, cloud: Cloud) -> None:
    async with browser(rig, cloud, Role.PLANNER) as client:
        one = await wished(rig, cloud)
        await client.post("/map/draft", json={})
        await client.post(f"/map/proposals/{one.id}/take", json={"id": "ref-take-7"})
        assert one.after is not None
        cloud.book._open[one.id] = replace(one, after=replace(one.after, name="Renamed there again"))
        assert await in_draft_by(client) == ""


async def changed(client: httpx.AsyncClient, ref: str, **properties: object) -> None:
    """Let the planner change the field in the draft."""
    whole = (await client.get("/map")).json()
    [before] = [item for item in whole["features"]["features"] if item["id"] == "field-1"]
    after = {**before, "properties": {**before["properties"], **properties}}
    change = {"id": "field-1", "before": before, "after": after}
    answer = await client.post("/map/draft/transactions", json={"id": ref, "label": "Edit", "changes": [change]})
    assert answer.status_code == 200, answer.text


async def test_what_the_draft_changed_of_a_field_stays_when_a_change_from_the_cloud_is_taken(
    rig: MapRig, cloud: Cloud
) -> None:
    async with browser(rig, cloud, Role.PLANNER) as client:
        one = await wished(rig, cloud)
        await client.post("/map/draft", json={})
        await changed(client, "ref-edit-1", crop="Rye")
        answer = await client.post(f"/map/proposals/{one.id}/take", json={"id": "ref-take-5"})
        (change,) = answer.json()["changes"]
        said = change["after"]["properties"]
        assert (said["name"], said["crop"]) == ("Renamed there", "Rye")


async def test_a_change_from_the_cloud_is_not_taken_over_the_same_change_of_the_draft(
    rig: MapRig, cloud: Cloud
) -> None:
    async with browser(rig, cloud, Role.PLANNER) as client:
        one = await wished(rig, cloud)
        await client.post("/map/draft", json={})
        await changed(client, "ref-edit-2", name="Renamed here")
        answer = await client.post(f"/map/proposals/{one.id}/take", json={"id": "ref-take-6"})
        assert (answer.status_code, answer.json()["text"]) == (
            422,
            "Renamed here: your draft changed its name, too. Take that back in the draft first, or refuse the change.",
        )
        assert await in_draft_by(client) == ""


async def test_a_refused_change_is_gone_and_the_cloud_is_told(rig: MapRig, cloud: Cloud) -> None:
    async with browser(rig, cloud, Role.PLANNER) as client:
        one = await wished(rig, cloud)
        assert (await client.post(f"/map/proposals/{one.id}/refuse")).status_code == 204
        assert (await client.get("/map/proposals")).json() == {"proposals": []}
        assert cloud.told == 1
        assert (await client.post(f"/map/proposals/{one.id}/refuse")).status_code == 404


async def test_who_may_not_edit_the_map_may_look_and_nothing_more(rig: MapRig, cloud: Cloud) -> None:
    one = await wished(rig, cloud)
    async with browser(rig, cloud, Role.OPERATOR) as client:
        assert (await client.get("/map/proposals")).status_code == 200
        assert (await client.post(f"/map/proposals/{one.id}/take", json={"id": "ref-take-2"})).status_code == 403
        assert (await client.post(f"/map/proposals/{one.id}/refuse")).status_code == 403
    assert cloud.book.get(one.id) == one


async def test_what_cannot_be_on_a_map_is_not_taken(rig: MapRig, cloud: Cloud) -> None:
    one = await wished(rig, cloud)
    cloud.book._open[one.id] = replace(one, problem="A parcel cannot be a Point.", after=None)
    async with browser(rig, cloud, Role.PLANNER) as client:
        await client.post("/map/draft", json={})
        answer = await client.post(f"/map/proposals/{one.id}/take", json={"id": "ref-take-3"})
    assert (answer.status_code, answer.json()["text"]) == (422, "A parcel cannot be a Point.")


async def test_the_broker_posts_without_signing_in_and_nobody_else_gets_an_answer(cloud: Cloud) -> None:
    behind: list[str] = []

    async def console(scope: Any, _receive: Any, send: Any) -> None:
        behind.append(scope["path"])
        await send({"type": "http.response.start", "status": 418, "headers": []})
        await send({"type": "http.response.body", "body": b""})

    door = httpx.ASGITransport(CloudNotify(console, cloud))
    async with httpx.AsyncClient(transport=door, base_url="http://console.local/api/v1") as client:
        assert (await client.post("/cloud/notify/right", content=b"{}")).status_code == 204
        assert (await client.post("/cloud/notify/wrong", content=b"{}")).status_code == 404
        assert (await client.post("/cloud/notify/right", content=b"x" * (2**20 + 1))).status_code == 413
        assert (await client.post("/cloud/notify/right", content=b"nonsense")).status_code == 400
        assert (await client.get("/cloud/notify/right")).status_code == 418
        assert (await client.post("/cloud/tenant")).status_code == 418
    assert cloud.hints == [b"{}", b"nonsense"]
    assert behind == ["/api/v1/cloud/notify/right", "/api/v1/cloud/tenant"]
