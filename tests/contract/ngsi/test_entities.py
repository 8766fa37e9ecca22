"""The client writes and reads entities of a broker."""

from __future__ import annotations

from datetime import UTC, datetime

import pytest

from backend_clients.ngsi import entity as make
from backend_clients.ngsi import errors, location, query
from backend_clients.ngsi.client import NgsiClient
from backend_clients.ngsi.entity import Entity
from backend_clients.ngsi.identifier import EntityRef, ref_for
from backend_clients.ngsi.location import Position
from backend_clients.ngsi.query import Query

WEEDER = ref_for("AgriRobot", "weeder-01")
NASTY = """L'Eglise <b>"5;6"</b> (a=b) 100% %3C %25 & ? / # ñ 漢 🚜"""


def robot(which: str, **attributes: make.Attribute) -> Entity:
    return Entity(ref=ref_for("AgriRobot", which), attributes=attributes)


async def names(client: NgsiClient, wanted: Query, page: int = 200) -> list[str]:
    return [entity.ref.id.rpartition(":")[2] async for entity in client.entities(wanted, page=page)]


async def test_the_broker_says_what_it_is(client: NgsiClient) -> None:
    assert (await client.version()).startswith("orion")


async def test_every_kind_of_value_comes_back_as_it_went(client: NgsiClient) -> None:
    at = datetime(2026, 5, 1, 8, 30, tzinfo=UTC)
    given = robot(
        "weeder-01",
        speed=make.number(1.25, accuracy=make.Metadatum(value=0.1)),
        note=make.text(NASTY),
        on=make.boolean(value=True),
        at=make.date_time(at),
        plan=make.structured({"rows": [1, {"it's": "a(b)"}], "$inc": 1}),
        nothing=make.Attribute(type="None"),
    )
    await client.create(given)
    found = await client.get(WEEDER)
    assert found.ref == WEEDER
    assert found.value("speed") == 1.25
    assert found.attributes["speed"].metadata["accuracy"].value == 0.1
    assert found.value("note") == NASTY
    assert found.value("on") is True
    assert found.attributes["at"].moment() == at
    assert found.value("plan") == {"rows": [1, {"it's": "a(b)"}], "$inc": 1}
    assert found.value("nothing") is None


async def test_creating_twice_is_refused_and_changes_nothing(client: NgsiClient) -> None:
    await client.create(robot("weeder-01", speed=make.number(1)))
    with pytest.raises(errors.AlreadyExists):
        await client.create(robot("weeder-01", speed=make.number(2)))
    assert (await client.get(WEEDER)).value("speed") == 1


async def test_upsert_makes_and_then_writes_without_taking_anything_away(client: NgsiClient) -> None:
    await client.upsert(robot("weeder-01", speed=make.number(1), name=make.text("one")))
    await client.upsert(robot("weeder-01", speed=make.number(2)))
    found = await client.get(WEEDER)
    assert (found.value("speed"), found.value("name")) == (2, "one")


async def test_a_patch_that_misses_attributes_says_which_and_writes_the_others(client: NgsiClient) -> None:
    await client.create(robot("weeder-01", speed=make.number(1)))
    with pytest.raises(errors.PartlyApplied) as caught:
        await client.patch(WEEDER, {"speed": make.number(2), "zz": make.number(3)})
    assert caught.value.missed == ("zz",)
    assert caught.value.mend
    assert (await client.get(WEEDER)).value("speed") == 2
    with pytest.raises(errors.NotApplied):
        await client.patch(WEEDER, {"zz": make.number(3)})


async def test_append_replace_increment_and_delete_do_what_they_say(client: NgsiClient) -> None:
    await client.create(robot("weeder-01", passes=make.number(1)))
    await client.append(WEEDER, {"name": make.text("x")})
    with pytest.raises(errors.PartlyApplied) as caught:
        await client.append_new(WEEDER, {"name": make.text("y"), "row": make.number(4)})
    assert caught.value.missed == ("name",)
    await client.increment(WEEDER, "passes", 2)
    assert (await client.get(WEEDER)).value("passes") == 3
    await client.delete_attribute(WEEDER, "row")
    await client.replace(WEEDER, {"only": make.number(1)})
    assert set((await client.get(WEEDER)).attributes) == {"only"}
    await client.delete(WEEDER)
    assert await client.find(WEEDER) is None
    with pytest.raises(errors.NotFound):
        await client.delete(WEEDER)


async def test_one_id_of_two_types_is_two_entities(client: NgsiClient) -> None:
    other = EntityRef(WEEDER.id, "Other")
    await client.create(robot("weeder-01", n=make.number(1)))
    await client.create(Entity(ref=other, attributes={"n": make.number(2)}))
    assert (await client.get(other)).value("n") == 2
    await client.delete(other)
    assert (await client.get(WEEDER)).value("n") == 1


async def test_pages_hold_every_entity_once_although_the_order_has_ties(client: NgsiClient) -> None:
    await client.batch("append", [robot(f"r{n:02d}", rank=make.number(n % 2)) for n in range(23)])
    found = await names(client, Query(types=("AgriRobot",), order_by=("rank",)), page=5)
    assert sorted(found) == [f"r{n:02d}" for n in range(23)]
    assert await client.count(Query(types=("AgriRobot",))) == 23
    assert await client.types() == {"AgriRobot": 23}


async def test_what_is_deleted_while_pages_are_read_makes_nothing_be_left_out(client: NgsiClient) -> None:
    await client.batch("append", [robot(f"r{n:02d}") for n in range(20)])
    found = []
    async for entity in client.entities(Query(), page=5):
        found.append(entity.ref.id.rpartition(":")[2])
        if len(found) == 5:
            await client.batch("delete", [robot(f"r{n:02d}") for n in range(3)])
    assert found == [f"r{n:02d}" for n in range(20)]


