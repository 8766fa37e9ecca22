"""Commands: what is asked before sending, what comes back, what is remembered."""

from __future__ import annotations

import asyncio
from dataclasses import replace

import pytest

from hmi.commands.service import CommandRequest
from hmi.domain.command import NODE_ACTIONS, Action, CommandOrder, Outcome
from hmi.domain.robot import Mode, OrderStatus
from hmi.domain.role import Role
from tests.hmi.commands.field import ANNA, JONAS, MARTHA, SHA, VERA, Field, Rules, mission, person

SEEN = {"mission_id": "field-1", "mission_sha256": SHA}
"""What a screen names that shows the mission of ``field.mission()``."""


def request(
    field: Field, action: Action = Action.RETURN_HOME, *, ref: str = "command-1", **more: str
) -> CommandRequest:
    """Return a command made on a fresh picture."""
    values = {"robot_id": "weeder-01", "tick_id": field.tick(), "mission_id": None, **more}
    return CommandRequest(action=action, command_id=ref, **values)  # type: ignore[arg-type]


async def test_an_accepted_command_reaches_the_robot_once_with_its_proofs() -> None:
    field = Field()
    field.weeder.mission = mission()
    result = await field.desk.commands.submit(MARTHA, request(field, Action.START, **SEEN))
    assert (result.outcome, result.code) == (Outcome.ACCEPTED, "ok")
    [order] = field.weeder.orders
    assert isinstance(order, CommandOrder)
    assert (order.challenge, order.by, order.lease_seq) == (field.weeder.challenge, "Martha Keller", 1)
    assert order.lease_token > 0
    assert (order.mission_id, order.mission_sha256, order.is_supervised) == ("field-1", SHA, True)


@pytest.mark.parametrize("action", [Action.START, Action.RESUME])
@pytest.mark.parametrize("is_supervised", [True, False])
async def test_the_robot_is_told_whether_somebody_looks_on_and_not_asked(action: Action, is_supervised: bool) -> None:
    field = Field(rules=Rules(supervised=is_supervised))
    status = OrderStatus.PAUSED if action is Action.RESUME else OrderStatus.LOADED
    field.weeder.mission = replace(mission(status=status), is_supervised=not is_supervised)
    assert (await field.desk.commands.submit(MARTHA, request(field, action, **SEEN))).is_accepted
    [order] = field.weeder.orders
    assert isinstance(order, CommandOrder)
    assert order.is_supervised is is_supervised


async def test_without_rules_of_its_own_a_console_says_that_somebody_looks_on() -> None:
    field = Field()
    field.weeder.mission = replace(mission(), is_supervised=False)
    await field.desk.commands.submit(MARTHA, request(field, Action.START, **SEEN))
    [order] = field.weeder.orders
    assert isinstance(order, CommandOrder)
    assert order.is_supervised


async def test_a_command_takes_a_free_robot_and_says_so_to_everybody() -> None:
    field = Field()
    await field.desk.commands.submit(MARTHA, request(field))
    lease = field.desk.leases.of("weeder-01")
    assert lease is not None
    assert lease.holder.user_name == "Martha Keller"
    assert field.events_of("lease")[-1]["owner"]["name"] == "Martha Keller"


async def test_a_command_never_takes_a_robot_from_its_holder() -> None:
    field = Field()
    await field.desk.commands.submit(MARTHA, request(field))
    result = await field.desk.commands.submit(JONAS, request(field, ref="command-2"))
    assert (result.outcome, result.code) == (Outcome.REJECTED, "held_by_other")
    assert result.text == "Martha Keller has control. Ask for it."
    assert field.weeder.done == ["command-1"]


@pytest.mark.parametrize("action", [Action.PAUSE, Action.ABORT])
async def test_pausing_and_aborting_need_no_lease(action: Action) -> None:
    field = Field()
    await field.desk.commands.submit(MARTHA, request(field))
    result = await field.desk.commands.submit(JONAS, request(field, action, ref="command-2"))
    assert result.is_accepted
    lease = field.desk.leases.of("weeder-01")
    assert lease is not None
    assert lease.holder.user_name == "Martha Keller"


ADMIN = person("Ada Adams", Role.ADMIN)


