"""What somebody changes in the cloud is proposed and never done, and ours is not written over theirs."""

from __future__ import annotations

import json
from dataclasses import replace
from datetime import timedelta
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from pydantic import SecretStr

from backend_clients.ngsi import entity as make
from backend_clients.ngsi.client import NgsiClient
from backend_clients.ngsi.entity import Entity, entity_from_wire
from backend_clients.ngsi.gate import Gate
from backend_clients.ngsi.identifier import EntityRef
from backend_clients.ngsi.subscription import Wanted
from backend_clients.ngsi.subscriptions import Subscriptions
from backend_clients.ngsi.tenant import Tenant
from hmi.cloud.hints import Hints
from hmi.cloud.map_changes import STORM_S, MapChanges
from hmi.cloud.map_subscription import ENSURE_S, MapSubscription
from hmi.cloud.proposals import MOST, ProposalBook
from hmi.cloud.told_ids import ToldIds
from hmi.fiware.farm_map import map_entities
from hmi.fiware.map_change import KIND_OF, is_as_told, proposed, signed
from hmi.fiware.normalized import key_values, normalized
from hmi.fiware.urn import Urns
from hmi.mapping.feature import MapFeature
from tests.hmi.cloud.rig import Rig
from tests.hmi.map_files.features import maps

SECRET = "s" * 32
RING = [[10.0, 50.0], [10.001, 50.0], [10.001, 50.001], [10.0, 50.001], [10.0, 50.0]]
WIDER = [[10.0, 50.0], [10.002, 50.0], [10.002, 50.001], [10.0, 50.001], [10.0, 50.0]]
NORTH = MapFeature("north", "parcel", "North", {"type": "Polygon", "coordinates": [RING]}, {"crop": "Maize"})
BARN = MapFeature("barn", "building", "Barn", {"type": "Polygon", "coordinates": [RING]}, {"category": "barn"})
REF = EntityRef("urn:ngsi-ld:AgriParcel:hof:north", "AgriParcel")


@pytest.mark.slow
@given(written=maps)
@settings(max_examples=20, deadline=None)
def test_what_we_wrote_is_never_taken_for_somebody_elses_wish(written: list[MapFeature]) -> None:
    urns = Urns("hof")
    of = {one.id: one for one in written}
    for entity in map_entities(written, "hof", "Hof")[0]:
        if entity["type"] in KIND_OF:
            back = key_values(entity_from_wire(json.loads(json.dumps(normalized(signed(entity)).to_wire()))))
            assert is_as_told(back)
            feature_id = urns.name_of(entity["type"], entity["id"])
            assert feature_id is not None
            assert proposed(back, of[feature_id], urns) is None


class Farm:
    """A console with a published map, and somebody else in the cloud."""

    def __init__(self, folder: Path, *features: MapFeature, **how: Any) -> None:
        self.rig = Rig(folder, **how)
        self.features = {one.id: one for one in features}
        self.told = 0
        self.book = ProposalBook(self.rig.urns)
        self.hints = Hints(Gate(SecretStr(SECRET)), Tenant("farm"), self.rig.clock)
        client = self.rig.link.client
        self.rig.mirror._whole = self._whole
        told = ToldIds(folder / "told.json", "broker.test farm")
        self.rig.mirror.changes = MapChanges(client, self.book, self.hints, self.rig.clock, self._map, self._changed,
                                             told=told, is_ours=self.rig.is_ours)  # fmt: skip
        self.others: NgsiClient = client
        self.tell()

    def subscribe(self) -> tuple[Subscriptions, MapSubscription]:
        """Let the broker tell this console of changes."""
        ours = Subscriptions(self.others.connection, "console-hof")
        wanted = Wanted(key="map", url=f"http://127.0.0.1:9/notify/{SECRET}", types=tuple(KIND_OF))
        assert self.rig.mirror.changes is not None
        kept = MapSubscription(ours, wanted, self.rig.clock, self.rig.is_ours)
        self.rig.mirror.changes.subscription = kept
        return ours, kept

    async def _map(self) -> dict[str, MapFeature]:
        return self.features

    def _changed(self) -> None:
        self.told += 1

    def tell(self) -> None:
        """Let the mirror tell the map, but what is held back."""
        self.rig.mirror.tell_whole()

    async def _whole(self) -> list[dict[str, Any]]:
        found = [signed(one) for one in map_entities(list(self.features.values()), "hof", "Hof")[0]]
        return self.book.held_back(found)

    async def in_cloud(self) -> dict[str, Any]:
        """Return the parcels of the cloud."""
        return await self.rig.in_cloud("AgriParcel")

    def notified(self, entity: dict[str, Any], **how: Any) -> bool:
        """Post a notification."""
        headers = {"fiware-service": "farm", "fiware-servicepath": "/", **how.get("headers", {})}
        body = json.dumps({"subscriptionId": "x" * 24, "data": [entity]}).encode()
        return self.hints.lets_in(how.get("secret", SECRET), "127.0.0.1") and self.hints.take(body, headers)

    def deleted(self, ref: EntityRef) -> bool:
        """Post a notification of a deletion."""
        now = {"type": "DateTime", "value": self.rig.clock.utc().isoformat()}
        how = {"type": "Text", "value": "entityDelete"}
        return self.notified({"id": ref.id, "type": ref.type, "alterationType": how, "dateModified": now})