async def test_what_is_made_for_what_is_deleted_between_pages_makes_nothing_be_left_out(client: NgsiClient) -> None:
    await client.batch("append", [robot(name) for name in "abcd"])
    found = []
    async for entity in client.entities(Query(), page=2):
        found.append(entity.ref.id.rpartition(":")[2])
        if found == ["a", "b"]:
            await client.delete(ref_for("AgriRobot", "a"))
            await client.create(robot("e"))
    assert found[:4] == ["a", "b", "c", "d"]


@pytest.mark.parametrize("size", [1, 2, 3])
async def test_pages_of_any_size_hold_every_entity_once(client: NgsiClient, size: int) -> None:
    await client.batch("append", [robot(f"r{n}") for n in range(7)])
    found = []
    async for entity in client.entities(Query(), page=size):
        found.append(entity.ref.id.rpartition(":")[2])
        if len(found) == 3:
            await client.batch("delete", [robot(f"r{n}") for n in range(3)])
    assert found == [f"r{n}" for n in range(7)]


async def test_what_a_batch_deleted_is_done_although_something_beside_it_was_gone_before(client: NgsiClient) -> None:
    await client.create(robot("there"))
    there, gone = ref_for("AgriRobot", "there"), ref_for("AgriRobot", "gone")
    outcome = await client.batch("delete", [Entity(ref=there), Entity(ref=gone)])
    assert await client.find(there) is None
    assert there in outcome.done
    alone = await client.batch("delete", [Entity(ref=gone)])
    assert isinstance(alone.failed[gone], errors.NotFound)


async def test_conditions_mean_what_they_say(client: NgsiClient) -> None:
    at = datetime(2026, 5, 1, tzinfo=UTC)
    plan = make.structured({"crop": {"name": "maize (late)"}})
    await client.batch(
        "append",
        [
            robot("a", speed=make.number(1), note=make.text(NASTY), at=make.date_time(at), plan=plan),
            robot("b", speed=make.number(2), note=make.text("12"), at=make.date_time(at.replace(day=3))),
            robot("c", on=make.boolean(value=True)),
        ],
    )

    async def found(*where: query.Condition) -> list[str]:
        return await names(client, Query(where=where))

    assert await found(query.equals("note", NASTY)) == ["a"]
    assert await found(query.equals("note", "12", "x")) == ["b"]
    assert await found(query.contains("note", "(a=b)")) == ["a"]
    assert await found(query.equals(("plan", "crop", "name"), "maize (late)")) == ["a"]
    assert await found(query.between("speed", 1.5, 2)) == ["b"]
    assert await found(query.at_least("speed", 1), query.less("speed", 2)) == ["a"]
    assert await found(query.greater("at", at)) == ["b"]
    assert await found(query.equals("on", True)) == ["c"]
    assert await found(query.absent("speed")) == ["c"]
    assert await found(query.exists("note")) == ["a", "b"]
    assert await found(query.differs("speed", 1)) == ["b"]


async def test_a_place_is_asked_for_in_the_order_of_its_names(client: NgsiClient) -> None:
    madrid, valencia = Position(lon_deg=-3.4809, lat_deg=40.3125), Position(lon_deg=-0.3763, lat_deg=39.4699)
    await client.create(robot("m", location=location.point(madrid)))
    await client.create(robot("v", location=location.point(valencia)))
    around = [Position(-4, 40), Position(-3, 40), Position(-3, 41), Position(-4, 41)]
    assert await names(client, Query(place=location.within(around))) == ["m"]
    assert await names(client, Query(place=location.related("disjoint", around))) == ["v"]
    assert await names(client, Query(place=location.near(madrid, max_m=1000))) == ["m"]
    assert await names(client, Query(place=location.near(madrid, min_m=1000))) == ["v"]
    at_valencia = Query(place=location.near(valencia, min_m=0))
    assert await names(client, at_valencia, page=1) == ["v", "m"]
    assert location.read_point((await client.get(ref_for("AgriRobot", "m"))).attributes["location"]) == madrid


async def test_a_second_place_needs_a_mark(client: NgsiClient) -> None:
    home = location.point(Position(-3, 40))
    with pytest.raises(errors.TooLarge):
        await client.create(robot("a", location=home, home=home))
    await client.create(robot("a", location=home, home=location.second(home)))


async def test_a_batch_names_those_that_failed_and_does_the_rest(client: NgsiClient) -> None:
    await client.batch("append", [robot(f"r{n}", speed=make.number(0)) for n in range(6)])
    batch = [robot(f"r{n}", speed=make.number(1)) for n in range(8)] + [robot("big", note=make.text("x" * 1_100_000))]
    outcome = await client.batch("update", batch)
    assert not outcome.is_complete()
    assert {ref.id.rpartition(":")[2] for ref in outcome.failed} == {"r6", "r7", "big"}
    assert len(outcome.done) == 6
    assert await names(client, Query(where=(query.equals("speed", 1),))) == [f"r{n}" for n in range(6)]


async def test_tenant_and_path_keep_entities_apart(client: NgsiClient, broker_url: str) -> None:
    from backend_clients.ngsi.connection import Broker
    from backend_clients.ngsi.tenant import Tenant

    await client.create(robot("weeder-01"))
    for other in (Tenant(client.connection.broker.tenant.service, "/farm/north"), Tenant("headland_test_other")):
        async with NgsiClient(Broker(broker_url, other)) as stranger:
            assert await stranger.count(Query()) == 0
            assert await stranger.find(WEEDER) is None
