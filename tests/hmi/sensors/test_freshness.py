"""Nothing old looks fresh: whatever a station's clock says, and in whatever order its messages come."""

from __future__ import annotations

from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from hmi.clock import FakeClock
from hmi.domain.sensors.freshness import (
    FADE,
    RECENT,
    Arrival,
    Fate,
    Receipt,
    State,
    is_usable,
    silent_after_s,
    state_of,
)

START = datetime(2026, 5, 4, 12, tzinfo=UTC)
PERIOD_S = 60.0


@pytest.mark.parametrize(
    ("age_s", "period_s", "state"),
    [
        (None, 60, State.NEVER), (0, 60, State.FRESH), (90, 60, State.FRESH), (91, 60, State.LATE),
        (180, 60, State.LATE), (181, 60, State.SILENT), (901, 600, State.LATE), (1800, 600, State.LATE),
        (1801, 600, State.SILENT), (5401, 3600, State.LATE), (10_801, 3600, State.SILENT),
    ],
)  # fmt: skip
def test_late_after_one_and_a_half_periods_and_silent_after_three(
    age_s: float | None, period_s: float, state: State
) -> None:
    assert state_of(age_s, period_s) is state


def test_no_decision_goes_by_a_stale_value_nor_by_weather_older_than_a_quarter_of_an_hour() -> None:
    assert is_usable(180, 60)
    assert not is_usable(181, 60)
    assert is_usable(900, 600)
    assert not is_usable(901, 86_400), "whatever period a station declares"
    assert is_usable(1800, 600, is_slow=True)
    assert not is_usable(1801, 600, is_slow=True)


@given(age_s=st.floats(0, 1e6), more_s=st.floats(0, 1e6), period_s=st.floats(1, 86_400))
def test_what_gets_older_never_looks_fresher(age_s: float, more_s: float, period_s: float) -> None:
    order = list(State)
    assert order.index(state_of(age_s + more_s, period_s)) >= order.index(state_of(age_s, period_s))
    assert silent_after_s(period_s) == 3 * period_s


def test_a_repeat_is_known_by_boot_and_number() -> None:
    receipt = Receipt()
    first = receipt.judge("boot-one", 7, START, now=START, now_s=0.0, period_s=PERIOD_S)
    again = receipt.judge("boot-one", 7, START, now=START, now_s=1.0, period_s=PERIOD_S)
    other = receipt.judge("boot-two", 7, START, now=START, now_s=1.0, period_s=PERIOD_S)
    assert [first.fate, again.fate, other.fate] == [Fate.NEWEST, Fate.REPEATED, Fate.NEWEST]


def test_what_waited_in_a_stations_memory_is_as_old_as_it_is_even_if_its_clock_runs_ahead() -> None:
    receipt, ahead = Receipt(), timedelta(minutes=20)
    receipt.judge("boot-one", 1, START + ahead, now=START, now_s=0.0, period_s=PERIOD_S)
    late = receipt.judge("boot-one", 2, START + ahead, now=START + timedelta(hours=1), now_s=3600.0, period_s=PERIOD_S)
    assert late.measured_s == pytest.approx(0.0)
    assert receipt.skew_s == pytest.approx(1200)


def test_a_clock_that_was_set_right_is_believed_again() -> None:
    receipt = Receipt()
    for number in range(3):
        at = START + timedelta(minutes=number)
        receipt.judge("boot-one", number, at + timedelta(hours=1), now=at, now_s=60.0 * number, period_s=PERIOD_S)
    assert receipt.is_clock_wrong
    for number in range(3, 4 + RECENT):
        at = START + timedelta(minutes=number)
        found = receipt.judge("boot-one", number, at, now=at, now_s=60.0 * number, period_s=PERIOD_S)
    assert not receipt.is_clock_wrong
    assert found.fate is Fate.NEWEST
    assert found.measured_s == pytest.approx(60.0 * number)