async def test_a_field_that_was_reshaped_in_the_cloud_is_proposed_and_not_written_over(tmp_path: Path) -> None:
    farm = Farm(tmp_path, NORTH, BARN)
    await farm.rig.run(1)
    assert farm.book.all() == []
    shape = make.Attribute(type="geo:json", value={"type": "Polygon", "coordinates": [WIDER]})
    await farm.others.patch(REF, {"location": shape})
    await farm.rig.run(301, step_s=50)  # nobody told: it is read every five minutes
    (one,) = farm.book.all()
    assert (one.id, one.what, one.name, one.problem) == ("north", "changed", "North", "")
    assert "moved" in one.text
    assert one.after is not None
    assert one.after.geometry["coordinates"][0][1] == [10.002, 50.0]
    assert one.after.properties == NORTH.properties
    assert farm.told == 1

    farm.features["barn"] = replace(BARN, name="Old barn")
    farm.tell()
    await farm.rig.run(2)
    assert (await farm.in_cloud())[REF.id]["location"]["coordinates"] == [WIDER], "theirs stays while it is open"
    assert (await farm.rig.in_cloud("Building"))["urn:ngsi-ld:Building:hof:barn"]["name"] == "Old barn"
    await farm.rig.close()


async def test_a_change_made_while_the_console_was_off_is_not_written_over_at_its_start(tmp_path: Path) -> None:
    farm = Farm(tmp_path, NORTH)
    await farm.rig.run(1)
    await farm.others.append(REF, {"cropStatus": make.text("growing")})
    again = Farm(tmp_path, NORTH)
    again.rig.road._inner = farm.rig.road._inner
    await again.rig.run(1)
    (one,) = again.book.all()
    assert one.after is not None
    assert one.after.properties == {"crop": "Maize", "status": "growing"}
    await again.rig.close()
    await farm.rig.close()


async def test_a_notification_is_a_hint_and_what_it_says_is_read_from_the_broker(tmp_path: Path) -> None:
    farm = Farm(tmp_path, NORTH)
    await farm.rig.run(1)
    await farm.others.patch(REF, {"name": make.text("North field")})
    lie = {"id": REF.id, "type": REF.type, "name": {"type": "Text", "value": "Owned"},
           "dateModified": {"type": "DateTime", "value": farm.rig.clock.utc().isoformat()}}  # fmt: skip
    assert farm.notified(lie)
    await farm.rig.run(1)
    (one,) = farm.book.all()
    assert one.after is not None
    assert one.after.name == "North field"
    await farm.rig.close()


async def test_notifications_that_repeat_or_overtake_each_other_are_counted_and_change_nothing(tmp_path: Path) -> None:
    farm = Farm(tmp_path, NORTH)
    await farm.rig.run(1)
    now = farm.rig.clock.utc()
    for ago_s in (3, 1, 2, 1, 0):
        at = (now - timedelta(seconds=ago_s)).isoformat()
        assert farm.notified({"id": REF.id, "type": REF.type, "dateModified": {"type": "DateTime", "value": at}})
    assert (farm.hints.counts.taken, farm.hints.counts.old) == (5, 2)
    await farm.rig.run(1)
    assert farm.book.all() == []
    await farm.rig.close()