@pytest.mark.parametrize("action", list(Action))
async def test_a_viewer_may_command_nothing(action: Action) -> None:
    field = Field()
    result = await field.desk.commands.submit(VERA, request(field, action))
    assert (result.outcome, result.code) == (Outcome.REJECTED, "not_allowed")
    assert f"needs the {'admin' if action in NODE_ACTIONS else 'operator'} role" in result.text
    assert field.weeder.orders == []
    assert field.audit.outcomes("command") == ["rejected"]


async def test_another_farms_robot_is_out_of_reach() -> None:
    field = Field()
    stranger = person("Eve Stone", farm_id="elsewhere")
    result = await field.desk.commands.submit(stranger, request(field))
    assert result.code == "other_farm"
    assert field.weeder.orders == []


async def test_an_unregistered_robot_cannot_be_operated() -> None:
    field = Field()
    field.weeder.is_registered = False
    result = await field.desk.commands.submit(ANNA, request(field))
    assert result.code == "not_registered"
    assert field.weeder.orders == []


async def test_a_robot_nobody_heard_of_is_unknown() -> None:
    field = Field()
    result = await field.desk.commands.submit(ANNA, request(field, robot_id="weeder-99"))
    assert (result.code, result.text) == ("unknown_robot", "There is no robot weeder-99.")


@pytest.mark.parametrize("action", list(Action))
async def test_a_command_with_an_old_picture_is_refused(action: Action) -> None:
    field = Field()
    late = request(field, action)
    field.wait(2.1)
    result = await field.desk.commands.submit(ADMIN, late)
    assert (result.outcome, result.code) == (Outcome.REJECTED, "stale_tick")
    assert field.weeder.orders == []


@pytest.mark.parametrize("tick_id", ["", "console1-999999", "console0-1", "console1-1\n", "١"])
async def test_an_invented_tick_is_refused(tick_id: str) -> None:
    field = Field()
    field.tick()
    result = await field.desk.commands.submit(MARTHA, request(field, tick_id=tick_id))
    assert result.code == "stale_tick"


async def test_a_silent_robot_gets_no_command() -> None:
    field = Field()
    field.wait(12, hears=False)
    result = await field.desk.commands.submit(MARTHA, request(field, Action.PAUSE))
    assert result.code == "robot_silent"
    assert result.text == "No link to Weeder 01 for 12 s. Commands are off until the link is back."
    assert field.weeder.orders == []


@pytest.mark.parametrize("action", [Action.START, Action.RESUME])
async def test_a_mission_is_not_started_by_what_a_robot_said_of_it_long_ago(action: Action) -> None:
    field = Field()
    field.weeder.mission = mission()
    field.weeder.state_s = field.clock.mono_s()
    field.wait(2.1)  # heartbeats and safety states come, its state does not
    result = await field.desk.commands.submit(MARTHA, request(field, action))
    assert (result.code, result.text) == ("state_unknown", "What Weeder 01 is doing is not known right now.")
    assert field.weeder.orders == []
    paused = await field.desk.commands.submit(MARTHA, request(field, Action.PAUSE, ref="c-2-00000"))
    assert paused.code != "state_unknown"


@pytest.mark.parametrize("action", [Action.START, Action.RESUME, Action.RETURN_HOME, Action.DRIVE_OPEN])
async def test_nothing_moves_while_a_stop_is_latched(action: Action) -> None:
    field = Field()
    field.weeder.press("stop-0001", "Martha Keller")
    result = await field.desk.commands.submit(MARTHA, request(field, action))
    assert (result.code, result.text) == ("latched", "Reset the stop first.")
    assert field.weeder.orders == []


async def test_nothing_moves_while_the_hardware_button_is_pressed() -> None:
    field = Field()
    field.weeder.hardware_stop = True
    result = await field.desk.commands.submit(MARTHA, request(field))
    assert result.code == "hardware_stop"


async def test_a_start_names_the_mission_on_the_screen_or_is_refused() -> None:
    field = Field()
    field.weeder.mission = mission("field-2")
    result = await field.desk.commands.submit(MARTHA, request(field, Action.START, **SEEN))
    assert result.code == "wrong_mission"
    field.weeder.mission = mission("field-1", OrderStatus.NONE)
    result = await field.desk.commands.submit(MARTHA, request(field, Action.START, ref="c-2-00000", **SEEN))
    assert result.code == "wrong_mission"
    assert field.weeder.orders == []


