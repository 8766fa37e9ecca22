"""Commands to software nodes and to the tool, and what holds a command back because a function is off."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from typing import Any

import pytest

from hmi.commands.ledger import CommandResult
from hmi.commands.service import CommandRequest
from hmi.domain.command import NODE_ACTIONS, Action, CommandOrder, Outcome
from hmi.domain.machine import Body, FunctionInfo, JointInfo, NodeInfo, Target, Worksite
from hmi.domain.robot import Mode, Node, Stamp
from hmi.domain.role import Role
from hmi.security.session_info import SessionInfo
from tests.hmi.commands.field import ANNA, MARTHA, Field, factsheet, mission, person

ADA = person("Ada Adams", Role.ADMIN)
PLACE = (1.0, 2.0, 0.0)
TOOL_ACTIONS = (Action.TOOL_RETRACT, Action.SKIP_TARGET, Action.STOCK_REFILLED)


def on_the_field(state: str = "started") -> Field:
    """Return a field with a machine of one node, on which all its functions depend."""
    field = Field()
    names = ("treat", "follow-path", "manual-drive", "move-tool")
    functions = tuple(FunctionInfo(name, name.capitalize(), ("guidance",)) for name in names)
    nodes = (NodeInfo("guidance", "Guidance", "Drive", None, ()), NodeInfo("gnss", "RTK", "", None, ()))
    field.weeder.factsheet = factsheet(functions=functions, nodes=nodes)
    now_s = field.clock.mono_s()
    field.weeder.nodes = {"guidance": Node("guidance", state, None, None, 0, "", Stamp(now_s, now_s))}
    field.weeder.mission = mission()
    return field


async def submit(field: Field, action: Action, actor: SessionInfo = ADA, **more: Any) -> CommandResult:
    """Ask on a fresh picture."""
    asked = CommandRequest("weeder-01", action, f"{action.value}-0001", field.tick(), **more)
    return await field.desk.commands.submit(actor, asked)


def orders(field: Field) -> list[CommandOrder]:
    """Return what reached the robot."""
    return [one for one in field.weeder.orders if isinstance(one, CommandOrder)]


@pytest.mark.parametrize("action", sorted(NODE_ACTIONS))
async def test_an_admin_starts_stops_and_restarts_nodes_without_control(action: Action) -> None:
    field = on_the_field("failure")
    await submit(field, Action.PAUSE, MARTHA)
    result = await submit(field, action, node="guidance")
    assert result.is_accepted
    order = orders(field)[-1]
    assert (order.node, order.lease_token, order.challenge) == ("guidance", 0, field.weeder.challenge)
    assert field.desk.leases.of("weeder-01") is None


@pytest.mark.parametrize("action", sorted(NODE_ACTIONS))
async def test_nobody_below_an_admin_touches_nodes(action: Action) -> None:
    field = on_the_field()
    result = await submit(field, action, ANNA, node="guidance")
    assert (result.code, result.text) == (
        "not_allowed",
        "You can watch Weeder 01. Restarting nodes needs the admin role.",
    )
    assert orders(field) == []


async def test_the_audit_and_every_screen_learn_which_node_and_what_became_of_it() -> None:
    field = on_the_field()
    await submit(field, Action.NODE_RESTART, node="gnss")
    details = [one.data for one in field.audit.entries if one.kind == "command"]
    assert [one["about"] for one in details] == ["gnss", "gnss"]
    assert [one.outcome for one in field.audit.entries if one.kind == "command"] == ["pending", "accepted"]
    assert [(one["about"], one["outcome"]) for one in field.events_of("command")] == [
        ("gnss", "pending"),
        ("gnss", "accepted"),
    ]


async def test_the_same_id_for_another_node_is_no_repetition() -> None:
    field = on_the_field()
    await submit(field, Action.NODE_RESTART, node="gnss")
    assert (await submit(field, Action.NODE_RESTART, node="guidance")).code == "id_reused"


@pytest.mark.parametrize(
    ("action", "more", "code"),
    [
        (Action.NODE_STOP, {}, "incomplete"),
        (Action.NODE_STOP, {"node": "tail-light"}, "unknown_node"),
        (Action.PAUSE, {"node": "gnss"}, "incomplete"),
        (Action.TOOL_GO_TO, {}, "incomplete"),
        (Action.GO_TO, {"place": (float("nan"), 0.0, 0.0)}, "incomplete"),
        (Action.TOOL_RETRACT, {"place": PLACE}, "incomplete"),
    ],
)
async def test_an_order_that_says_too_little_or_too_much_is_refused(
    action: Action, more: dict[str, Any], code: str
) -> None:
    field = on_the_field()
    assert (await submit(field, action, **more)).code == code
    assert orders(field) == []


async def test_a_robot_that_does_not_answer_leaves_the_outcome_open() -> None:
    field = on_the_field()
    field.weeder.is_silent = True
    result = await submit(field, Action.NODE_RESTART, node="gnss")
    assert (result.outcome, result.code) == (Outcome.TIMED_OUT, "timed_out")
    field.wire.release()
    await asyncio.sleep(0)
    assert field.events_of("command")[-1]["is_late"] is True


@pytest.mark.parametrize("action", TOOL_ACTIONS)
async def test_orders_to_the_tool_need_control_and_a_machine_that_is_not_stopped(action: Action) -> None:
    field = on_the_field()
    assert (await submit(field, action, MARTHA)).is_accepted
    assert orders(field)[-1].lease_token > 0
    assert (await submit(field, action, ANNA)).code == "id_reused"
    other = CommandRequest("weeder-01", action, "other-0001", field.tick())
    assert (await field.desk.commands.submit(ANNA, other)).code == "held_by_other"
    field.weeder.press("stop-00001", "Vera Lang")
    again = CommandRequest("weeder-01", action, "again-0001", field.tick())
    assert (await field.desk.commands.submit(MARTHA, again)).code == "latched"


@pytest.mark.parametrize("action", [Action.GO_TO, Action.TOOL_GO_TO])
async def test_a_place_reaches_the_robot_as_it_was_given(action: Action) -> None:
    field = on_the_field()
    assert (await submit(field, action, MARTHA, place=PLACE)).is_accepted
    assert orders(field)[-1].place == PLACE


@pytest.mark.parametrize("action", [Action.START, Action.RETURN_HOME, Action.DRIVE_OPEN, Action.TOOL_RETRACT])
async def test_what_uses_a_function_that_is_off_is_not_sent_and_says_what_turns_it_on(action: Action) -> None:
    field = on_the_field("failure")
    result = await submit(field, action, MARTHA)
    assert (result.outcome, result.code) == (Outcome.REJECTED, "function_off")
    assert result.text.endswith("is off: Guidance failed. Restart Guidance on Supervisor.")
    assert orders(field) == []


async def test_pausing_and_aborting_work_with_every_function_off() -> None:
    field = on_the_field("failure")
    field.weeder.mode = Mode.AUTO
    assert (await submit(field, Action.PAUSE, MARTHA)).is_accepted
    assert (await submit(field, Action.ABORT, MARTHA)).is_accepted


def at_tree(field: Field, current: str) -> None:
    """Let the robot say at which of its trees it is."""
    now_s = field.clock.mono_s()
    trees = tuple(Target(f"tree-{n}", n, 0.0, "current" if f"tree-{n}" == current else "planned", "") for n in (1, 2))
    field.weeder.worksite = Worksite(1, (), (), trees, Stamp(now_s, now_s))


async def test_the_tree_that_was_shown_is_skipped_and_no_other() -> None:
    field = on_the_field()
    at_tree(field, "tree-1")
    asked = await submit(field, Action.SKIP_TARGET, target="tree-1")
    assert asked.is_accepted
    assert [one.data["about"] for one in field.audit.entries if one.kind == "command"] == ["tree-1", "tree-1"]
    at_tree(field, "tree-2")
    sent = len(orders(field))
    request = CommandRequest("weeder-01", Action.SKIP_TARGET, "skip-again-0001", field.tick(), target="tree-1")
    again = await field.desk.commands.submit(ADA, request)
    assert (again.code, again.text) == (
        "other_target",
        "Weeder 01 works at another point now. Look at it and skip again.",
    )
    assert len(orders(field)) == sent


async def test_only_skipping_names_a_target() -> None:
    field = on_the_field()
    assert (await submit(field, Action.TOOL_RETRACT, target="tree-1")).code == "incomplete"
    assert orders(field) == []


@pytest.mark.parametrize("does_know", [True, False])
async def test_a_robot_is_told_the_target_only_if_it_says_that_it_understands(does_know: bool) -> None:
    field = on_the_field()
    assert field.weeder.factsheet is not None
    field.weeder.factsheet = replace(field.weeder.factsheet, skips_by_name=does_know)
    at_tree(field, "tree-1")
    assert (await submit(field, Action.SKIP_TARGET, target="tree-1")).is_accepted
    assert orders(field)[-1].target == ("tree-1" if does_know else None)


def with_arm(field: Field) -> None:
    """Let the machine declare two joints."""
    joints = tuple(JointInfo(name, name.capitalize(), "rad", -3, 3, 0.4, None, None) for name in ("slew", "boom"))
    assert field.weeder.factsheet is not None
    field.weeder.factsheet = replace(field.weeder.factsheet, joints=joints)


def stands(field: Field, **joints: float) -> None:
    """Let the machine say now how its joints stand."""
    now_s = field.clock.mono_s()
    field.weeder.body = Body(joints, {}, {}, None, None, None, (), Stamp(now_s, now_s))


async def test_an_arm_of_which_nobody_knows_how_it_stands_is_not_sent_anywhere() -> None:
    field = on_the_field()
    with_arm(field)
    refused = await submit(field, Action.TOOL_GO_TO, MARTHA, place=PLACE)
    assert (refused.code, refused.text) == (
        "joints_unknown", "Weeder 01: Its joints were not heard. How its arm stands is not known right now."
    )  # fmt: skip
    stands(field, slew=0.1)
    asked = CommandRequest("weeder-01", Action.TOOL_GO_TO, "second-0001", field.tick(), place=PLACE)
    refused = await field.desk.commands.submit(MARTHA, asked)
    assert (refused.code, "Its joint Boom is not heard." in refused.text) == ("joints_unknown", True)
    stands(field, slew=0.1, boom=0.2)
    field.wait(2.5)
    asked = CommandRequest("weeder-01", Action.TOOL_GO_TO, "third-00001", field.tick(), place=PLACE)
    assert (await field.desk.commands.submit(MARTHA, asked)).code == "joints_unknown"
    assert (await submit(field, Action.GO_TO, MARTHA, place=PLACE)).is_accepted, "its wheels need no arm"
    stands(field, slew=0.1, boom=0.2)
    asked = CommandRequest("weeder-01", Action.TOOL_GO_TO, "fourth-0001", field.tick(), place=PLACE)
    assert (await field.desk.commands.submit(MARTHA, asked)).is_accepted