async def test_notifications_of_others_are_refused_and_a_storm_of_ours_is_one_question(tmp_path: Path) -> None:
    farm = Farm(tmp_path, NORTH)
    await farm.rig.run(1)
    entity = {"id": REF.id, "type": REF.type}
    assert not farm.notified(entity, secret="x" * 32)
    assert not farm.notified(entity, headers={"fiware-service": "other"})
    assert not farm.hints.take(b"not json", {"fiware-service": "farm"})
    assert farm.hints.counts.refused == 3
    for number in range(2000):
        assert farm.notified({**entity, "id": f"{REF.id}-{number}"})
    assert farm.hints.is_too_many
    before = len(farm.rig.road.requests)
    await farm.rig.run(1)
    assert len(farm.rig.road.requests) - before < 6
    await farm.rig.close()


async def test_a_storm_is_read_now_and_then_and_its_newest_state_is_what_is_proposed(tmp_path: Path) -> None:
    farm = Farm(tmp_path, NORTH)
    await farm.rig.run(1)
    before = len(farm.rig.road.requests)
    for second in range(30):
        await farm.others.patch(REF, {"name": make.text(f"Name {second}")})
        for number in range(1000):
            assert farm.notified({"id": f"{REF.id}-{number}", "type": REF.type})
        await farm.rig.run(1)
    reads = [one for one in farm.rig.road.requests[before:] if one.url.path == "/v2/entities"]
    assert len(reads) <= 2 * (30 / STORM_S + 2)
    await farm.rig.run(STORM_S + 1)
    (one,) = farm.book.all()
    assert one.after is not None
    assert one.after.name == "Name 29"
    assert not farm.hints.is_too_many
    await farm.rig.close()


async def test_a_subscription_that_somebody_deleted_or_switched_off_is_made_again_and_counted(tmp_path: Path) -> None:
    farm = Farm(tmp_path, NORTH)
    ours, kept = farm.subscribe()
    await farm.rig.run(2)
    assert (kept.news.is_there, kept.news.lost) == (True, 0)
    await farm.rig.run(ENSURE_S + 2, step_s=20)
    assert kept.news.lost == 0
    await ours.clean_up(keep=())
    await farm.others.patch(REF, {"name": make.text("While nobody told")})
    await farm.rig.run(ENSURE_S + 2, step_s=20)
    assert (kept.news.lost, kept.news.how) == (1, "made")
    assert kept.news.lost_at is not None
    assert [one.id for one in farm.book.all()] == ["north"]
    assert len([one async for one in ours.mine()]) == 1
    await farm.rig.close()


async def test_a_broker_that_forgot_everything_is_subscribed_to_at_once(tmp_path: Path) -> None:
    farm = Farm(tmp_path, NORTH, is_strict=False)
    ours, kept = farm.subscribe()
    await farm.rig.run(2)
    await ours.clean_up(keep=())
    marker = EntityRef(farm.rig.urns.of("Headland", "console"), "Headland")
    await farm.others.batch("delete", [Entity(ref=marker), Entity(ref=REF)])
    await farm.rig.run(62, step_s=2)  # it is looked at once a minute, and after each failure
    assert len([one async for one in ours.mine()]) == 1
    assert kept.news.lost == 1
    await farm.rig.close()


async def test_a_field_that_is_new_in_the_cloud_is_proposed_and_nonsense_says_what_is_wrong(tmp_path: Path) -> None:
    farm = Farm(tmp_path, NORTH)
    shape = {"type": "Polygon", "coordinates": [WIDER]}
    crop = {"id": "urn:ngsi-ld:AgriCrop:wheat", "type": "AgriCrop", "name": "Wheat"}
    soil = {"id": "urn:ngsi-ld:AgriSoil:loam", "type": "AgriSoil", "name": "Loam"}
    south = {"id": "urn:ngsi-ld:AgriParcel:South-7", "type": "AgriParcel", "name": "South", "location": shape,
             "area": 3, "hasAgriCrop": crop["id"], "hasAgriSoil": soil["id"]}  # fmt: skip
    point = {**south, "id": "urn:ngsi-ld:AgriParcel:p", "location": {"type": "Point", "coordinates": [10, 50]}}
    for entity in (crop, soil, south, point):
        await farm.others.upsert(normalized(entity))
    await farm.rig.run(1)
    fresh, wrong = sorted(farm.book.all(), key=lambda one: one.problem)
    assert fresh.after is not None
    assert (fresh.id, fresh.what, fresh.after.name) == ("south-7", "added", "South")
    assert fresh.after.properties == {"crop": "Wheat", "soil_type": "Loam"}
    assert "Point" in wrong.problem
    await farm.rig.close()