@pytest.mark.parametrize("action", [Action.START, Action.RESUME])
async def test_a_mission_that_was_replaced_while_somebody_slid_does_not_move(action: Action) -> None:
    """Sending needs no control: another person may send a mission, or change the rest of one, at any moment."""
    field = Field()
    others = (mission("field-2"), replace(mission("field-1", OrderStatus.PAUSED), sha256="b" * 64))
    for number, held in enumerate(others):
        field.weeder.mission = held
        asked = request(field, action, ref=f"command-{number}", **SEEN)
        result = await field.desk.commands.submit(MARTHA, asked)
        assert (result.outcome, result.code) == (Outcome.REJECTED, "wrong_mission")
        assert result.text == "The mission changed while you slid. Look at it and slide again."
    assert field.weeder.orders == []


@pytest.mark.parametrize("action", [Action.START, Action.RESUME])
@pytest.mark.parametrize("named", [{}, {"mission_id": "field-1"}, {"mission_sha256": SHA}])
async def test_a_start_or_resume_that_does_not_say_of_what_is_refused(action: Action, named: dict[str, str]) -> None:
    field = Field()
    field.weeder.mission = mission(status=OrderStatus.PAUSED)
    result = await field.desk.commands.submit(MARTHA, request(field, action, **named))
    assert (result.outcome, result.code) == (Outcome.REJECTED, "incomplete")
    assert result.text == "A start or resume names mission_id and mission_sha256, as the robot reports them."
    assert field.weeder.orders == []


async def test_the_robots_refusal_comes_back_with_its_words() -> None:
    field = Field()
    field.weeder.refuse_with = ("person_ahead", "Area not clear.")
    result = await field.desk.commands.submit(MARTHA, request(field))
    assert (result.outcome, result.code, result.text) == (Outcome.REJECTED, "person_ahead", "Area not clear.")


async def test_without_a_broker_nothing_is_sent_and_nothing_kept_for_later() -> None:
    field = Field()
    field.weeder.is_deaf = True
    result = await field.desk.commands.submit(MARTHA, request(field))
    assert (result.outcome, result.code) == (Outcome.REJECTED, "not_connected")
    field.weeder.is_deaf = False
    assert field.weeder.orders == []


async def test_the_same_id_acts_once_and_answers_the_same() -> None:
    field = Field()
    asked = request(field)
    first = await field.desk.commands.submit(MARTHA, asked)
    again = await asyncio.gather(*(field.desk.commands.submit(MARTHA, asked) for _ in range(5)))
    assert set(again) == {first}
    assert len(field.weeder.orders) == 1


async def test_a_repeated_id_answers_the_same_even_when_its_tick_is_old_by_now() -> None:
    field = Field()
    asked = request(field)
    first = await field.desk.commands.submit(MARTHA, asked)
    field.wait(60)
    assert await field.desk.commands.submit(MARTHA, asked) == first
    assert len(field.weeder.orders) == 1


async def test_a_refused_id_stays_refused() -> None:
    field = Field()
    late = request(field)
    field.wait(3)
    first = await field.desk.commands.submit(MARTHA, late)
    assert await field.desk.commands.submit(MARTHA, late) == first
    assert field.weeder.orders == []


async def test_an_id_used_for_something_else_is_refused() -> None:
    field = Field()
    await field.desk.commands.submit(MARTHA, request(field))
    other_action = await field.desk.commands.submit(MARTHA, request(field, Action.PAUSE))
    other_person = await field.desk.commands.submit(JONAS, request(field))
    assert {other_action.code, other_person.code} == {"id_reused"}
    assert len(field.weeder.orders) == 1


async def test_silence_is_told_as_a_time_out_and_a_late_answer_corrects_it() -> None:
    field = Field()
    field.weeder.is_silent = True
    asked = request(field)
    result = await field.desk.commands.submit(MARTHA, asked)
    assert result.outcome is Outcome.TIMED_OUT
    assert "It may have done it" in result.text
    field.clock.advance(3)
    field.wire.release()
    event = field.events_of("command")[-1]
    assert (event["outcome"], event["is_late"], event["ms"]) == ("accepted", True, 3000)
    assert field.audit.outcomes("command") == ["pending", "timed_out", "accepted"]
    assert (await field.desk.commands.submit(MARTHA, asked)).outcome is Outcome.ACCEPTED


