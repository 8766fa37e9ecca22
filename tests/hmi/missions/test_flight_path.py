"""What stands in the path of a UAV keeps it from being sent and started, however long ago it was planned."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from hmi.app.mission_facts import MissionFactsBook
from hmi.commands.map_watch import MapWatch, flown_of
from hmi.commands.plan_wish import PlanOrder
from hmi.commands.refusal import OrderRefused
from hmi.commands.start_rules import MissionStartRules
from hmi.domain.map_log import FeatureChange, Transaction
from hmi.domain.mission_document import mission_sha256
from hmi.domain.robot import OrderStatus
from hmi.domain.role import Role
from hmi.presenters.start_checks import start_checks
from hmi.store.checklists import Checklists
from hmi.store.maps import Maps
from hmi.store.mission_revisions import MissionRevisions
from hmi.store.missions import Mission
from tests.hmi.missions.rig import FARM, Rig, lon_lat, order
from tests.hmi.planning.test_flight import KITE

ORDER = PlanOrder("field-1", "weeder-01", 10.0)
SILO = {"type": "Polygon", "coordinates": [lon_lat((8, 10), (14, 10), (14, 16), (8, 16), (8, 10))]}


def publish(rig: Rig, **properties: Any) -> None:
    """Put a silo on the published map, or change it; the pylon of the map is low."""
    maps = Maps(rig.database, rig.clock)
    maps.open(FARM, "anna", "Anna")
    before = maps.features_of(FARM, maps.published(FARM).number)
    silo = {"id": "silo", "kind": "building", "name": "Silo", **properties}
    after = {"type": "Feature", "id": "silo", "properties": silo, "geometry": SILO}
    low = {**before["pylon-1"], "properties": {**before["pylon-1"]["properties"], "height_m": 8}}
    changes = (FeatureChange("silo", before.get("silo"), after), FeatureChange("pylon-1", before["pylon-1"], low))
    maps.append(
        FARM, "anna", Transaction(f"ref-{maps.published(FARM).number}", "Drawn", "Anna", rig.clock.utc(), changes)
    )
    maps.publish(FARM, "anna", "Anna", "")


def fly(rig: Rig, path_height_m: float | None = 30.0) -> None:
    """Let the robot be one that flies."""
    sheet = replace(KITE, path_height_m=path_height_m)
    rig.fleet.robots["weeder-01"] = replace(rig.fleet.robots["weeder-01"], factsheet=sheet)


async def planned(rig: Rig, **properties: Any) -> Mission:
    publish(rig, **properties)
    fly(rig)
    return await rig.book.plan(rig.person(Role.PLANNER), ORDER)


async def refusal(rig: Rig, mission: Mission) -> OrderRefused | None:
    try:
        await rig.book.stored(FARM, mission.id, "weeder-01")
    except OrderRefused as refused:
        return refused
    return None


async def test_what_is_low_is_in_nobodys_way(rig: Rig) -> None:
    assert await refusal(rig, await planned(rig, height_m=12)) is None


async def test_what_grew_since_it_was_planned_is_in_the_way(rig: Rig) -> None:
    mission = await planned(rig, height_m=12)
    publish(rig, height_m=27)
    refused = await refusal(rig, mission)
    assert refused is not None
    assert (refused.code, refused.text) == (
        "in_flight_path",
        "Silo is in its path, too high to fly over at 30 m. Plan again.",
    )
    again = await rig.book.plan(rig.person(Role.PLANNER), ORDER)
    assert await refusal(rig, again) is None


async def test_a_height_that_somebody_cleared_is_in_the_way(rig: Rig) -> None:
    mission = await planned(rig, height_m=12)
    publish(rig)
    refused = await refusal(rig, mission)
    assert refused is not None
    assert "nobody entered how high. Enter the height on the map" in refused.text


@pytest.mark.parametrize(("height_m", "why"), [(15.0, "too high to fly over at 15 m"), (None, "does not say how high")])
async def test_a_robot_that_flies_lower_than_it_did_is_not_sent_over_it(
    rig: Rig, height_m: float | None, why: str
) -> None:
    mission = await planned(rig, height_m=12)
    fly(rig, height_m)
    refused = await refusal(rig, mission)
    assert refused is not None
    assert why in refused.text


async def test_a_start_is_refused_and_its_check_says_why(rig: Rig) -> None:
    mission = await planned(rig, height_m=12)
    facts = MissionFactsBook(
        rig.missions, rig.features, MapWatch(Maps(rig.database, rig.clock), rig.database), rig.database, rig.fleet
    )
    lists = Checklists(rig.database, rig.clock)
    rules = MissionStartRules(rig.missions, lists, lambda: False, lambda _robot_id: False, facts.in_flight)
    held = order(mission.id, mission.sha256, OrderStatus.LOADED)
    robot = rig.fleet.report("weeder-01", held, 1.0)
    person = rig.person(Role.OPERATOR)

    async def told() -> dict[str, Any]:
        for task in tuple(facts._reading.values()):
            await task
        return next(one for one in start_checks(robot, facts.of(mission.id)) if one["key"] == "flight")

    with pytest.raises(OrderRefused, match="being looked up"):  # what is not known does not count as good
        rules.check(person, robot, held, None)
    assert (await told())["ok"] is True
    rules.check(person, robot, held, None)
    publish(rig, height_m=27)
    facts.map_published()
    with pytest.raises(OrderRefused, match="being looked up"):
        rules.check_flight(robot, held)
    check = await told()
    assert (check["ok"], check["blocks"]) == (False, True)
    with pytest.raises(OrderRefused, match="Silo is in its path"):
        rules.check(person, robot, held, None)


async def test_who_drives_is_asked_nothing_of_heights(rig: Rig) -> None:
    mission = await planned(rig, height_m=12)
    rules = MissionStartRules(
        rig.missions, Checklists(rig.database, rig.clock), lambda: False, lambda _robot_id: False, lambda _id: None
    )
    held = order(mission.id, mission.sha256, OrderStatus.LOADED)
    rig.fleet.robots["weeder-01"] = replace(rig.fleet.robots["weeder-01"], factsheet=None)
    rules.check_flight(rig.fleet.report("weeder-01", held, 1.0), held)


async def test_what_a_rest_kept_counts_as_long_as_it_is_ahead_of_the_robot(rig: Rig) -> None:
    mission = await planned(rig, height_m=12)
    document = rig.missions.document(FARM, mission.id)
    kept = len(document["segments"])  # changed in flight: the rest begins behind all of them
    rest = {**document, "continues": {"base_sha256": mission.sha256, "segments": kept}}
    publish(rig, height_m=27)
    watch = MapWatch(Maps(rig.database, rig.clock), rig.database)
    sheet = rig.fleet.robots["weeder-01"].factsheet

    async def told(flown: int | None) -> str:
        try:
            await watch.check_flight(FARM, rest, sheet, flown)
        except OrderRefused as refused:
            return refused.text
        return ""

    assert "Silo is in its path" in await told(0)
    assert await told(kept) == await told(None) == ""
    held = order(mission.id, mission.sha256, OrderStatus.RUNNING)
    assert flown_of(mission, rig.fleet.report("weeder-01", held, 1.0)) == held.segment
    assert flown_of(mission, None) is None
    elsewhere = replace(mission, progress={"sha256": "0" * 64, "segment": 7, "segment_s_m": 1.0})
    assert flown_of(elsewhere, rig.fleet.report("weeder-01", replace(held, mission_id="other"), 1.0)) == 7


async def test_a_rest_is_looked_at_again_as_its_robot_comes_on(rig: Rig) -> None:
    mission = await planned(rig, height_m=12)
    document = rig.missions.document(FARM, mission.id)
    rest = {**document, "continues": {"base_sha256": mission.sha256, "segments": len(document["segments"])}}
    revisions = MissionRevisions(rig.missions, rig.database, rig.clock)
    sha256 = mission_sha256(rest)
    revisions.propose(FARM, mission.id, rest, dict(mission.statistics), "Anna", "")
    revisions.take(FARM, mission.id, sha256, "Anna", "")
    publish(rig, height_m=27)
    watch = MapWatch(Maps(rig.database, rig.clock), rig.database)
    facts = MissionFactsBook(rig.missions, rig.features, watch, rig.database, rig.fleet)
    held = order(mission.id, sha256, OrderStatus.PAUSED)

    async def told(segment: int) -> str | None:
        rig.fleet.report("weeder-01", replace(held, segment=segment), 1.0)
        facts.in_flight(mission.id)
        for task in tuple(facts._reading.values()):
            await task
        return facts.in_flight(mission.id)

    assert "Silo is in its path" in (await told(0) or "")
    assert await told(len(document["segments"])) == ""
