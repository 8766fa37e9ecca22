"""One order to several robots: each answers for itself, and what failed can be tried again."""

from __future__ import annotations

import pytest

from hmi.commands.fleet_actions import FleetActions, RobotResult
from hmi.domain.command import Action, Outcome
from hmi.domain.role import Role
from tests.hmi.commands.field import ANNA, JONAS, MARTHA, VERA, Field, mission, person

IDS = ("weeder-01", "weeder-02", "planter-01")


@pytest.fixture
def field() -> Field:
    """Return a field of three robots."""
    made = Field()
    made.add("weeder-02", "Weeder 02")
    made.add("planter-01", "Planter 01")
    return made


def fleet(field: Field) -> FleetActions:
    """Return group orders on the desk of a field."""
    return FleetActions(field.desk.commands, field.desk.missions, field.desk.leases.of, field.audit)


def by_robot(results: list[RobotResult]) -> dict[str, tuple[str, str]]:
    """Return outcome and code of each robot."""
    return {one.robot_id: (one.outcome.value, one.code) for one in results}


async def test_a_pause_reaches_every_robot_and_each_answers(field: Field) -> None:
    results = await fleet(field).act(MARTHA, Action.PAUSE, IDS, field.tick())
    assert by_robot(results) == dict.fromkeys(IDS, ("accepted", "ok"))
    assert [len(field.robots[one].done) for one in IDS] == [1, 1, 1]


async def test_a_robot_that_refuses_takes_nothing_from_the_others(field: Field) -> None:
    field.robots["weeder-02"].refuse_with = ("area_not_clear", "Area not clear.")
    results = await fleet(field).act(MARTHA, Action.RETURN_HOME, IDS, field.tick())
    assert by_robot(results) == {
        "weeder-01": ("accepted", "ok"),
        "weeder-02": ("rejected", "area_not_clear"),
        "planter-01": ("accepted", "ok"),
    }
    assert field.audit.outcomes("group") == ["partly"]


async def test_a_robot_without_an_answer_is_never_called_done(field: Field) -> None:
    field.robots["weeder-02"].is_silent = True
    results = by_robot(await fleet(field).act(MARTHA, Action.PAUSE, IDS, field.tick()))
    assert results["weeder-01"][0] == "accepted"
    assert results["weeder-02"][0] == Outcome.TIMED_OUT.value


async def test_going_home_takes_control_of_free_robots_only(field: Field) -> None:
    other = await fleet(field).act(JONAS, Action.RETURN_HOME, ["weeder-02"], field.tick())
    assert other[0].outcome is Outcome.ACCEPTED
    results = await fleet(field).act(MARTHA, Action.RETURN_HOME, IDS, field.tick())
    assert by_robot(results)["weeder-02"] == ("rejected", "held_by_other")
    assert [one.text for one in results if one.robot_id == "weeder-02"] == ["Jonas Weber has control. Ask for it."]
    holders = {one: field.desk.leases.of(one) for one in IDS}
    assert {one: lease.holder.user_name for one, lease in holders.items() if lease} == {
        "weeder-01": "Martha Keller",
        "weeder-02": "Jonas Weber",
        "planter-01": "Martha Keller",
    }


async def test_those_that_failed_can_be_tried_again_alone(field: Field) -> None:
    field.robots["weeder-02"].refuse_with = ("area_not_clear", "Area not clear.")
    first = await fleet(field).act(MARTHA, Action.RETURN_HOME, IDS, field.tick(), "group-0001")
    failed = [one.robot_id for one in first if one.outcome is not Outcome.ACCEPTED]
    field.robots["weeder-02"].refuse_with = None
    again = await fleet(field).act(MARTHA, Action.RETURN_HOME, failed, field.tick(), "group-0002")
    assert by_robot(again) == {"weeder-02": ("accepted", "ok")}
    assert [len(field.robots[one].done) for one in IDS] == [1, 1, 1]


async def test_a_repeated_request_acts_once(field: Field) -> None:
    for _ in range(3):
        await fleet(field).act(MARTHA, Action.RETURN_HOME, IDS, field.tick(), "group-0001")
    assert [len(field.robots[one].done) for one in IDS] == [1, 1, 1]


async def test_an_order_decided_on_an_old_picture_moves_nothing(field: Field) -> None:
    tick = field.tick()
    field.wait(2.5)
    results = await fleet(field).act(MARTHA, Action.RETURN_HOME, IDS, tick)
    assert {one.code for one in results} == {"stale_tick"}
    assert [field.robots[one].done for one in IDS] == [[], [], []]


async def test_a_stopped_robot_stays_and_says_so_while_the_others_go(field: Field) -> None:
    field.robots["planter-01"].press("stop-00001", "Anna")
    results = by_robot(await fleet(field).act(MARTHA, Action.RETURN_HOME, IDS, field.tick()))
    assert results["planter-01"] == ("rejected", "latched")
    assert results["weeder-01"][0] == "accepted"


async def test_rights_are_asked_for_each_robot(field: Field) -> None:
    field.robots["weeder-02"].farm_id = "elsewhere"
    results = by_robot(await fleet(field).act(ANNA, Action.PAUSE, (*IDS, "weeder-99"), field.tick()))
    assert results["weeder-02"] == ("rejected", "other_farm")
    assert results["weeder-99"] == ("rejected", "unknown_robot")
    assert results["weeder-01"][0] == "accepted"
    viewer = by_robot(await fleet(field).act(VERA, Action.PAUSE, IDS, field.tick()))
    assert viewer["weeder-01"] == ("rejected", "not_allowed")


async def test_a_robot_named_twice_is_asked_once(field: Field) -> None:
    results = await fleet(field).act(MARTHA, Action.PAUSE, ["weeder-01", "weeder-01"], field.tick())
    assert len(results) == 1


async def test_missions_go_one_after_the_other_and_each_robot_answers(field: Field) -> None:
    field.robots["weeder-02"].refuse_with = ("no_space", "No space left.")
    pairs = [("weeder-01", "field-1"), ("weeder-02", "field-1"), ("planter-01", "field-9")]
    planner = person("Paula Planner", Role.PLANNER)
    results = await fleet(field).send(planner, pairs)
    assert by_robot(results) == {
        "weeder-01": ("accepted", "ok"),
        "weeder-02": ("rejected", "no_space"),
        "planter-01": ("rejected", "unknown_mission"),
    }
    assert field.audit.outcomes("group") == ["partly"]


async def test_a_pause_needs_no_control_and_works_while_somebody_else_has_it(field: Field) -> None:
    field.weeder.mission = mission("field-1")
    await fleet(field).act(JONAS, Action.RETURN_HOME, ["weeder-01"], field.tick())
    results = by_robot(await fleet(field).act(MARTHA, Action.PAUSE, ["weeder-01"], field.tick()))
    assert results == {"weeder-01": ("accepted", "ok")}