@pytest.mark.parametrize("step_s", [43_200.0, 30 * 86_400.0, -43_200.0])
def test_a_console_whose_clock_is_set_takes_what_is_new_for_new(step_s: float) -> None:
    clock, receipt, true = FakeClock(START), Receipt(), START + timedelta(seconds=step_s)
    for number in range(2 * RECENT):
        if number == RECENT:
            clock.jump_wall(step_s)
        found = receipt.judge("boot-one", number, true, now=clock.utc(), now_s=clock.mono_s(), period_s=PERIOD_S)
        assert (number, found.fate) == (number, Fate.NEWEST)
        if number >= RECENT:
            assert found.measured_s == pytest.approx(clock.mono_s())
        clock.advance(60)
        true += timedelta(seconds=60)
    late = receipt.judge(
        "boot-one", 99, true - timedelta(hours=1), now=clock.utc(), now_s=clock.mono_s(), period_s=PERIOD_S
    )
    assert late.measured_s == pytest.approx(clock.mono_s() - 3600), "what waited is as old as it is"


def test_what_waited_two_weeks_is_rather_a_wrong_clock_and_is_not_kept() -> None:
    found = Receipt().judge("boot-one", 1, START - timedelta(days=15), now=START, now_s=0.0, period_s=PERIOD_S)
    assert found.fate is Fate.TOO_OLD


@dataclass(frozen=True)
class Sent:
    """A message on its way."""

    boot: str
    seq: int
    claimed: datetime
    true_s: float


class StationWithBadClock(RuleBasedStateMachine):
    """A station whose clock is wrong and whose radio repeats, delays and reorders."""

    @initialize(skew_s=st.floats(-3600, 3600))
    def begin(self, skew_s: float) -> None:
        """Begin with a clock that is off."""
        self.clock, self.receipt = FakeClock(START), Receipt()
        self.skew_s, self.boot, self.seq = skew_s, 0, 0
        self.sent: list[Sent] = []
        self.heard: set[tuple[str, int]] = set()
        self.fresh_true_s = float("-inf")
        self.is_steady = True

    @rule(seconds=st.floats(0.1, 7200))
    def wait(self, seconds: float) -> None:
        """Let time pass."""
        self.clock.advance(seconds)

    @rule()
    def measure(self) -> None:
        """Make a message; it waits to be delivered."""
        self.seq += 1
        claimed = self.clock.utc() + timedelta(seconds=self.skew_s)
        self.sent.append(Sent(f"boot-{self.boot:04d}", self.seq, claimed, self.clock.mono_s()))

    @rule()
    def reboot(self) -> None:
        """Begin to count anew."""
        self.boot, self.seq = self.boot + 1, 0

    @rule(data=st.data())
    def deliver(self, data: st.DataObject) -> None:
        """Let any message that was ever sent arrive, perhaps again."""
        if not self.sent:
            return
        one = data.draw(st.sampled_from(self.sent))
        before = self.receipt.newest_s
        found = self.receipt.judge(
            one.boot, one.seq, one.claimed, now=self.clock.utc(), now_s=self.clock.mono_s(), period_s=PERIOD_S
        )
        key = one.boot, one.seq
        assert (found.fate is Fate.REPEATED) == (key in self.heard)
        self.heard.add(key)
        if found.fate is Fate.NEWEST:
            assert found.measured_s >= before
        if found.fate is not Fate.REPEATED:
            assert found.measured_s <= self.clock.mono_s() + 1e-6
            if self.skew_s <= 0:  # a clock behind never makes anything younger than it is
                assert found.measured_s <= one.true_s + 1e-3

    @invariant()
    def the_newest_never_goes_back(self) -> None:
        """What is newest stays newest until something newer comes."""
        assert self.receipt.newest_s >= self.fresh_true_s
        self.fresh_true_s = self.receipt.newest_s


StationWithBadClock.TestCase.settings = settings(max_examples=60, stateful_step_count=25, deadline=None)
TestStationWithBadClock = StationWithBadClock.TestCase


