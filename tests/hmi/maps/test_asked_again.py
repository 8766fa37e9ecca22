"""The map over REST when an answer was lost and the same is asked again: nothing is done twice."""

from __future__ import annotations

import json
from typing import Any

import httpx

from hmi.domain.role import Role
from tests.hmi.maps.conftest import MapRig
from tests.hmi.maps.test_proposals import Cloud, browser, wished
from tests.hmi.maps.test_rest import one_change, opened, parcel, without_bow_tie


async def draft_of(client: httpx.AsyncClient) -> dict[str, Any]:
    """Return the draft as it is."""
    draft: dict[str, Any] = (await client.get("/map")).json()["draft"]
    return draft


async def test_a_step_is_told_as_it_is_stored(rig: MapRig) -> None:
    async with rig.browser(Role.PLANNER) as client:
        await opened(client)
        body = one_change("ref-west-1", None, parcel("west", -200))
        stored = (await client.post("/map/draft/transactions", json=body)).json()["changes"]
        other = one_change("ref-west-1", None, parcel("west-2", -300))
        again = (await client.post("/map/draft/transactions", json=other)).json()
    assert again["changes"] == stored
    assert [one["id"] for one in again["draft"]["log"]] == ["ref-west-1"]


async def test_an_import_that_is_taken_again_comes_once_even_when_its_file_is_forgotten(rig: MapRig) -> None:
    file = json.dumps({"type": "FeatureCollection", "features": [parcel("west", -200)]})
    async with rig.browser(Role.PLANNER) as client:
        await opened(client)
        read = (await client.post("/map/imports?name=farm.geojson", content=file)).json()
        body = {"id": "ref-import-1", "items": [one["n"] for one in read["items"]]}
        first = await client.post(f"/map/imports/{read['id']}/take", json=body)
        again = await client.post(f"/map/imports/{read['id']}/take", json=body)
        rig.exchange.cancel(rig.person(Role.PLANNER), read["id"])
        later = await client.post(f"/map/imports/{read['id']}/take", json=body)
        draft = await draft_of(client)
    assert [one["id"] for one in first.json()["changes"]] == ["west"]
    assert first.json()["changes"] == again.json()["changes"] == later.json()["changes"]
    assert [one["id"] for one in draft["log"]] == ["ref-import-1"]
    assert not {one["id"] for one in draft["features"]["features"]} & {"west-2", "west-3"}


async def test_a_proposal_that_is_taken_again_is_answered_as_before(rig: MapRig) -> None:
    cloud = Cloud()
    one = await wished(rig, cloud)
    async with browser(rig, cloud, Role.PLANNER) as client:
        await opened(client)
        first = await client.post(f"/map/proposals/{one.id}/take", json={"id": "ref-cloud-1"})
        again = await client.post(f"/map/proposals/{one.id}/take", json={"id": "ref-cloud-1"})
    assert first.status_code == 200, first.text
    assert first.json()["changes"] == again.json()["changes"]
    assert first.json()["changes"][0]["before"] != first.json()["changes"][0]["after"]
    assert [entry.outcome for entry in rig.audit.entries] == ["taken"]


async def test_undo_and_redo_name_their_step_and_publishing_what_was_seen(rig: MapRig) -> None:
    async with rig.browser(Role.PLANNER) as client:
        await without_bow_tie(client)
        for ref, name in (("ref-west-1", "west"), ("ref-east-1", "east")):
            change = one_change(ref, None, parcel(name, -200 if name == "west" else 400))
            assert (await client.post("/map/draft/transactions", json=change)).status_code == 200
        draft = await draft_of(client)
        assert (draft["undo_id"], draft["redo_id"]) == ("ref-east-1", None)
        undone = [await client.post("/map/draft/undo", json={"id": "ref-east-1"}) for _ in range(2)]
        assert undone[0].json()["changes"] == undone[1].json()["changes"]
        draft = await draft_of(client)
        assert (draft["undo_id"], draft["redo_id"]) == ("ref-west-1", "ref-east-1")
        other = await client.post("/map/draft/undo", json={"id": "ref-bowtie"})
        assert (other.status_code, other.json()["code"]) == (409, "changed")
        unseen = await client.post("/map/draft/publish", json={"last_id": "ref-east-1"})
        assert (unseen.status_code, unseen.json()["code"]) == (409, "changed")
        plain = [await client.post("/map/draft/redo", json={}), await client.post("/map/draft/undo")]
        assert [one.status_code for one in plain] == [200, 200]
        assert (await client.post("/map/draft/publish", json={"last_id": "ref-west-1"})).status_code == 200
