"""A mission keeps the map it was planned on; a change around it is seen before it is sent."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import pytest

from hmi.commands.plan_wish import PlanOrder
from hmi.commands.refusal import OrderRefused
from hmi.domain.map_log import FeatureChange, Transaction
from hmi.domain.role import Role
from hmi.store.features import Feature
from hmi.store.maps import Maps
from tests.hmi.missions.rig import FARM, Rig, farm_map, lon_lat

ORDER = PlanOrder("field-1", "weeder-01", 3.0)


def publish(rig: Rig, name: str, x_m: float, y_m: float) -> None:
    """Draw a pylon and publish the map."""
    maps = Maps(rig.database, rig.clock)
    maps.open(FARM, "anna", "Anna")
    feature: dict[str, Any] = {
        "type": "Feature",
        "id": name,
        "properties": {"id": name, "kind": "obstacle", "name": name.title(), "radius_m": 1.0},
        "geometry": {"type": "Point", "coordinates": lon_lat((x_m, y_m))[0]},
    }
    change = FeatureChange(name, None, feature)
    maps.append(FARM, "anna", Transaction(f"ref-{name}", "Drawn", "Anna", rig.clock.utc(), (change,)))
    maps.publish(FARM, "anna", "Anna", "")


async def test_what_is_published_while_a_plan_is_made_makes_it_look_old(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    read = rig.features.all

    def published_after(farm_id: str, kinds: Sequence[str] = ()) -> list[Feature]:
        features = read(farm_id, kinds)
        monkeypatch.undo()
        publish(rig, "ditch", 30.0, 30.0)
        return features

    monkeypatch.setattr(rig.features, "all", published_after)
    mission = await rig.book.plan(rig.person(Role.PLANNER), ORDER)
    assert mission.map_version == 1
    with pytest.raises(OrderRefused, match="map is v2 now, plan uses v1") as caught:
        await rig.book.stored(FARM, mission.id, "weeder-01")
    assert caught.value.code == "map_changed"


async def test_a_plan_carries_the_number_and_hash_of_its_map(rig: Rig) -> None:
    mission = await rig.book.plan(rig.person(Role.PLANNER), ORDER)
    document = rig.missions.document(FARM, mission.id)
    assert mission.map_version == 1
    assert document["map_version"]["number"] == 1
    assert len(document["map_version"]["sha256"]) == 64


async def test_a_change_in_the_field_keeps_the_plan_from_being_sent_and_says_what_changed(rig: Rig) -> None:
    mission = await rig.book.plan(rig.person(Role.PLANNER), ORDER)
    publish(rig, "well", 10, 30)
    with pytest.raises(OrderRefused) as caught:
        await rig.book.stored(FARM, mission.id, "weeder-01")
    assert caught.value.code == "map_changed"
    assert caught.value.text == "map is v2 now, plan uses v1. Plan again. Well: Added."


async def test_a_change_elsewhere_is_only_noted(rig: Rig) -> None:
    mission = await rig.book.plan(rig.person(Role.PLANNER), ORDER)
    publish(rig, "well", 900, 900)
    stored = await rig.book.stored(FARM, mission.id, "weeder-01")
    assert stored is not None
    assert stored.note == "The map is v2 now; nothing changed around this field since v1."


def far_home(rig: Rig) -> None:
    """Put the home at the end of a road of half a kilometre."""
    road, home = (one for one in farm_map() if one.id in ("road-1", "home-1"))
    line = {"type": "LineString", "coordinates": lon_lat((-500, 10), (4, 10))}
    rig.features.put(
        [replace(road, geometry=line), replace(home, geometry={"type": "Point", "coordinates": lon_lat((-480, 10))[0]})]
    )


@pytest.mark.parametrize("y_m", [10, 18])
async def test_a_change_on_the_way_home_keeps_the_plan_from_being_sent(rig: Rig, y_m: float) -> None:
    far_home(rig)
    mission = await rig.book.plan(rig.person(Role.PLANNER), ORDER)
    publish(rig, "trench", -340, y_m)
    with pytest.raises(OrderRefused, match="Trench: Added"):
        await rig.book.stored(FARM, mission.id, "weeder-01")


async def test_what_lies_beside_a_long_way_is_only_noted(rig: Rig) -> None:
    far_home(rig)
    mission = await rig.book.plan(rig.person(Role.PLANNER), ORDER)
    publish(rig, "trench", -340, 60)
    stored = await rig.book.stored(FARM, mission.id, "weeder-01")
    assert stored is not None
    assert stored.note
