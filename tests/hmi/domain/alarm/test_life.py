"""The life of an alarm against the table of ISA-18.2, in every order of events."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

import pytest
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from hmi.domain.alarm import life
from hmi.domain.alarm.alarm import Alarm, AlarmKey, AlarmState, Phase
from hmi.domain.alarm.life import AlarmRefused
from hmi.domain.alarm.priority import Priority

T0 = datetime(2026, 5, 20, 14, 36, tzinfo=UTC)
KEY = AlarmKey("link-lost", "weeder-07")

TABLE = {
    # phase: (condition comes, condition goes, seen, cleared, more urgent); without and with a latch where they differ
    ("normal", False): ("unacknowledged", "normal", "normal", "normal", "normal"),
    ("unacknowledged", False): ("unacknowledged", "returned", "acknowledged", "refused", "unacknowledged"),
    ("acknowledged", False): ("acknowledged", "normal", "acknowledged", "refused", "unacknowledged"),
    ("returned", False): ("unacknowledged", "returned", "normal", "refused", "returned"),
    ("normal", True): ("unacknowledged", "normal", "normal", "normal", "normal"),
    ("unacknowledged", True): ("unacknowledged", "returned", "acknowledged", "refused", "unacknowledged"),
    ("acknowledged", True): ("acknowledged", "latched", "acknowledged", "refused", "unacknowledged"),
    ("returned", True): ("unacknowledged", "returned", "latched", "refused", "returned"),
    ("latched", True): ("unacknowledged", "latched", "latched", "normal", "latched"),
}


class AlarmStory(RuleBasedStateMachine):
    """Conditions come and go, people answer, time passes; a table of words says what must be shown."""

    def __init__(self) -> None:
        super().__init__()
        self.now = T0
        self.is_latching = False
        self.alarm = Alarm(KEY)
        self.phase = "normal"
        self.shelf_until: datetime | None = None
        self.causes: set[str] = set()
        self.is_out = self.is_out_by_admin = False
        self.priority = Priority.MEDIUM

    @rule(is_latching=st.booleans())
    @precondition(lambda self: self.phase == "normal" and self.alarm.occurrences == 0)
    def be(self, is_latching: bool) -> None:
        self.is_latching = is_latching
        self.alarm = Alarm(KEY, is_latching=is_latching, shelf=self.alarm.shelf, suppressed_by=frozenset(self.causes),
                           out_of_service=self.alarm.out_of_service)  # fmt: skip

    @rule(what=st.sampled_from(["comes", "goes", "seen", "cleared"]))
    def event(self, what: str) -> None:
        expected = TABLE[self.phase, self.is_latching][["comes", "goes", "seen", "cleared"].index(what)]
        if what == "seen" and (self.shelf_until or self.causes or self.is_out):
            expected = "refused"
        happen = {
            "comes": lambda: life.condition_comes(self.alarm, self.now, "so"),
            "goes": lambda: life.condition_goes(self.alarm, self.now),
            "seen": lambda: life.acknowledge(self.alarm, "Martha", self.now),
            "cleared": lambda: life.clear(self.alarm),
        }[what]
        if expected == "refused":
            with pytest.raises(AlarmRefused, match=r"\.$"):
                happen()
        else:
            self.alarm = happen()
            self.phase = expected

    @rule(to=st.sampled_from(Priority))
    def change_priority(self, to: Priority) -> None:
        if to < self.priority:
            self.alarm = life.priority_rises(self.alarm, to)
            self.phase = TABLE[self.phase, self.is_latching][4]
            if to == 1:
                self.shelf_until = None
                self.is_out = self.is_out and self.is_out_by_admin
        self.priority = to

    @rule(minutes=st.integers(-10, 13 * 60), reason=st.sampled_from(["wet", " ", ""]))
    def put_on_the_shelf(self, minutes: int, reason: str) -> None:
        until = self.now + timedelta(minutes=minutes)
        is_allowed = (
            self.priority is not Priority.CRITICAL and 0 < minutes <= 720 and bool(reason.strip()) and not self.is_out
        )
        try:
            self.alarm = life.shelve(self.alarm, self.priority, "Anna", reason, self.now, until)
        except AlarmRefused:
            assert not is_allowed
        else:
            assert is_allowed
            self.shelf_until = until

    @rule()
    def take_off_the_shelf(self) -> None:
        self.alarm = life.unshelve(self.alarm)
        self._shown_again(was_hidden=self.shelf_until is not None, hide="shelf")

    @rule(cause=st.sampled_from(["link", "winter"]))
    def suppress(self, cause: str) -> None:
        self.alarm = life.suppress(self.alarm, cause)
        self.causes.add(cause)

    @rule(cause=st.sampled_from(["link", "winter"]))
    def end_suppression(self, cause: str) -> None:
        self.alarm = life.end_suppression(self.alarm, cause)
        was_hidden = self.causes == {cause}
        self.causes.discard(cause)
        self._shown_again(was_hidden=was_hidden)

    @rule(is_admin=st.booleans())
    def take_out(self, is_admin: bool) -> None:
        is_admin = is_admin or self.priority == 1  # the desk lets nobody else
        self.alarm = life.take_out(self.alarm, "Anna", "sensor is at the maker", self.now, holds_critical=is_admin)
        self.is_out, self.is_out_by_admin, self.shelf_until = True, is_admin, None

    @rule()
    def put_back(self) -> None:
        was_hidden, self.is_out = self.is_out, False
        self.alarm = life.put_back(self.alarm)
        self._shown_again(was_hidden=was_hidden)

    @rule(minutes=st.integers(-30, 300))
    def time_passes(self, minutes: int) -> None:
        put_at = None if self.alarm.shelf is None else self.alarm.shelf.at
        self.now += timedelta(minutes=minutes)
        self.alarm = life.pass_time(self.alarm, self.now)
        if self.shelf_until is not None and (
            self.now >= self.shelf_until or (put_at is not None and self.now < put_at)
        ):
            self._shown_again(was_hidden=True, hide="shelf")

    def _shown_again(self, *, was_hidden: bool, hide: str = "") -> None:
        if hide == "shelf":
            self.shelf_until = None
        is_hidden = bool(self.shelf_until or self.causes or self.is_out)
        if was_hidden and not is_hidden and self.phase == "acknowledged":
            self.phase = "unacknowledged"

    @invariant()
    def it_shows_what_the_table_says(self) -> None:
        assert self.alarm.phase == self.phase
        cover = (
            "out_of_service" if self.is_out else "suppressed" if self.causes else "shelved" if self.shelf_until else ""
        )
        assert self.alarm.state == (cover or self.phase)
        assert self.alarm.is_annunciated == (not cover and self.phase != "normal")
        assert self.alarm.is_active == (self.phase in ("unacknowledged", "acknowledged"))

    @invariant()
    def nobody_is_said_to_have_seen_what_was_not_acknowledged(self) -> None:
        if self.alarm.needs_seeing:
            assert self.alarm.seen_by == ""
        if self.alarm.phase in (Phase.ACKNOWLEDGED, Phase.LATCHED):
            assert self.alarm.seen_by == "Martha"

    @invariant()
    def what_is_critical_never_lies_on_the_shelf(self) -> None:
        assert self.alarm.shelf is None or self.alarm.shelf.until - self.alarm.shelf.at <= timedelta(hours=12)
        if self.priority is Priority.CRITICAL:
            assert self.alarm.shelf is None
            assert self.alarm.out_of_service is None or self.alarm.out_of_service.holds_critical


TestAlarmStory = AlarmStory.TestCase


def test_an_alarm_that_comes_back_asks_for_attention_again_and_counts() -> None:
    alarm = life.acknowledge(life.condition_comes(Alarm(KEY), T0), "Martha", T0)
    alarm = life.condition_comes(life.condition_goes(alarm, T0), T0 + timedelta(minutes=1), "again")
    assert alarm.state is AlarmState.UNACKNOWLEDGED
    assert alarm.raised_at == T0 + timedelta(minutes=1)
    assert alarm.occurrences == 1  # it was normal in between


def test_an_alarm_that_comes_and_goes_unseen_is_one_line_with_a_count() -> None:
    alarm = Alarm(KEY)
    for minute in range(4):
        alarm = life.condition_goes(life.condition_comes(alarm, T0 + timedelta(minutes=minute)), T0)
    assert alarm.state is AlarmState.RETURNED
    assert alarm.occurrences == 4


def test_an_alarm_of_priority_1_cannot_be_shelved() -> None:
    with pytest.raises(AlarmRefused, match="priority 1"):
        life.shelve(Alarm(KEY), Priority.CRITICAL, "Anna", "too loud", T0, T0 + timedelta(minutes=15))
