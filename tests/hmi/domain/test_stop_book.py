"""All open presses together."""

from __future__ import annotations

from datetime import UTC, datetime
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmi.domain.freshness import LOST_S
from hmi.domain.stop import SafetyReport, StopAnswer, StopAttempt, StopState, StopTarget
from hmi.domain.stop_book import MAX_OPEN_PER_ROBOT, MAX_STRANGERS, STRANGER_S, ReportOrder, StopBook

T0 = 1000.0
UTC0 = datetime(2026, 5, 4, tzinfo=UTC)
ROBOTS = {name: StopTarget(name, name.title(), 2.0) for name in ("weeder-01", "weeder-02")}


def press(book: StopBook, stop_id: str, robot: str = "weeder-01", now_s: float = T0) -> StopAttempt:
    return book.press(stop_id, ROBOTS[robot], "Martha", "Tablet 3", now_s=now_s, utc=UTC0)


def standing(at_s: float, *live: str, boot: str = "boot-one") -> SafetyReport:
    return SafetyReport(boot, at_s, bool(live), True, True, False, 0.0, frozenset(live))


def test_the_same_press_again_is_one_press_that_is_due_again() -> None:
    book = StopBook()
    book.sent(press(book, "press-one"), T0, by_mqtt=True)
    assert not book.due(T0 + 0.1)
    press(book, "press-one", now_s=T0 + 0.1)
    assert len(book) == 1
    assert [a.stop_id for a in book.due(T0 + 0.1)] == ["press-one"]


def test_one_report_confirms_every_press_that_the_robot_holds_and_no_other_robot() -> None:
    book = StopBook()
    for stop_id in ("press-one", "press-two"):
        press(book, stop_id)
    press(book, "press-one", "weeder-02")
    changed = book.reported("weeder-01", standing(5.0, "press-one", "press-two"), T0 + 0.5)
    assert {a.stop_id for a in changed} == {"press-one", "press-two"}
    assert [s["state"] for s in book.steps(T0 + 0.5, "press-one")] == ["standstill", "sent"]


def test_a_report_that_comes_late_by_another_path_changes_nothing() -> None:
    book = StopBook()
    press(book, "press-one")
    book.reported("weeder-01", standing(5.0, "press-one"), T0 + 0.5)
    moving = SafetyReport("boot-one", 4.0, True, False, True, False, 0.5, frozenset({"press-one"}))
    assert not book.reported("weeder-01", moving, T0 + 0.6)


def moving(at_s: float, boot: str = "boot-one") -> SafetyReport:
    return SafetyReport(boot, at_s, True, False, True, False, 0.5, frozenset({"press-one"}))


@pytest.mark.parametrize(
    "after",
    [
        pytest.param([moving(3.0)], id="a robot that names each boot alike has restarted"),
        pytest.param([standing(900.0, "press-one"), moving(9.0)], id="one report was from the future"),
        pytest.param([standing(1.0, "press-one", boot="forged"), moving(9.0)], id="one report was forged"),
    ],
)
def test_what_a_robot_says_for_seconds_counts_whatever_was_said_once(after: list[SafetyReport]) -> None:
    book = StopBook()
    press(book, "press-one")
    book.reported("weeder-01", standing(5.0, "press-one"), T0 + 0.5)
    *wrong, right = after
    for report in wrong:
        book.reported("weeder-01", report, T0 + 0.6)
    assert not book.reported("weeder-01", right, T0 + 0.7)
    (found,) = book.reported("weeder-01", right, T0 + 0.7 + LOST_S)
    assert found.state is StopState.NOT_CONFIRMED


def test_a_reset_press_leaves_the_book_but_whoever_asks_still_reads_reset() -> None:
    book = StopBook()
    press(book, "press-one")
    changed = book.answered("press-one", "weeder-01", StopAnswer(False, "already_reset"), T0 + 1)
    assert [a.state for a in changed] == [StopState.RESET]
    assert not book.attempts()
    assert book.next_due_s() is None
    assert [s["state"] for s in book.steps(T0 + 2, "press-one")] == ["reset"]
    assert press(book, "press-one", now_s=T0 + 3).state is StopState.RESET
    assert not book.due(T0 + 3)


