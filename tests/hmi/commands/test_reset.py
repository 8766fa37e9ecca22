"""Resetting a STOP: standing, agreed, with a reason; and it moves nothing."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hmi.commands.ledger import CommandResult
from hmi.commands.reset import ResetRequest
from hmi.domain.command import Outcome, ResetOrder
from hmi.domain.robot import Mode, Robot
from hmi.security.session_info import SessionInfo
from tests.hmi.commands.field import ANNA, JONAS, MARTHA, VERA, Field, person

ONE, TWO = "stop-000001", "stop-000002"


def stopped(*presses: tuple[str, str]) -> Field:
    """Return a field whose weeder was stopped."""
    field = Field()
    for stop_id, by in presses:
        field.weeder.press(stop_id, by)
        field.pressers[stop_id] = {person(by).user_id}
    return field


async def reset(
    field: Field, actor: SessionInfo, *stop_ids: str, reason: str = "Person", ref: str = "reset-00001", tick: str = ""
) -> CommandResult:
    """Ask for a reset on a fresh picture."""
    return await field.desk.resets.reset(actor, ResetRequest("weeder-01", ref, stop_ids, reason, tick or field.tick()))


async def test_who_pressed_resets_and_the_robot_stays_paused() -> None:
    field = stopped((ONE, "Martha Keller"))
    result = await reset(field, MARTHA, ONE)
    assert (result.outcome, result.text) == (Outcome.ACCEPTED, "")
    assert not field.weeder.is_latched
    assert (field.weeder.mode, field.weeder.v_mps) == (Mode.PAUSED, 0.0)
    [order] = field.weeder.orders
    assert isinstance(order, ResetOrder)
    assert (order.stop_ids, order.reason, order.by) == ((ONE,), "Person", "Martha Keller")
    assert field.audit.outcomes("stop-reset") == ["pending", "accepted"]


async def test_the_press_of_somebody_else_is_theirs_to_reset() -> None:
    field = stopped((ONE, "Anna Ostermeier"))
    result = await reset(field, MARTHA, ONE)
    assert (result.outcome, result.code) == (Outcome.REJECTED, "other_press")
    assert result.text == "Anna Ostermeier also pressed STOP. They must reset theirs."
    assert field.weeder.orders == []


async def test_after_ones_own_reset_one_is_told_who_else_must() -> None:
    field = stopped((ONE, "Martha Keller"), (TWO, "Jonas Weber"))
    result = await reset(field, MARTHA, ONE)
    assert result.is_accepted
    assert result.text == "Jonas Weber also pressed STOP. They must reset theirs."
    assert field.weeder.is_latched
    field.desk.leases.end_session(MARTHA.session_id)
    last = await reset(field, JONAS, TWO, ref="reset-00002")
    assert (last.is_accepted, last.text) == (True, "")
    assert not field.weeder.is_latched


async def test_a_supervisor_resets_for_everybody() -> None:
    field = stopped((ONE, "Martha Keller"), (TWO, "Jonas Weber"))
    result = await reset(field, ANNA, ONE, TWO, reason="Both went home")
    assert result.is_accepted
    assert not field.weeder.is_latched


async def test_a_press_on_a_tablet_nobody_was_signed_in_at_is_anybodys() -> None:
    field = Field()
    field.weeder.press(ONE, "Tablet 3", "Tablet 3")
    field.pressers[ONE] = {""}
    assert (await reset(field, MARTHA, ONE)).is_accepted


@pytest.mark.parametrize("users", [{"martha-2"}, {"", "martha"}, set()], ids=["namesake", "disputed", "unknown"])
async def test_a_shared_name_is_not_the_person_who_pressed(users: set[str]) -> None:
    field = stopped((ONE, "Martha Keller"))
    field.pressers[ONE] = users
    result = await reset(field, MARTHA, ONE)
    assert (result.outcome, result.code) == (Outcome.REJECTED, "other_press")
    assert "Ask a supervisor." in result.text
    assert field.weeder.orders == []
    assert (await reset(field, ANNA, ONE, ref="reset-00002")).is_accepted


async def test_an_account_named_like_the_tablet_does_not_make_its_stop_anybodys() -> None:
    field = Field()
    field.weeder.press(ONE, "Tablet 3", "Tablet 3")
    field.pressers[ONE] = {"tablet-3-account"}
    assert (await reset(field, MARTHA, ONE)).code == "other_press"


async def test_who_was_renamed_still_resets_their_own() -> None:
    field = stopped((ONE, "Martha Keller"))
    renamed = replace(MARTHA, user_name="Martha Vogel")
    assert (await reset(field, renamed, ONE)).is_accepted


async def test_a_viewer_may_stop_but_not_reset() -> None:
    field = stopped((ONE, "Vera Lang"))
    assert (await reset(field, VERA, ONE)).code == "not_allowed"
    assert field.weeder.orders == []


async def test_a_robot_that_is_not_known_to_stand_is_not_reset() -> None:
    field = stopped((ONE, "Martha Keller"))
    field.weeder.speed_mps = 0.1
    assert (await reset(field, MARTHA, ONE)).code == "not_standing"
    field.weeder.speed_mps = 0.0
    field.wait(2.1, hears=False)
    assert (await reset(field, MARTHA, ONE, ref="reset-00002")).code == "robot_silent"
    assert field.weeder.orders == []


@pytest.mark.parametrize("word", [{"tool_off": False}, {"speed_mps": 0.2}])
async def test_a_robot_that_contradicts_its_standstill_is_not_reset(
    word: dict[str, object], monkeypatch: pytest.MonkeyPatch
) -> None:
    field = stopped((ONE, "Martha Keller"))
    told = field.weeder.known

    def contradicts() -> Robot:
        robot = told()
        assert robot.safety is not None
        assert robot.safety.standstill
        return replace(robot, safety=replace(robot.safety, **word))

    monkeypatch.setattr(field.weeder, "known", contradicts)
    assert (await reset(field, MARTHA, ONE)).code == "not_standing"
    assert field.weeder.orders == []


async def test_the_button_on_the_machine_goes_first() -> None:
    field = stopped((ONE, "Martha Keller"))
    field.weeder.hardware_stop = True
    result = await reset(field, MARTHA, ONE)
    assert result.text == "Hardware button is pressed on the machine. Release it there first."


async def test_a_reset_needs_a_reason_and_a_fresh_picture() -> None:
    field = stopped((ONE, "Martha Keller"))
    assert (await reset(field, MARTHA, ONE, reason="   ")).code == "reason_missing"
    old = field.tick()
    field.wait(2.1)
    assert (await reset(field, MARTHA, ONE, ref="reset-00002", tick=old)).code == "stale_tick"
    assert field.weeder.orders == []


async def test_a_press_that_is_newer_than_the_picture_is_not_reset() -> None:
    field = stopped((ONE, "Martha Keller"))
    seen = field.tick()
    field.wait(0.3)
    field.weeder.press(TWO, "", "Tablet 3")
    result = await reset(field, MARTHA, ONE, TWO, tick=seen)
    assert (result.outcome, result.code) == (Outcome.REJECTED, "new_press")
    assert result.text == "STOP was pressed again. Look at it, then reset again."
    assert field.weeder.orders == []


async def test_what_is_not_latched_cannot_be_reset() -> None:
    field = stopped((ONE, "Martha Keller"))
    assert (await reset(field, MARTHA, "stop-999999")).code == "nothing_to_reset"


async def test_a_reset_needs_control_and_takes_it_only_when_free() -> None:
    field = stopped((ONE, "Martha Keller"), (TWO, "Jonas Weber"))
    assert (await reset(field, JONAS, TWO)).is_accepted
    result = await reset(field, MARTHA, ONE, ref="reset-00002")
    assert (result.code, result.text) == ("held_by_other", "Jonas Weber has control. Ask for it.")


async def test_a_stop_after_the_reset_was_asked_for_stands() -> None:
    field = stopped((ONE, "Martha Keller"))
    field.weeder.is_silent = True
    result = await reset(field, MARTHA, ONE)
    assert result.outcome is Outcome.TIMED_OUT
    field.weeder.press(TWO, "Jonas Weber")
    again = await reset(field, MARTHA, ONE)
    assert again == result
    assert field.weeder.is_latched


async def test_the_same_reset_twice_is_one() -> None:
    field = stopped((ONE, "Martha Keller"))
    request = ResetRequest("weeder-01", "reset-00001", (ONE,), "Test", field.tick())
    first = await field.desk.resets.reset(MARTHA, request)
    assert await field.desk.resets.reset(MARTHA, request) == first
    assert len(field.weeder.orders) == 1


async def test_a_namesake_on_another_farm_resets_nothing() -> None:
    field = stopped((ONE, "Martha Keller"))
    other = person("Martha Keller", farm_id="elsewhere")
    assert (await reset(field, other, ONE)).code == "other_farm"
