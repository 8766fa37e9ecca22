"""A mission whose rest was changed on a newer map is, as a whole, still the plan of the older one."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from typing import Any

import pytest

from hmi.app.mission_facts import MissionFactsBook
from hmi.commands.map_watch import MapWatch
from hmi.commands.mission_rest import RestOrder
from hmi.commands.refusal import OrderRefused
from hmi.domain.command import Outcome
from hmi.domain.robot import Mode, OrderStatus
from hmi.presenters.start_checks import MissionFacts
from hmi.store.maps import Maps
from tests.hmi.missions.rig import FARM, Rig
from tests.hmi.missions.test_map_watch import publish
from tests.hmi.missions.test_rest_book import Desk

REFUSED = "map is v2 now, plan uses v1. Plan again. Stone: Added."


@pytest.fixture(params=["stamped", "without a stamp"])
async def desk(rig: Rig, request: pytest.FixtureRequest) -> Desk:
    """Return a desk whose mission ran; see ``changed``."""
    return await changed(rig, is_stamped=request.param == "stamped")


async def changed(rig: Rig, *, is_stamped: bool = True) -> Desk:
    """Run a mission of map v1 to its end with a rest of map v2, which has a stone in its rows."""
    desk = Desk(rig)
    stamp = {"number": 1, "sha256": "0" * 64}

    def plan_on_v1(_session: Any, mission: Any, document: dict[str, Any]) -> Any:
        return replace(mission, map_version=1), {**document, "map_version": stamp} if is_stamped else document

    Maps(rig.database, rig.clock).published(FARM)
    rig.missions.change(FARM, "m-1", plan_on_v1, "Pieter", "Planned.")
    desk.reports(OrderStatus.RUNNING)
    publish(rig, "stone", 32, 27)
    planned = await desk.rests.preview(desk.supervisor, "m-1", RestOrder("change", leave_out=(desk.row(4),)))
    assert planned.document["map_version"]["number"] == 2
    sent = await desk.rests.send(desk.supervisor, "m-1", planned.sha256, "tick")
    assert sent.outcome is Outcome.ACCEPTED
    desk.reports(OrderStatus.DONE, Mode.IDLE)
    await desk.follow()
    return desk


async def test_a_copy_for_the_next_day_is_not_sent_through_what_stands_there_now(desk: Desk) -> None:
    copy = await desk.rig.book.again(FARM, "m-1", "Tomorrow", "Anna")
    assert copy.map_version == 1
    with pytest.raises(OrderRefused) as caught:
        await desk.rig.book.stored(FARM, copy.id, "weeder-01")
    assert caught.value.text == REFUSED


async def test_the_whole_mission_is_not_sent_again_through_what_stands_there_now(desk: Desk) -> None:
    with pytest.raises(OrderRefused) as caught:
        await desk.rig.book.stored(FARM, "m-1", "weeder-01")
    assert caught.value.text == REFUSED
    fresh = await desk.rests.fresh(desk.supervisor, "m-1", "tick")
    assert (fresh.outcome, fresh.text) == (Outcome.REJECTED, REFUSED)


async def test_the_check_before_a_start_names_the_map_of_what_would_run(desk: Desk) -> None:
    facts = await known(desk, "m-1")
    assert (facts.map_number, facts.map_text) == (2, "")
    copy = await desk.rig.book.again(FARM, "m-1", "Tomorrow", "Anna")
    facts = await known(desk, copy.id)
    assert (facts.map_number, facts.map_text) == (1, REFUSED[0].upper() + REFUSED[1:])


async def test_a_copy_that_was_stored_with_the_number_of_a_rest_is_judged_by_its_own_plan(rig: Rig) -> None:
    desk = await changed(rig)
    copy = await desk.rig.book.again(FARM, "m-1", "Tomorrow", "Anna")
    desk.rig.missions.change(FARM, copy.id, lambda _s, one, doc: (replace(one, map_version=2), doc), "Anna", "")
    with pytest.raises(OrderRefused, match="plan uses v1"):
        await desk.rig.book.stored(FARM, copy.id, "weeder-01")
    assert (await known(desk, copy.id)).map_number == 1


async def known(desk: Desk, mission_id: str) -> MissionFacts:
    """Return what the start checks know, once it is read."""
    rig = desk.rig
    watch = MapWatch(Maps(rig.database, rig.clock), rig.database)
    book = MissionFactsBook(rig.missions, rig.features, watch, rig.database, rig.fleet)
    book.of(mission_id)
    await asyncio.gather(*(one for one in asyncio.all_tasks() if one.get_name() == "mission facts"))
    facts = book.of(mission_id)
    assert facts is not None
    return facts
