"""The book of missions: planning, sending, rights."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from hmi.commands.plan_wish import PlanOrder
from hmi.commands.refusal import OrderRefused
from hmi.domain.mission import MissionStatus, Mover
from hmi.domain.mission_document import mission_sha256
from hmi.domain.mission_plan import PlanRefused
from hmi.domain.role import Role
from hmi.security.errors import NotAllowed
from hmi.store.errors import NotFound
from tests.hmi.missions.rig import FARM, OTHER_FARM, Rig
from tests.hmi.missions.test_store import put

ORDER = PlanOrder("field-1", "weeder-01", 3.0)
S = MissionStatus


async def test_a_plan_uses_the_map_around_the_field(rig: Rig) -> None:
    mission = await rig.book.plan(rig.person(Role.PLANNER), ORDER)
    document = rig.missions.document(FARM, mission.id)
    kinds = [segment["kind"] for segment in document["segments"]]
    assert kinds[0] == "approach"
    assert kinds[-1] == "exit"
    assert mission.statistics["area_m2"] == pytest.approx(1600 - math.pi * 4, abs=2)
    assert mission.statistics["angle_rad"] == pytest.approx(0, abs=1e-6)
    assert (mission.status, mission.robot_id, mission.name) == (S.VALIDATED, "weeder-01", "Home field, 3 m")


async def test_the_row_direction_that_is_asked_for_wins_over_the_map(rig: Rig) -> None:
    mission = await rig.book.plan(rig.person(Role.PLANNER), replace(ORDER, row_bearing_deg=0.0))
    assert mission.statistics["angle_rad"] == pytest.approx(math.pi / 2, abs=1e-4)


async def test_planning_is_written_to_the_audit(rig: Rig) -> None:
    mission = await rig.book.plan(rig.person(Role.PLANNER), ORDER)
    [entry] = rig.audit.entries
    assert (entry.actor, entry.kind, entry.outcome, entry.ref) == ("Planner Person", "mission", "planned", mission.id)


async def test_a_preview_stores_nothing(rig: Rig) -> None:
    planned = await rig.book.preview(rig.person(Role.PLANNER), ORDER)
    assert planned.statistics["rows"] > 5
    assert rig.missions.all_known(FARM) == []


@pytest.mark.parametrize("role", [Role.VIEWER, Role.OPERATOR, Role.DISPATCHER])
async def test_who_may_not_change_missions_is_refused_at_every_change(rig: Rig, role: Role) -> None:
    put(rig)
    person = rig.person(role)
    for change in (
        lambda: rig.book.plan(person, ORDER),
        lambda: rig.book.preview(person, ORDER),
        lambda: rig.book.rename(person, "m-1", "Mine"),
        lambda: rig.book.copy(person, "m-1"),
        lambda: rig.book.delete(person, "m-1"),
    ):
        with pytest.raises(NotAllowed):
            await change()
    assert [one.name for one in rig.book.list(person)] == ["Home field"]


async def test_a_field_that_is_not_there_or_not_sound_is_refused(rig: Rig) -> None:
    planner = rig.person(Role.PLANNER)
    with pytest.raises(NotFound):
        await rig.book.plan(planner, replace(ORDER, field_id="nowhere"))
    with pytest.raises(PlanRefused, match="crosses itself"):
        await rig.book.plan(planner, replace(ORDER, field_id="bow-tie"))


async def test_a_copy_is_ready_to_send_and_has_its_own_hash(rig: Rig) -> None:
    original = put(rig)
    rig.missions.move(FARM, "m-1", S.SENT, Mover.PERSON, "Martha")
    copy = await rig.book.copy(rig.person(Role.PLANNER), "m-1")
    assert copy.status is S.VALIDATED
    assert copy.name == "Home field, copy"
    assert copy.sha256 == mission_sha256(rig.missions.document(FARM, copy.id)) != original.sha256


async def test_a_stored_mission_goes_out_addressed_to_the_robot_with_its_hash(rig: Rig) -> None:
    put(rig)
    stored = await rig.book.stored(FARM, "m-1", "weeder-02")
    assert stored is not None
    assert stored.document["robot"] == "weeder-02"
    assert stored.sha256 == mission_sha256(stored.document)


async def test_there_is_no_mission_of_another_farm_to_send(rig: Rig) -> None:
    put(rig)
    assert await rig.book.stored(OTHER_FARM, "m-1", "weeder-01") is None
    assert await rig.book.stored(FARM, "m-9", "weeder-01") is None


async def test_a_mission_that_runs_on_one_robot_is_not_sent_to_another(rig: Rig) -> None:
    put(rig)
    for after, mover in ((S.SENT, Mover.PERSON), (S.ACCEPTED, Mover.ROBOT), (S.RUNNING, Mover.ROBOT)):
        rig.missions.move(FARM, "m-1", after, mover, "x")
    with pytest.raises(OrderRefused, match="Copy it for another robot"):
        await rig.book.stored(FARM, "m-1", "weeder-02")


async def test_a_robot_at_another_site_does_not_get_the_mission(rig: Rig) -> None:
    put(rig)
    rig.fleet.place("weeder-01", 40.3125, -3.4808)
    with pytest.raises(OrderRefused, match="km from Home field"):
        await rig.book.stored(FARM, "m-1", "weeder-01")
    rig.fleet.place("weeder-01", 51.7802, 4.2603)
    assert await rig.book.stored(FARM, "m-1", "weeder-01") is not None


async def test_sending_is_noted_with_the_person(rig: Rig) -> None:
    put(rig)
    await rig.book.sent(FARM, "m-1", "weeder-02", "Martha Keller")
    mission = rig.missions.known("m-1")
    assert mission is not None
    assert (mission.status, mission.robot_id) == (S.SENT, "weeder-02")
    assert rig.missions.log(FARM, "m-1")[-1].by == "Martha Keller"


async def test_a_report_that_overtakes_the_sending_is_not_undone(rig: Rig) -> None:
    put(rig)
    rig.missions.move(FARM, "m-1", S.ACCEPTED, Mover.ROBOT, "Weeder 01")
    await rig.book.sent(FARM, "m-1", "weeder-01", "Martha Keller")
    mission = rig.missions.known("m-1")
    assert mission is not None
    assert mission.status is S.ACCEPTED
    assert rig.missions.log(FARM, "m-1")[-1].by == "Martha Keller"
