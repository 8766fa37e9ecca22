"""Control in use: rights, ticks, STOP, sign-out, and what everybody hears."""

from __future__ import annotations

from hmi.commands.lease_service import LeaseOp, LeaseResult
from hmi.commands.ledger import CommandResult
from hmi.commands.service import CommandRequest
from hmi.domain.command import Action
from hmi.domain.lease import ASK_TTL_S
from hmi.security.session_info import SessionInfo
from tests.hmi.commands.field import ANNA, JONAS, MARTHA, VERA, Field


def operate(
    field: Field, actor: SessionInfo, op: LeaseOp, reason: str = "", to: SessionInfo | None = None
) -> LeaseResult:
    """Do a lease operation on a fresh picture."""
    to_session = to.session_id if to is not None else None
    return field.desk.leases.operate(actor, "weeder-01", op, tick_id=field.tick(), reason=reason, to_session=to_session)


def owner(field: Field) -> str | None:
    """Return who has control."""
    lease = field.desk.leases.of("weeder-01")
    return lease.holder.user_name if lease is not None else None


async def home(field: Field, command_id: str) -> CommandResult:
    """Let Martha send the weeder home, which takes control if nobody has it."""
    asked = CommandRequest("weeder-01", Action.RETURN_HOME, command_id, field.tick())
    return await field.desk.commands.submit(MARTHA, asked)


def test_control_is_asked_for_and_given() -> None:
    field = Field()
    assert operate(field, MARTHA, LeaseOp.REQUEST).is_granted
    asked = operate(field, JONAS, LeaseOp.REQUEST)
    assert (asked.is_granted, asked.text) == (False, "Asked Martha Keller for control of Weeder 01.")
    assert field.events_of("lease")[-1]["asked"][0]["name"] == "Jonas Weber"
    assert operate(field, MARTHA, LeaseOp.GRANT, to=JONAS).is_granted
    assert owner(field) == "Jonas Weber"
    assert field.events_of("lease")[-1]["text"] == "Jonas Weber has control of Weeder 01."


def test_nobody_is_given_control_that_signed_out_meanwhile() -> None:
    field = Field()
    operate(field, MARTHA, LeaseOp.REQUEST)
    operate(field, JONAS, LeaseOp.REQUEST)
    field.signed_out.add(JONAS.session_id)
    answer = operate(field, MARTHA, LeaseOp.GRANT)
    assert (answer.is_granted, answer.code) == (False, "nobody_asks")
    assert owner(field) == "Martha Keller"


def test_a_supervisor_takes_control_with_a_reason_and_an_operator_does_not() -> None:
    field = Field()
    operate(field, MARTHA, LeaseOp.REQUEST)
    assert operate(field, JONAS, LeaseOp.TAKE, "I want it").code == "not_allowed"
    assert operate(field, ANNA, LeaseOp.TAKE, "  ").code == "reason_missing"
    assert operate(field, ANNA, LeaseOp.TAKE, "Person in the field").is_granted
    assert owner(field) == "Anna Ostermeier"
    taken = [e for e in field.audit.entries if e.data is not None and e.data.get("op") == "take"]
    assert [e.outcome for e in taken] == ["not_allowed", "reason_missing", "granted"]
    assert taken[-1].data == {"op": "take", "reason": "Person in the field"}


def test_a_viewer_cannot_have_control() -> None:
    field = Field()
    answer = operate(field, VERA, LeaseOp.REQUEST)
    assert (answer.code, owner(field)) == ("not_allowed", None)


def test_an_old_picture_gives_nobody_control_but_never_keeps_one_from_giving_it_back() -> None:
    field = Field()
    old = field.tick()
    field.wait(2.5)
    leases = field.desk.leases
    assert leases.operate(MARTHA, "weeder-01", LeaseOp.REQUEST, tick_id=old).code == "stale_tick"
    operate(field, MARTHA, LeaseOp.REQUEST)
    assert leases.operate(MARTHA, "weeder-01", LeaseOp.RELEASE, tick_id=old).is_granted
    assert owner(field) is None


async def test_a_page_that_falls_silent_loses_control_and_everybody_hears_it() -> None:
    field = Field()
    operate(field, MARTHA, LeaseOp.REQUEST)
    field.wait(10.1)
    await field.desk.tend()
    event = field.events_of("lease")[-1]
    assert (event["op"], event["owner"]) == ("expired", None)
    assert event["text"] == "Martha Keller lost control: no sign of life from the page for 10 s."
    assert [e.outcome for e in field.audit.entries][-1] == "expired"