async def test_a_console_that_is_stopped_meanwhile_records_the_outcome_as_unknown() -> None:
    field = Field(ack_limit_s=5)
    field.weeder.is_silent = True
    waiting = asyncio.create_task(field.desk.commands.submit(MARTHA, request(field)))
    await asyncio.sleep(0)
    await field.desk.close()
    result = await waiting
    assert (result.outcome, result.code) == (Outcome.UNKNOWN, "console_stopped")


async def test_a_robot_that_rebooted_meanwhile_leaves_the_outcome_unknown() -> None:
    field = Field()
    field.weeder.is_silent = True
    waiting = asyncio.create_task(field.desk.commands.submit(MARTHA, request(field)))
    await asyncio.sleep(0)
    field.weeder.boot = "boot-0002"
    result = await waiting
    assert (result.outcome, result.code) == (Outcome.UNKNOWN, "link_lost")


async def test_a_caller_that_goes_away_does_not_take_the_outcome_with_it() -> None:
    field = Field(ack_limit_s=5)
    field.weeder.is_silent = True
    asked = request(field)
    waiting = asyncio.create_task(field.desk.commands.submit(MARTHA, asked))
    await asyncio.sleep(0)
    waiting.cancel()
    with pytest.raises(asyncio.CancelledError):
        await waiting
    field.wire.release()
    assert (await field.desk.commands.submit(MARTHA, asked)).is_accepted
    assert field.audit.outcomes("command") == ["pending", "accepted"]


async def test_answers_of_another_robot_or_kind_count_for_nothing() -> None:
    field = Field()
    field.add("weeder-02", "Weeder 02")
    field.weeder.is_silent = True
    await field.desk.commands.submit(MARTHA, request(field))
    [answer] = field.wire.held_answers
    assert not field.desk.ledger.acknowledged(replace(answer, robot_id="weeder-02"))
    assert not field.desk.ledger.acknowledged(replace(answer, kind="stop"))
    assert not field.desk.ledger.acknowledged(replace(answer, ref="never-seen"))
    assert field.audit.outcomes("command") == ["pending", "timed_out"]


async def test_too_many_open_commands_are_refused_but_a_pause_still_goes_out() -> None:
    field = Field(ack_limit_s=5)
    field.weeder.is_silent = True
    open_ones = [
        asyncio.create_task(field.desk.commands.submit(MARTHA, request(field, ref=f"command-{i}"))) for i in range(8)
    ]
    await asyncio.sleep(0)
    refused = await field.desk.commands.submit(MARTHA, request(field, ref="one-too-many"))
    assert refused.code == "busy"
    pause = asyncio.create_task(field.desk.commands.submit(MARTHA, request(field, Action.PAUSE, ref="the-pause")))
    await asyncio.sleep(0)
    assert "the-pause" in field.weeder.done
    field.wire.release()
    assert all(r.is_accepted for r in await asyncio.gather(*open_ones, pause))


async def test_every_outcome_is_audited_with_who_what_and_where() -> None:
    field = Field()
    await field.desk.commands.submit(MARTHA, request(field, Action.PAUSE))
    sent, accepted = [e for e in field.audit.entries if e.kind == "command"]
    assert (sent.outcome, accepted.outcome) == ("pending", "accepted")
    assert (accepted.actor, accepted.device, accepted.robot_id) == ("Martha Keller", "Tablet 1", "weeder-01")
    assert accepted.ref == "command-1"
    assert accepted.data is not None
    assert accepted.data["action"] == "pause"
    assert field.weeder.mode is Mode.PAUSED


async def test_a_stop_between_two_commands_ends_control_of_the_first() -> None:
    field = Field()
    await field.desk.commands.submit(MARTHA, request(field))
    token = field.desk.leases.of("weeder-01").token  # type: ignore[union-attr]
    field.weeder.press("stop-0001", "Anna Ostermeier")
    field.weeder.presses.clear()
    field.weeder.press("stop-0002", "Anna Ostermeier")
    result = await field.desk.commands.submit(JONAS, request(field, Action.DRIVE_CLOSE, ref="command-2"))
    assert result.is_accepted
    lease = field.desk.leases.of("weeder-01")
    assert lease is not None
    assert lease.token > token
    assert lease.holder.user_name == "Jonas Weber"


async def test_a_start_without_a_mission_on_the_robot_says_what_to_do() -> None:
    field = Field()
    result = await field.desk.commands.submit(MARTHA, request(field, Action.START, mission_id="field-1"))
    assert (result.code, result.text) == ("wrong_mission", "Weeder 01 has no mission. Send this one first.")
