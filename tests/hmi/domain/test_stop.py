"""What one STOP press at one robot may claim."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hmi.domain.stop import SafetyReport, StopAnswer, StopAttempt, StopState, StopTarget

T0 = 1000.0
UTC0 = datetime(2026, 5, 4, 14, 36, 40, 900_000, tzinfo=UTC)
TARGET = StopTarget("weeder-07", "Weeder 07", decel_mps2=2.0)
STOP_ID = "a" * 32
ACCEPTED = StopAnswer(True, boot="boot-one", at_s=50.0)


def pressed(speed_mps: float | None = None, target: StopTarget = TARGET) -> StopAttempt:
    return StopAttempt.press(STOP_ID, target, "Martha", "Tablet 3", now_s=T0, utc=UTC0, speed_mps=speed_mps)


def report(**changes: Any) -> SafetyReport:
    fields: dict[str, Any] = {
        "boot": "boot-one", "at_s": 51.0, "latched": True, "standstill": True, "tool_off": True,
        "hardware_stop": False, "speed_mps": 0.0, "live": frozenset({STOP_ID}),
    }  # fmt: skip
    return SafetyReport(**{**fields, **changes})


def confirmed() -> StopAttempt:
    return pressed().answered(T0 + 0.2, ACCEPTED).reported(T0 + 1.0, report())


def test_a_press_goes_from_sent_to_acknowledged_to_standstill() -> None:
    attempt = pressed().sent(T0, by_mqtt=True)
    assert attempt.state is StopState.SENT
    attempt = attempt.answered(T0 + 0.18, ACCEPTED)
    assert attempt.state is StopState.ACKNOWLEDGED
    attempt = attempt.reported(T0 + 1.34, report(stopping_distance_m=0.31))
    assert attempt.state is StopState.STANDSTILL
    step = attempt.step(T0 + 1.4)
    assert (step["sent_ms"], step["ack_ms"], step["standstill_ms"], step["age_ms"]) == (0, 180, 1340, 1400)
    assert step["pressed_utc"] == "2026-05-04T14:36:40.900Z"
    assert step["stopping_distance_m"] == 0.31


def test_no_acknowledgement_within_a_second_is_not_confirmed() -> None:
    assert pressed(5.0).at(T0 + 0.999).state is StopState.SENT
    late = pressed(5.0).at(T0 + 1.0)
    assert late.state is StopState.NOT_CONFIRMED
    assert late.text == "No acknowledgement within 1.0 s."


@pytest.mark.parametrize(
    ("speed_mps", "limit_s"), [(0.0, 1.0), (1.0, 1.5), (2.0, 2.0), (40.0, 3.0), (None, 3.0), (float("nan"), 3.0)]
)
def test_standstill_may_take_as_long_as_braking_and_a_second_but_never_over_three(
    speed_mps: float | None, limit_s: float
) -> None:
    acked = pressed(speed_mps).answered(T0 + 0.1, ACCEPTED)
    assert acked.at(T0 + limit_s - 0.001).state is StopState.ACKNOWLEDGED
    assert acked.at(T0 + limit_s).state is StopState.NOT_CONFIRMED


@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf"), 99.0])
def test_limits_can_be_made_stricter_but_never_longer_and_never_off(value: float) -> None:
    target = StopTarget("r", "R", None, value, value)
    assert (target.ack_limit_s, target.standstill_limit_s) == (1.0, 3.0)
    assert StopTarget("r", "R", None, 0.5, 2.0).ack_limit_s == 0.5


def test_a_robot_without_deceleration_gets_the_whole_limit() -> None:
    for decel in (None, 0.0, -1.0, float("nan")):
        assert StopTarget("r", "R", decel).braking_limit_s(1.0) == 3.0


def test_a_late_confirmation_still_counts() -> None:
    late = pressed().at(T0 + 5).answered(T0 + 6, ACCEPTED)
    assert late.state is StopState.NOT_CONFIRMED
    assert late.reported(T0 + 7, report()).state is StopState.STANDSTILL


def test_a_standstill_from_before_the_press_proves_nothing() -> None:
    old = report(at_s=49.9, live=frozenset())
    assert pressed().reported(T0 + 0.1, old).state is StopState.SENT
    assert pressed().answered(T0 + 0.1, ACCEPTED).reported(T0 + 0.2, old).state is StopState.ACKNOWLEDGED
    other_boot = report(boot="boot-two", at_s=60.0, live=frozenset())
    assert pressed().answered(T0 + 0.1, ACCEPTED).reported(T0 + 0.2, other_boot).state is StopState.ACKNOWLEDGED


def test_a_report_that_lists_the_press_is_as_good_as_the_lost_acknowledgement() -> None:
    moving = report(standstill=False, speed_mps=0.4)
    attempt = pressed().reported(T0 + 0.3, moving)
    assert attempt.state is StopState.ACKNOWLEDGED
    assert attempt.step(T0 + 0.3)["speed_mps"] == 0.4


@pytest.mark.parametrize(
    "changes", [{"latched": False}, {"standstill": False}, {"tool_off": False}, {"speed_mps": 0.2}]
)
def test_standstill_needs_latch_zero_motion_and_tool_off(changes: dict[str, Any]) -> None:
    acked = pressed().answered(T0 + 0.1, ACCEPTED)
    assert acked.reported(T0 + 0.5, report(**changes)).state is StopState.ACKNOWLEDGED


def test_moving_after_it_confirmed_is_not_confirmed_and_copies_go_out_at_once() -> None:
    moving = confirmed().reported(T0 + 20, report(standstill=False, speed_mps=0.3))
    assert moving.state is StopState.NOT_CONFIRMED
    assert moving.is_due(T0 + 20)
    assert moving.step(T0 + 20)["standstill_ms"] is None
    assert moving.sent(T0 + 20, by_mqtt=True).next_send_s == pytest.approx(T0 + 20.2)
    assert moving.reported(T0 + 21, report(at_s=60.0)).state is StopState.STANDSTILL


def test_a_latch_that_is_gone_asks_the_robot_once_more_before_anything_is_claimed() -> None:
    gone = confirmed().reported(T0 + 20, report(latched=False, live=frozenset()))
    assert gone.state is StopState.STANDSTILL
    assert gone.is_due(T0 + 20)
    answered = gone.answered(T0 + 20.1, StopAnswer(False, "already_reset", "It was reset."))
    assert answered.state is StopState.RESET
    assert gone.at(T0 + 21).state is StopState.NOT_CONFIRMED
    back = gone.reported(T0 + 20.2, report(at_s=70.0))
    assert back.at(T0 + 30).state is StopState.STANDSTILL


@pytest.mark.parametrize("code", ["already_reset", "already-reset"])
@pytest.mark.parametrize("is_accepted", [True, False])
def test_already_reset_empties_it_whatever_the_outcome_says(code: str, *, is_accepted: bool) -> None:
    attempt = pressed().answered(T0 + 0.1, StopAnswer(is_accepted, code))
    assert attempt.state is StopState.RESET
    assert not attempt.is_due(T0 + 100)


def test_a_press_that_the_robot_lists_as_reset_is_over_although_others_are_not() -> None:
    other = report(live=frozenset({"b" * 32}), reset=frozenset({STOP_ID}))
    assert confirmed().reported(T0 + 9, other).state is StopState.RESET


def test_a_refusal_is_no_acknowledgement_and_its_sentence_is_kept() -> None:
    refused = pressed().answered(T0 + 0.1, StopAnswer(False, "bad_token", "Wrong token."))
    assert refused.state is StopState.SENT
    assert refused.is_due(T0 + 0.2)
    assert refused.at(T0 + 1).text == "Wrong token."


def test_a_hardware_stop_is_said_beside_the_confirmation() -> None:
    attempt = pressed().reported(T0 + 0.5, report(hardware_stop=True))
    assert attempt.state is StopState.STANDSTILL
    assert "Hardware button" in attempt.text


def test_copies_go_at_five_hertz_for_ten_seconds_then_every_second_for_ever() -> None:
    attempt, sent_at = pressed(), []
    for n in range(6000):
        now_s = T0 + n * 0.01
        attempt = attempt.at(now_s)
        if attempt.is_due(now_s):
            attempt = attempt.sent(now_s, by_mqtt=True)
            sent_at.append(now_s - T0)
    early = [t for t in sent_at if t < 10]
    assert 47 <= len(early) <= 51
    assert 49 <= len(sent_at) - len(early) <= 51


def test_a_robot_that_returns_gets_the_stop_at_once_and_at_five_hertz_again() -> None:
    tired = pressed().sent(T0 + 100, by_mqtt=True)
    assert not tired.is_due(T0 + 100.5)
    back = tired.returned(T0 + 100.5)
    assert back.is_due(T0 + 100.5)
    assert back.sent(T0 + 100.5, by_mqtt=True).is_due(T0 + 100.71)
    assert not confirmed().returned(T0 + 9).is_due(T0 + 9)


def test_pressing_again_sends_again_in_every_state_but_reset() -> None:
    reset = confirmed().answered(T0 + 2, StopAnswer(True, "already_reset"))
    assert confirmed().pressed_again(T0 + 5).is_due(T0 + 5)
    assert not confirmed().pressed_again(T0 + 5).sent(T0 + 5, by_mqtt=True).is_due(T0 + 99)
    assert pressed().sent(T0, by_mqtt=True).pressed_again(T0 + 0.05).is_due(T0 + 0.05)
    assert not reset.pressed_again(T0 + 5).is_due(T0 + 5)


def test_a_copy_by_http_counts_when_the_robot_answered_it() -> None:
    attempt = pressed().sent(T0, by_mqtt=False)
    assert attempt.step(T0)["sent_ms"] is None
    step = attempt.carried_by_http(T0).step(T0 + 0.1)
    assert step["sent_ms"] == 0
    assert step["paths"] == {"mqtt": 0, "http": 1}


answers = st.builds(
    StopAnswer,
    st.booleans(),
    st.sampled_from(["ok", "busy", "already_reset"]),
    speed_mps=st.none() | st.floats(0, 5),
    boot=st.sampled_from(["boot-one", "boot-two"]),
    at_s=st.none() | st.floats(0, 100),
)
reports = st.builds(
    report,
    boot=st.sampled_from(["boot-one", "boot-two"]),
    at_s=st.floats(0, 100),
    latched=st.booleans(),
    standstill=st.booleans(),
    tool_off=st.booleans(),
    speed_mps=st.sampled_from([0.0, 0.01, 0.5]),
    live=st.sampled_from([frozenset(), frozenset({STOP_ID}), frozenset({"other-press"})]),
    reset=st.sampled_from([frozenset(), frozenset(), frozenset({STOP_ID})]),
)
events = st.lists(
    st.one_of(
        st.tuples(st.just("wait"), st.floats(0.01, 3)),
        st.tuples(st.just("answer"), answers),
        st.tuples(st.just("report"), reports),
        st.tuples(st.sampled_from(["return", "again"]), st.none()),
    ),
    max_size=40,
)


def apply(attempt: StopAttempt, event: tuple[str, Any], now_s: float) -> StopAttempt:
    kind, value = event
    match kind:
        case "answer":
            return attempt.answered(now_s, value)
        case "report":
            return attempt.reported(now_s, value)
        case "return":
            return attempt.returned(now_s)
        case "again":
            return attempt.pressed_again(now_s)
    return attempt.at(now_s)


@pytest.mark.slow
@settings(max_examples=200)
@given(st.none() | st.floats(0, 10), events)
def test_no_story_makes_it_claim_more_than_the_robot_said(
    speed_mps: float | None, story: list[tuple[str, Any]]
) -> None:
    attempt, now_s = pressed(speed_mps), T0
    for event in story:
        now_s += event[1] if event[0] == "wait" else 0.0
        before, attempt = attempt.at(now_s), apply(attempt, event, now_s).at(now_s)
        if attempt.state is StopState.STANDSTILL and before.state is not StopState.STANDSTILL:
            assert event[0] == "report"
            assert event[1].latched
            assert event[1].is_standing
        if before.state is StopState.NOT_CONFIRMED:
            assert attempt.state in (StopState.NOT_CONFIRMED, StopState.STANDSTILL, StopState.RESET)
        if before.state is StopState.RESET:
            assert attempt.state is StopState.RESET
        if before.state is StopState.STANDSTILL and event[0] == "report" and not event[1].is_standing:
            assert attempt.state in (StopState.NOT_CONFIRMED, StopState.RESET)
        if now_s >= T0 + 3.0:
            assert attempt.state not in (StopState.SENT, StopState.ACKNOWLEDGED)
        if attempt.ack_s is None and now_s >= T0 + 1.0:
            assert attempt.state is not StopState.SENT
        if attempt.is_due(now_s):
            attempt = attempt.sent(now_s, by_mqtt=True)
        if attempt.wants_sending:
            assert now_s < attempt.next_send_s <= now_s + 1.0


@given(st.floats(0, 10), st.floats(0, 10), st.none() | st.floats(0, 10))
def test_how_often_time_is_looked_at_changes_nothing(first: float, second: float, speed_mps: float | None) -> None:
    for attempt in (pressed(speed_mps), pressed(speed_mps).answered(T0 + 0.01, ACCEPTED), confirmed()):
        end = T0 + 0.01 + first + second
        assert attempt.at(T0 + 0.01 + first).at(end).state is attempt.at(end).state