async def test_a_question_nobody_answers_goes_away() -> None:
    field = Field()
    operate(field, MARTHA, LeaseOp.REQUEST)
    operate(field, JONAS, LeaseOp.REQUEST)
    for _ in range(int(ASK_TTL_S) + 1):
        field.wait(1.0)
        field.desk.pulse.here(MARTHA, "weeder-01", field.tick())
    await field.desk.tend()
    event = field.events_of("lease")[-1]
    assert (event["op"], event["asked"], event["owner"]["name"]) == ("unanswered", [], "Martha Keller")


def test_a_stop_of_anybody_ends_control_once() -> None:
    field = Field()
    operate(field, MARTHA, LeaseOp.REQUEST)
    field.weeder.press("stop-00001", "Vera Lang")
    field.desk.leases.observe(field.weeder.known())
    assert owner(field) is None
    assert field.events_of("lease")[-1]["text"] == "STOP by Vera Lang ended the control of Martha Keller."
    operate(field, MARTHA, LeaseOp.REQUEST)
    field.desk.leases.observe(field.weeder.known())
    assert owner(field) == "Martha Keller"
    field.weeder.press("stop-00002", "Vera Lang")
    field.desk.leases.observe(field.weeder.known())
    assert owner(field) is None


def test_a_stop_by_the_second_path_ends_control_before_the_robot_says_so() -> None:
    field = Field()
    operate(field, MARTHA, LeaseOp.REQUEST)
    field.desk.leases.stopped("weeder-01", "stop-00001", "Jonas Weber")
    assert owner(field) is None
    operate(field, MARTHA, LeaseOp.REQUEST)
    field.weeder.press("stop-00001", "Jonas Weber")
    field.desk.leases.observe(field.weeder.known())
    assert owner(field) == "Martha Keller"


def test_the_button_on_the_machine_ends_control_once_and_leaves_what_was_taken_after_it() -> None:
    field = Field()
    operate(field, MARTHA, LeaseOp.REQUEST)
    field.weeder.push_button()
    field.desk.leases.observe(field.weeder.known())
    assert owner(field) is None
    told = field.events_of("lease")[-1]
    assert told["op"] == "revoked"
    assert told["text"] == "The red button on the machine ended the control of Martha Keller."
    operate(field, MARTHA, LeaseOp.REQUEST)
    field.desk.leases.observe(field.weeder.known())
    field.weeder.hardware_stop = False
    field.desk.leases.observe(field.weeder.known())
    assert owner(field) == "Martha Keller"
    field.weeder.push_button()
    field.desk.leases.observe(field.weeder.known())
    assert owner(field) is None


async def test_control_that_the_robot_says_is_over_ends_here_too_and_is_taken_anew() -> None:
    field = Field(ack_limit_s=1.0)
    assert (await home(field, "home-0001")).is_accepted
    field.weeder.push_button()
    field.weeder.hardware_stop = False  # pressed and released while the radio was gone: nobody told the console
    assert (await home(field, "home-0002")).code == "lease_revoked"
    assert owner(field) is None
    assert field.events_of("lease")[-1]["text"] == "A STOP ended the control of Martha Keller."
    assert (await home(field, "home-0003")).is_accepted
    assert owner(field) == "Martha Keller"


async def test_a_late_word_about_old_control_leaves_the_new_one() -> None:
    field = Field()
    await home(field, "home-0001")
    field.weeder.push_button()
    field.weeder.hardware_stop = False
    field.weeder.is_silent = True
    await home(field, "home-0002")
    operate(field, MARTHA, LeaseOp.RELEASE)
    operate(field, JONAS, LeaseOp.REQUEST)
    assert [one.code for one in field.wire.held_answers] == ["lease_revoked"]
    field.desk.ledger.acknowledged(field.wire.held_answers[0])
    assert owner(field) == "Jonas Weber"


def test_signing_out_gives_control_back() -> None:
    field = Field()
    operate(field, MARTHA, LeaseOp.REQUEST)
    field.desk.leases.end_session(MARTHA.session_id)
    assert owner(field) is None
    assert "signed out" in field.events_of("lease")[-1]["text"]


async def test_half_used_tokens_bring_a_new_epoch() -> None:
    field = Field()
    first = operate(field, MARTHA, LeaseOp.REQUEST).lease
    field.desk.leases._book._grants = 1 << 19  # half a million grants take too long here
    await field.desk.tend()
    taken = operate(field, ANNA, LeaseOp.TAKE, "needed").lease
    assert first is not None
    assert taken is not None
    assert (first.token >> 20, taken.token >> 20) == (1, 2)
