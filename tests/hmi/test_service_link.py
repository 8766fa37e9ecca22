"""The link to a service: its states, when it is asked again, and the words for them."""

from __future__ import annotations

import pytest

from backend_clients.service import errors
from hmi.clock import FakeClock
from hmi.presenters.services import HEADS, service_words
from hmi.service_link import BAD_ANSWERS, LATE_PAUSE_S, LinkState, ServiceLink


def test_every_state_has_words_for_both_services() -> None:
    assert set(HEADS) == {state.value for state in LinkState} - {"off", "other_tenant", "other_console"}
    for state in {LinkState(key) for key in HEADS} | {LinkState.OFF}:
        for key in ("planner", "forecast"):
            words = service_words(key, state.value)
            assert words.level in ("ok", "watch", "bad")
            assert words.text.endswith(".")


@pytest.mark.parametrize(
    ("error", "state"),
    [
        (errors.Untrusted("x"), LinkState.UNTRUSTED),
        (errors.NoAnswer("x"), LinkState.SILENT),
        (errors.Unreachable("x"), LinkState.UNREACHABLE),
        (errors.NotAllowed(403, ""), LinkState.REFUSED),
        (errors.Busy(429, ""), LinkState.BUSY),
        (errors.ServiceFailed(500, ""), LinkState.FAILING),
        (errors.Unreadable("x"), LinkState.NOT_UNDERSTOOD),
    ],
)
def test_a_failure_is_a_state_with_what_mends_it_and_a_pause(error: errors.ServiceError, state: LinkState) -> None:
    clock = FakeClock()
    link = ServiceLink(clock, jitter=1.0)
    link.failed(error)
    assert (link.state, link.may_ask, bool(link.mend)) == (state, False, True)
    assert link.is_away
    clock.advance(link.again_in_s)
    assert link.may_ask
    link.well(0.2)
    assert (link.is_well, link.is_away, link.why, link.last_error is not None) == (True, False, "", True)


def test_a_service_that_nobody_asked_yet_is_not_said_to_be_away() -> None:
    assert not ServiceLink(FakeClock()).is_away


def test_answers_that_cannot_be_used_count_when_they_come_again_and_again() -> None:
    link = ServiceLink(FakeClock())
    link.well(0.1)
    for _ in range(BAD_ANSWERS - 1):
        link.bad_work(errors.Unreadable("nonsense"))
        assert (link.may_ask, link.is_well) == (True, True)
    link.bad_work(errors.Unreadable("nonsense"))
    assert (link.may_ask, link.state) == (False, LinkState.NOT_UNDERSTOOD)
    link.well(0.1)  # that it is there
    assert (link.may_ask, link.state) == (True, LinkState.NOT_UNDERSTOOD)
    link.worked(2.0)
    assert link.is_well


def test_a_busy_service_is_left_alone_as_long_as_it_asks_for() -> None:
    clock = FakeClock()
    link, error = ServiceLink(clock, jitter=1.0), errors.Busy(429, "")
    error.retry_after_s = 120.0
    link.failed(error)
    assert link.again_in_s == pytest.approx(120.0)


def test_work_that_came_too_late_lets_nobody_wait_for_a_minute_and_is_no_lost_link() -> None:
    clock = FakeClock()
    link = ServiceLink(clock)
    link.late(errors.ServiceError("it had no plan after 30 s"))
    assert (link.is_well, link.may_ask) == (True, False)
    clock.advance(LATE_PAUSE_S)
    assert link.may_ask