async def test_a_field_that_was_deleted_in_the_cloud_is_proposed_to_be_removed(tmp_path: Path) -> None:
    farm = Farm(tmp_path, NORTH)
    await farm.rig.run(1)
    await farm.others.delete(REF)
    assert farm.deleted(REF)
    await farm.rig.run(1)
    (one,) = farm.book.all()
    assert (one.what, one.after) == ("removed", None)
    await farm.rig.close()


async def test_what_is_published_is_done_and_what_is_refused_is_told_as_we_have_it(tmp_path: Path) -> None:
    farm = Farm(tmp_path, NORTH, BARN)
    await farm.rig.run(1)
    await farm.others.patch(REF, {"name": make.text("Taken")})
    await farm.others.patch(EntityRef("urn:ngsi-ld:Building:hof:barn", "Building"), {"name": make.text("Refused")})
    await farm.rig.run(301, step_s=50)
    assert {one.id for one in farm.book.all()} == {"north", "barn"}
    north = farm.book.get("north")
    assert north is not None
    assert north.after is not None
    assert not farm.book.published({**farm.features}), "a map without it was published: it stays open"
    farm.features["north"] = north.after
    assert farm.book.published(farm.features)
    farm.book.drop("barn")
    farm.tell()
    await farm.rig.run(1)
    assert farm.book.all() == [], "what was refused does not come back before it is written over"
    assert (await farm.rig.in_cloud("Building"))["urn:ngsi-ld:Building:hof:barn"]["name"] == "Barn"
    farm.rig.mirror.changes.read_soon()  # type: ignore[union-attr]
    await farm.rig.run(1)
    assert farm.book.all() == []
    barn = EntityRef("urn:ngsi-ld:Building:hof:barn", "Building")
    await farm.others.patch(barn, {"name": make.text("Refused")})
    farm.rig.mirror.changes.read_soon()  # type: ignore[union-attr]
    await farm.rig.run(1)
    assert [one.id for one in farm.book.all()] == ["barn"], "somebody who wants it again is heard again"
    await farm.rig.close()


async def test_what_left_our_map_leaves_the_cloud_unless_somebody_else_changed_it_there(tmp_path: Path) -> None:
    farm = Farm(tmp_path, NORTH, BARN, replace(NORTH, id="south", name="South"))
    await farm.rig.run(1)
    south = EntityRef("urn:ngsi-ld:AgriParcel:hof:south", "AgriParcel")
    await farm.others.patch(south, {"name": make.text("Ours now")})
    del farm.features["north"], farm.features["south"]
    farm.tell()
    await farm.rig.run(1)
    assert set(await farm.in_cloud()) == {south.id}
    assert [(one.id, one.what) for one in farm.book.all()] == [("south", "added")]
    assert await farm.rig.in_cloud("Building")
    await farm.rig.close()


@pytest.mark.parametrize("number", [1.0, 2.5, -3.0])
def test_a_broker_may_write_numbers_its_own_way(number: float) -> None:
    entity = {"id": REF.id, "type": REF.type, "name": "N", "location": {"coordinates": [number, [number]]},
              "headland": {}}  # fmt: skip
    whole = json.loads(json.dumps(signed(entity)).replace(".0]", "]").replace(".0,", ","))
    assert is_as_told(whole)


