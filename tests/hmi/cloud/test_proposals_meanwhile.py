"""What the cloud wants, while the map here or the cloud itself changes beside it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import httpx
import pytest

from backend_clients.ngsi import entity as make
from backend_clients.ngsi.identifier import EntityRef
from hmi.cloud.outbox import Piece, Rank
from hmi.fiware.normalized import normalized
from hmi.mapping.merging import merged
from tests.hmi.cloud.test_proposals import BARN, NORTH, REF, WIDER, Farm


async def test_a_field_deleted_here_and_brought_back_is_told_again(tmp_path: Path) -> None:
    farm = Farm(tmp_path, NORTH, BARN)
    await farm.rig.run(2)
    del farm.features["north"]
    farm.tell()
    await farm.rig.run(2)
    assert await farm.in_cloud() == {}
    assert farm.deleted(REF), "the broker tells of our own deletion, too"
    farm.features["north"] = NORTH
    farm.tell()
    await farm.rig.run(2)
    assert (farm.book.all(), list(await farm.in_cloud())) == ([], [REF.id])
    await farm.rig.close()


async def test_a_map_published_while_the_one_before_goes_up_goes_up_after_it(tmp_path: Path) -> None:
    farm = Farm(tmp_path, NORTH, BARN)
    await farm.rig.run(2)

    class Published(httpx.AsyncBaseTransport):
        async def handle_async_request(self, request: httpx.Request) -> httpx.Response:
            if b"Second" in request.content:
                farm.features["north"] = replace(NORTH, name="Third")
                farm.tell()
            return await inner.handle_async_request(request)

    inner, farm.rig.road._inner = farm.rig.road._inner, Published()
    farm.features["north"] = replace(NORTH, name="Second")
    farm.tell()
    await farm.rig.run(2)
    assert (await farm.in_cloud())[REF.id]["name"] == "Third"
    assert farm.book.all() == []
    await farm.rig.close()


async def test_a_side_question_that_fails_takes_no_proposal_away_and_nothing_is_written_over(tmp_path: Path) -> None:
    farm = Farm(tmp_path, NORTH, BARN)
    await farm.rig.run(2)
    rye = {"id": "urn:ngsi-ld:AgriCrop:hof:rye", "type": "AgriCrop", "name": "Rye"}
    await farm.others.upsert(normalized(rye))
    await farm.others.patch(REF, {"hasAgriCrop": make.relationship(EntityRef(rye["id"], "AgriCrop"))})
    await farm.rig.run(301, step_s=50)
    assert [one.id for one in farm.book.all()] == ["north"]
    is_busy = True

    class Busy(httpx.AsyncBaseTransport):
        async def handle_async_request(self, request: httpx.Request) -> httpx.Response:
            if is_busy and "AgriCrop" in str(request.url):
                return httpx.Response(503, json={"error": "Busy", "description": "later"})
            return await inner.handle_async_request(request)

    inner, farm.rig.road._inner = farm.rig.road._inner, Busy()
    farm.features["barn"] = replace(BARN, name="Old barn")
    farm.tell()
    await farm.rig.run(2)
    is_busy = False
    assert [one.id for one in farm.book.all()] == ["north"]
    await farm.rig.run(60)
    assert (await farm.in_cloud())[REF.id]["hasAgriCrop"] == rye["id"]
    assert (await farm.rig.in_cloud("Building"))["urn:ngsi-ld:Building:hof:barn"]["name"] == "Old barn"
    await farm.rig.close()


@pytest.mark.parametrize("is_notified", [True, False])
async def test_a_field_added_in_the_cloud_and_deleted_there_is_proposed_no_more(
    tmp_path: Path, is_notified: bool
) -> None:
    farm = Farm(tmp_path, NORTH)
    await farm.rig.run(2)
    south = {"id": "urn:ngsi-ld:AgriParcel:hof:south", "type": "AgriParcel", "name": "South",
             "location": {"type": "Polygon", "coordinates": [WIDER]}}  # fmt: skip
    ref = EntityRef(south["id"], south["type"])
    await farm.others.upsert(normalized(south))
    await farm.rig.run(301, step_s=50)
    assert [(one.id, one.what) for one in farm.book.all()] == [("south", "added")]
    await farm.others.delete(ref)
    if is_notified:
        assert farm.deleted(ref)
        await farm.rig.run(1)
    else:
        await farm.rig.run(301, step_s=50)
    assert farm.book.all() == []
    await farm.rig.close()


async def test_proposals_of_a_cloud_that_knows_nothing_of_us_any_more_are_gone(tmp_path: Path) -> None:
    farm = Farm(tmp_path, NORTH)
    await farm.rig.run(2)
    await farm.others.patch(REF, {"name": make.text("Theirs")})
    await farm.rig.run(301, step_s=50)
    assert len(farm.book.all()) == 1
    await farm.others.delete(REF)  # with everything else
    await farm.rig.link.take_tenant()
    await farm.rig.run(2)
    assert farm.book.all() == []
    assert (await farm.in_cloud())[REF.id]["name"] == "North"
    await farm.rig.close()


@pytest.mark.parametrize("is_noticed", [True, False])
async def test_a_deletion_stays_proposed_when_the_tenant_is_taken(tmp_path: Path, is_noticed: bool) -> None:
    farm = Farm(tmp_path, NORTH, BARN)
    await farm.rig.run(2)
    await farm.others.delete(REF)
    if is_noticed:
        await farm.rig.run(301, step_s=50)
        assert [(one.id, one.what) for one in farm.book.all()] == [("north", "removed")]
    await farm.rig.link.take_tenant()
    farm.rig.road.broken = lambda request: httpx.ConnectError("away") if "AgriParcel" in str(request.url) else None
    await farm.rig.run(2)
    farm.rig.road.broken = None
    await farm.rig.run(60)
    assert [(one.id, one.what) for one in farm.book.all()] == [("north", "removed")]
    assert await farm.in_cloud() == {}
    farm.book.drop("north")
    farm.tell()
    await farm.rig.run(2)
    assert list(await farm.in_cloud()) == [REF.id], "refused, it is written again"
    await farm.rig.close()


async def test_a_large_map_gets_through_a_slow_way_and_holds_up_nothing(tmp_path: Path) -> None:
    many = [replace(NORTH, id=f"f{n}", name=f"Field {n}") for n in range(40)]
    farm = Farm(tmp_path, *many)
    sizes: list[int] = []

    class Slow(httpx.AsyncBaseTransport):
        async def handle_async_request(self, request: httpx.Request) -> httpx.Response:
            size = request.content.count(b'"type": "AgriParcel"')
            if request.url.path == "/v2/op/update" and size > 3:
                farm.rig.clock.advance(8.0)
                raise httpx.WriteTimeout("slow", request=request)
            sizes.append(size)
            return await inner.handle_async_request(request)

    inner, farm.rig.road._inner = farm.rig.road._inner, Slow()
    body = {"id": "urn:ngsi-ld:Alert:hof:a", "type": "Alert", "description": "It happened"}
    farm.rig.backlog.put(Piece("weeder-01", Rank.ALARM, farm.rig.clock.utc().timestamp(), json.dumps(body)))
    await farm.rig.run(2)
    assert farm.rig.backlog.total == 0, "before the map got through"
    await farm.rig.run(600, step_s=5)
    assert len(await farm.in_cloud()) == 40
    assert sum(sizes) < 60, "what arrived is not sent again"
    await farm.rig.close()


async def test_what_was_taken_beside_changes_of_our_own_is_done_once_both_are_published(tmp_path: Path) -> None:
    farm = Farm(tmp_path, NORTH)
    await farm.rig.run(2)
    await farm.others.patch(REF, {"name": make.text("Theirs")})
    await farm.rig.run(301, step_s=50)
    assert len(farm.book.all()) == 1
    farm.features["north"] = replace(NORTH, name="Theirs", properties={"crop": "Rye"})
    assert farm.book.published(farm.features)
    farm.tell()
    await farm.rig.run(2)
    assert farm.book.all() == [], "the crop that is old there is nobody's wish"
    found = (await farm.in_cloud())[REF.id]
    assert (found["name"], found["hasAgriCrop"].rpartition(":")[2]) == ("Theirs", "rye")
    await farm.rig.run(301, step_s=50)
    maize = EntityRef("urn:ngsi-ld:AgriCrop:hof:maize", "AgriCrop")
    await farm.others.patch(REF, {"hasAgriCrop": make.relationship(maize)})
    await farm.rig.run(301, step_s=50)
    assert [one.what for one in farm.book.all()] == ["changed"], "who asks for it now is heard"
    await farm.rig.close()


async def test_a_proposal_compares_with_the_map_as_it_is_now_after_something_else_was_published(tmp_path: Path) -> None:
    farm = Farm(tmp_path, NORTH)
    await farm.rig.run(2)
    await farm.others.patch(REF, {"name": make.text("Theirs")})
    await farm.rig.run(301, step_s=50)
    farm.features["north"] = ours = replace(NORTH, name="North field")
    farm.book.published(farm.features)
    farm.tell()
    await farm.rig.run(2)
    [one] = farm.book.all()
    assert one.before == ours
    taken = merged(ours, one.before, one.after)
    assert taken is not None
    assert taken.name == "Theirs"
    await farm.rig.close()


async def test_names_that_are_never_told_hold_up_no_other_entity_and_nothing_is_written_over(tmp_path: Path) -> None:
    farm = Farm(tmp_path, NORTH)
    await farm.rig.run(2)
    inner = farm.rig.road._inner

    class Nameless(httpx.AsyncBaseTransport):
        async def handle_async_request(self, request: httpx.Request) -> httpx.Response:
            if request.method == "GET" and "AgriCrop" in str(request.url):
                return httpx.Response(400, json={"error": "BadRequest", "description": "no"}, request=request)
            return await inner.handle_async_request(request)

    farm.rig.road._inner = Nameless()
    await farm.others.patch(REF, {"name": make.text("Theirs")})
    farm.features["barn"] = BARN
    farm.tell()
    await farm.rig.run(60, step_s=5)
    assert farm.rig.link.link.is_well
    assert await farm.rig.in_cloud("Building")
    assert ((await farm.in_cloud())[REF.id]["name"], farm.book.left_out) == ("Theirs", 1)
    farm.rig.road._inner = inner
    await farm.rig.run(301, step_s=50)
    assert ([one.id for one in farm.book.all()], farm.book.left_out) == (["north"], 0)
    await farm.rig.close()


async def test_a_change_refused_while_names_cannot_be_read_is_written_over_then_and_not_with_the_next_map(
    tmp_path: Path,
) -> None:
    farm = Farm(tmp_path, NORTH)
    await farm.rig.run(2)
    await farm.others.patch(REF, {"name": make.text("Theirs")})
    await farm.rig.run(301, step_s=50)
    assert [one.id for one in farm.book.all()] == ["north"]
    inner = farm.rig.road._inner

    class Nameless(httpx.AsyncBaseTransport):
        async def handle_async_request(self, request: httpx.Request) -> httpx.Response:
            if request.method == "GET" and "AgriCrop" in str(request.url):
                return httpx.Response(400, json={"error": "BadRequest", "description": "no"}, request=request)
            return await inner.handle_async_request(request)

    farm.rig.road._inner = Nameless()
    farm.book.drop("north")
    farm.tell()
    await farm.rig.run(2)
    assert (await farm.in_cloud())[REF.id]["name"] == NORTH.name
    await farm.rig.close()


async def test_what_was_published_beside_a_wish_goes_up_when_the_wish_is_taken_back(tmp_path: Path) -> None:
    farm = Farm(tmp_path, NORTH)
    await farm.rig.run(2)
    told = (await farm.others.get(REF)).attributes["name"]
    await farm.others.patch(REF, {"name": make.text("Theirs")})
    await farm.rig.run(301, step_s=50)
    farm.features["north"] = replace(NORTH, name="Ours, newer")
    farm.tell()
    await farm.rig.run(2)
    assert (await farm.in_cloud())[REF.id]["name"] == "Theirs"
    await farm.others.patch(REF, {"name": told})
    await farm.rig.run(301, step_s=50)
    assert farm.book.all() == []
    assert (await farm.in_cloud())[REF.id]["name"] == "Ours, newer"
    await farm.rig.close()