def test_robots_and_paths_that_return_get_what_is_not_confirmed_at_once() -> None:
    book = StopBook()
    for robot in ROBOTS:
        book.sent(press(book, "press-one", robot), T0, by_mqtt=True)
    book.returned("weeder-02", T0 + 0.1)
    assert [a.robot_id for a in book.due(T0 + 0.1)] == ["weeder-02"]
    book.path_returned(T0 + 0.15)
    assert len(book.due(T0 + 0.15)) == 2


def test_thousands_of_presses_cost_no_more_memory_than_a_robot_keeps() -> None:
    book = StopBook()
    for n in range(1000):
        press(book, f"press-{n:04}", now_s=T0 + n)
    assert len(book) == MAX_OPEN_PER_ROBOT
    assert book.attempts()[-1].stop_id == "press-0999"


def stranger(book: StopBook, stop_id: str = "press-one", now_s: float = T0) -> StopAttempt:
    target = StopTarget("weeder-99", "weeder-99", is_stranger=True)
    return book.press(stop_id, target, "Martha", "Tablet 3", now_s=now_s, utc=UTC0)


def test_an_id_that_nobody_knows_cannot_raise_an_alarm_without_end_and_is_never_called_reset() -> None:
    book = StopBook()
    press(book, "press-one")
    stranger(book)
    assert not book.forget_strangers({"weeder-01"}, T0 + STRANGER_S)
    changed = book.forget_strangers({"weeder-01"}, T0 + STRANGER_S + 1)
    assert [(a.robot_id, a.state) for a in changed] == [("weeder-99", StopState.WITHDRAWN)]
    assert [a.robot_id for a in book.attempts()] == ["weeder-01"]
    assert [s["state"] for s in book.steps(T0 + STRANGER_S + 1, "press-one")] == ["sent", "withdrawn"]


def test_a_robot_that_is_listed_no_more_keeps_its_stop_however_long_it_is_silent() -> None:
    book = StopBook()
    press(book, "press-one")
    book.tick(T0 + 5)
    assert not book.forget_strangers(set(), T0 + 100 * STRANGER_S)
    assert [a.state for a in book.attempts()] == [StopState.NOT_CONFIRMED]
    assert [a.robot_id for a in book.due(T0 + 100 * STRANGER_S)] == ["weeder-01"]


def test_an_id_that_was_heard_or_registered_once_is_no_stranger_any_more() -> None:
    book = StopBook()
    stranger(book)
    book.forget_strangers({"weeder-99"}, T0 + 1)
    assert not book.forget_strangers(set(), T0 + 100 * STRANGER_S)
    assert len(book) == 1


def test_a_press_that_was_withdrawn_stops_again_when_it_is_made_again() -> None:
    book = StopBook()
    stranger(book)
    book.forget_strangers(set(), T0 + STRANGER_S + 1)
    assert stranger(book, now_s=T0 + STRANGER_S + 2).state is StopState.SENT
    assert len(book.due(T0 + STRANGER_S + 2)) == 1


def test_strangers_are_kept_up_to_a_limit_and_known_robots_always() -> None:
    book = StopBook()
    for n in range(MAX_STRANGERS):
        target = StopTarget(f"stranger-{n}", "?")
        assert book.admits(target.id, {"weeder-01"})
        book.press("press-one", target, "", "", now_s=T0, utc=UTC0)
    assert not book.admits("one-more", {"weeder-01"})
    assert book.admits("stranger-3", {"weeder-01"})
    assert book.admits("weeder-01", {"weeder-01"})


@given(st.lists(st.tuples(st.sampled_from(["boot-one", "boot-two", "boot-three"]), st.integers(0, 20)), max_size=40))
def test_reports_are_taken_in_the_order_the_robot_made_them(seen: list[tuple[str, int]]) -> None:
    order, taken = ReportOrder(), []
    for boot, at_s in seen:
        if order.is_new("weeder-01", standing(at_s, boot=boot), T0):
            taken.append((boot, at_s))
    boots = [boot for n, (boot, _) in enumerate(taken) if n == 0 or taken[n - 1][0] != boot]
    assert len(boots) == len(set(boots))  # no boot comes back once another followed it
    for (boot, at_s), (next_boot, next_at_s) in pairwise(taken):
        assert boot != next_boot or next_at_s >= at_s