@given(
    skew_s=st.floats(-7200, 7200),
    delays_s=st.lists(st.floats(0, 7200), min_size=1, max_size=RECENT - 1),
)
def test_once_a_message_came_at_once_no_later_one_looks_younger_than_it_is(
    skew_s: float, delays_s: list[float]
) -> None:
    receipt, now_s = Receipt(), 0.0
    receipt.judge("boot-one", 0, START + timedelta(seconds=skew_s), now=START, now_s=0.0, period_s=PERIOD_S)
    for number, delay_s in enumerate(delays_s, 1):
        now_s += 7200.0
        true_s = now_s - delay_s
        claimed = START + timedelta(seconds=true_s + skew_s)
        found = receipt.judge(
            "boot-one", number, claimed, now=START + timedelta(seconds=now_s), now_s=now_s, period_s=PERIOD_S
        )
        assert found.measured_s <= true_s + FADE * PERIOD_S * number + 1e-3


@dataclass
class Slewed:
    """A station whose messages come at once while its clock is set; ``rate`` is how fast its monotonic clock runs."""

    period_s: float = 60.0
    rate: float = 1.0
    with_mono: bool = True
    receipt: Receipt = field(default_factory=Receipt)
    number: int = 0
    now_s: float = 0.0

    def heard(self, skew_s: float, waited_s: float = 0.0) -> Arrival:
        """Return how the next message is judged."""
        self.number += 1
        self.now_s += self.period_s + waited_s
        true_s = self.now_s - waited_s
        now = START + timedelta(seconds=self.now_s)
        claimed = START + timedelta(seconds=true_s + skew_s)
        mono_s = true_s * self.rate if self.with_mono else None
        return self.receipt.judge(
            "boot-one", self.number, claimed, now=now, now_s=self.now_s, period_s=self.period_s, mono_s=mono_s
        )

    def age_s(self, found: Arrival) -> float:
        """Return how old it is said to be on arrival."""
        return self.now_s - found.measured_s


@pytest.mark.parametrize(("with_mono", "most_s"), [(True, 1.0), (False, 300.0)])
def test_a_clock_that_is_slewed_right_is_believed_at_once_where_the_station_tells_its_monotonic_clock(
    *, with_mono: bool, most_s: float
) -> None:
    station = Slewed(with_mono=with_mono)
    found = [station.heard(max(0.0, 300.0 - 5.0 * number)) for number in range(80)]
    assert all(one.is_dated for one in found[1:])
    assert station.age_s(found[-1]) <= most_s
    if not with_mono:
        assert station.age_s(found[-1]) > 100.0  # nobody can tell: it may as well come later and later


def test_a_clock_that_leaps_is_told_from_a_message_that_waited() -> None:
    station = Slewed()
    for _ in range(5):
        station.heard(0.0)
    leapt = station.heard(3600.0)
    assert (leapt.is_dated, station.age_s(leapt)) == (True, 0.0)
    back = station.heard(-3600.0)
    assert (back.is_dated, station.age_s(back)) == (True, 3600.0)  # behind: rather old than fresh
    station = Slewed()
    for _ in range(5):
        station.heard(0.0)
    hidden = station.heard(1800.0, waited_s=1800.0)  # it leapt by exactly as much as the message waited
    assert (hidden.is_dated, station.age_s(hidden)) == (False, 1800.0)


@given(
    steps=st.lists(st.tuples(st.floats(-600, 600), st.floats(0, 3600)), min_size=1, max_size=20),
    skew_s=st.floats(-3600, 3600),
)
def test_however_a_clock_is_set_no_message_looks_younger_than_it_is(
    steps: list[tuple[float, float]], skew_s: float
) -> None:
    station = Slewed(period_s=7200.0)
    station.heard(skew_s)
    for number, (set_s, waited_s) in enumerate(steps, 1):
        skew_s += set_s
        found = station.heard(skew_s, waited_s)
        assert station.age_s(found) >= waited_s - FADE * station.period_s * number - 1e-3


@pytest.mark.parametrize("rate", [0.0, 0.5, 0.99, 1.01, 1.5, 10.0])
def test_a_monotonic_clock_that_runs_wrong_makes_nothing_look_fresh(rate: float) -> None:
    station = Slewed(rate=rate)
    for _ in range(30):
        station.heard(600.0)
    late = station.heard(600.0, waited_s=600.0)
    assert station.age_s(late) >= 600.0 - FADE * station.period_s * 31
    assert not late.is_dated