async def test_changes_that_find_no_room_in_the_list_are_not_written_over_either(tmp_path: Path) -> None:
    many = [replace(NORTH, id=f"f{n}", name=f"Field {n}") for n in range(MOST + 3)]
    farm = Farm(tmp_path, *many)
    await farm.rig.run(2)
    for one in many:
        await farm.others.patch(EntityRef(f"urn:ngsi-ld:AgriParcel:hof:{one.id}", "AgriParcel"),
                                {"name": make.text("Theirs")})  # fmt: skip
    for _ in range(2):  # the same ones are not counted again
        farm.tell()
        await farm.rig.run(2)
        assert (len(farm.book.all()), farm.book.left_out) == (MOST, 3)
        assert {one["name"] for one in (await farm.in_cloud()).values()} == {"Theirs"}
    first = farm.book.all()[0]
    farm.book.drop(first.id)
    farm.tell()
    await farm.rig.run(2)
    assert (len(farm.book.all()), farm.book.left_out) == (MOST, 2)
    assert (await farm.in_cloud())[first.entity_id]["name"] != "Theirs", "refused: ours is written"
    await farm.rig.close()


async def test_what_was_taken_off_a_field_here_goes_in_the_cloud_and_is_no_wish_of_it(tmp_path: Path) -> None:
    sown = replace(
        NORTH, properties={"crop": "Maize", "soil_type": "Clay", "status": "growing", "seeded": "2026-05-01"}
    )
    farm = Farm(tmp_path, sown)
    await farm.rig.run(1)
    assert {"hasAgriSoil", "cropStatus", "lastPlantedAt"} <= (await farm.in_cloud())[REF.id].keys()
    farm.features["north"] = NORTH
    farm.tell()
    await farm.rig.run(1)
    await farm.rig.run(301, step_s=50)
    assert farm.book.all() == []
    assert not {"hasAgriSoil", "cropStatus", "lastPlantedAt"} & (await farm.in_cloud())[REF.id].keys()
    await farm.others.append(REF, {"ndvi": make.number(0.7)})
    farm.tell()
    await farm.rig.run(2)
    assert (await farm.in_cloud())[REF.id]["ndvi"] == 0.7, "what others added stays"
    await farm.rig.close()


async def test_a_field_deleted_in_the_cloud_while_the_console_was_off_is_proposed_and_not_written_again(
    tmp_path: Path,
) -> None:
    farm = Farm(tmp_path, NORTH, BARN)
    await farm.rig.run(1)
    await farm.others.delete(REF)
    again = Farm(tmp_path, NORTH, BARN, clock=farm.rig.clock, broker=farm.rig.broker)
    await again.rig.run(2)
    (one,) = again.book.all()
    assert (one.id, one.what, one.after) == ("north", "removed", None)
    assert await again.in_cloud() == {}, "while it is open it is not written again"
    again.book.drop("north")
    again.tell()
    await again.rig.run(301, step_s=50)
    assert REF.id in await again.in_cloud(), "refused: it is written again"
    assert again.book.all() == []
    await farm.rig.close()
    await again.rig.close()


async def test_a_field_that_is_gone_here_and_in_the_cloud_is_no_proposal(tmp_path: Path) -> None:
    farm = Farm(tmp_path, NORTH, BARN)
    await farm.rig.run(1)
    await farm.others.delete(REF)
    await farm.rig.run(301, step_s=50)
    assert [one.what for one in farm.book.all()] == ["removed"]
    del farm.features["north"]  # taken and published
    farm.book.published(farm.features)
    farm.tell()
    await farm.rig.run(301, step_s=50)
    assert (farm.book.all(), await farm.in_cloud()) == ([], {})
    farm.features["north"] = NORTH  # drawn anew
    farm.tell()
    await farm.rig.run(301, step_s=50)
    assert (farm.book.all(), list(await farm.in_cloud())) == ([], [REF.id])
    await farm.rig.close()


async def test_a_broker_that_forgot_everything_wants_no_field_removed(tmp_path: Path) -> None:
    farm = Farm(tmp_path, NORTH, is_strict=False)
    await farm.rig.run(1)
    again = Farm(tmp_path, NORTH, is_strict=False, clock=farm.rig.clock)  # the broker was started anew
    await again.rig.run(2)
    assert (again.book.all(), list(await again.in_cloud())) == ([], [REF.id])
    await farm.rig.close()
    await again.rig.close()


def test_what_another_tenant_was_told_does_not_count(tmp_path: Path) -> None:
    ToldIds(tmp_path / "told.json", "one").add([REF])
    assert ToldIds(tmp_path / "told.json", "one").all() == {REF}
    assert ToldIds(tmp_path / "told.json", "two").all() == set()
    (tmp_path / "told.json").write_bytes(b"{")
    assert ToldIds(tmp_path / "told.json", "one").all() == set()
