"""No decision goes by an old value: whatever a station's clock leads by, leaps to, and in what bursts values come."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from hmi.app.sensor_weather import feed_weather
from hmi.clock import FakeClock
from hmi.commands.weather import WeatherBoard
from hmi.domain.sensors.freshness import FADE, STEADY_PERIODS, silent_after_s
from hmi.domain.sensors.gate import GateState, gate
from hmi.domain.sensors.limit import SensorLimit
from hmi.domain.sensors.observation import SensorKind
from hmi.domain.sensors.quantity import Channel
from hmi.domain.sensors.station import FieldStation, Report
from hmi.store.sensor_board import SensorBoard, usable

WIND = Channel("wind_speed")
START = datetime(2026, 6, 1, 12, tzinfo=UTC)


class Mast:
    """A weather station with a clock of its own and a memory for what it cannot send."""

    def __init__(self, period_s: float = 60.0, lead_s: float = 0.0) -> None:
        self.clock, self.period_s, self.lead_s, self.seq = FakeClock(START), period_s, lead_s, 0
        self.kept: list[tuple[datetime, float]] = []
        self.board = SensorBoard(self.clock, lambda _id, _channel, at, value: self.kept.append((at, value)))
        self.board.limits = [SensorLimit(WIND, high=5.0, is_treatment=True)]
        about = FieldStation("mast", "Mast", SensorKind.WEATHER, 52, 5, period_s, {WIND: "m/s"}, is_accepted=True)
        self.board.put(about)
        self.waiting: list[Report] = []
        self.true_s: dict[int, float] = {}
        self.delay_s = 0.0
        self.by_chance: set[int] = set()  # waited just as long as its clock leapt meanwhile: nobody can see that

    def measures(self, wind: float) -> None:
        """Measure; what was measured waits."""
        self.seq += 1
        at = self.clock.utc() + timedelta(seconds=self.lead_s)
        self.waiting.append(Report("mast", "boot-0001", self.seq, at, ((WIND, wind),)))
        self.true_s[self.seq] = self.clock.mono_s()

    def sends(self) -> None:
        """Send what waited longest."""
        one = self.waiting.pop(0)
        delay_s, before_s = (self.clock.utc() - one.utc).total_seconds(), self.delay_s
        waited_s, self.delay_s = self.clock.mono_s() - self.true_s[one.seq], delay_s
        if waited_s > self.period_s and abs(delay_s - before_s) <= STEADY_PERIODS * self.period_s:
            self.by_chance.add(one.seq)
        self.board.reported(one, self.clock.mono_s())

    def says(self, wind: float) -> None:
        """Measure and send at once, a period after what was said before."""
        self.clock.advance(self.period_s)
        self.measures(wind)
        self.sends()

    @property
    def gate(self) -> GateState:
        """What the gate says."""
        return gate(self.board.limits, self.board.measured()).state


@pytest.mark.parametrize("period_s", [60.0, 300.0])
@pytest.mark.parametrize("lead_s", [90.0, 3600.0, 7200.0, 50 * 365 * 86_400.0])
def test_once_a_clock_is_set_back_the_gate_goes_by_no_old_wind(period_s: float, lead_s: float) -> None:
    mast = Mast(period_s, lead_s + period_s)
    for _ in range(3):
        mast.says(3.0)
    assert mast.gate is GateState.OPEN
    mast.lead_s = 0.0
    mast.says(8.0)
    assert mast.gate is GateState.UNKNOWN, "it may have waited"
    mast.says(8.0)
    assert mast.gate is GateState.WAITS
    assert mast.kept[-1] == (mast.clock.utc(), 8.0)
    assert mast.kept[-2] == (mast.clock.utc() - timedelta(seconds=period_s), 8.0), "kept as of when it was measured"


def test_one_message_from_the_future_hides_nothing_that_comes_after_it() -> None:
    mast = Mast()
    for lead_s in (0.0, 0.0, 7200.0, 0.0, 0.0):
        mast.lead_s = lead_s
        mast.says(3.0 if lead_s else 8.0)
    assert mast.gate is GateState.WAITS


@pytest.mark.parametrize("late_s", [1800.0, 30 * 86_400.0])
def test_once_a_clock_is_set_behind_nothing_that_was_measured_before_counts(late_s: float) -> None:
    mast = Mast()
    for _ in range(3):
        mast.says(3.0)
    mast.lead_s = -late_s
    for _ in range(3):
        mast.says(8.0)
        assert mast.gate is GateState.UNKNOWN


def test_the_weather_of_the_queue_takes_back_what_newer_values_put_in_doubt() -> None:
    mast = Mast(lead_s=3600.0)
    weather = WeatherBoard(mast.clock, lambda *_: None, "hof")  # type: ignore[arg-type]  # nobody reports by hand
    mast.board.on_report.append(lambda _known: feed_weather(mast.board, weather, mast.clock))
    seen = []
    for number, wind in enumerate((3.0, 3.0, 8.0, 8.0)):
        mast.lead_s = 3600.0 if number < 2 else 0.0
        mast.says(wind)
        seen.append(weather.latest and weather.latest.wind_mps)
    assert seen == [None, 3.0, None, 8.0]


@pytest.mark.parametrize("gap_s", [1.0, 20.0])
def test_what_a_station_with_a_clock_ahead_stored_is_as_old_as_it_is(gap_s: float) -> None:
    mast = Mast(lead_s=3600.0)
    for _ in range(20):
        mast.says(3.0)
    for _ in range(50):
        mast.clock.advance(60.0)
        mast.measures(3.0)
    for number in range(21, 71):
        mast.clock.advance(gap_s)
        mast.sends()
        age_s = mast.clock.mono_s() - mast.board._stations["mast"].values[WIND].measured_s
        assert age_s == pytest.approx(mast.clock.mono_s() - mast.true_s[number], abs=1.0)
        assert mast.gate is GateState.UNKNOWN or age_s <= 180


class Weather(RuleBasedStateMachine):
    """A mast whose link goes away and whose clock leaps, at any time."""

    @initialize(lead_s=st.floats(-7200, 7200), period_s=st.sampled_from([10.0, 60.0, 300.0]))
    def begin(self, lead_s: float, period_s: float) -> None:
        """Begin, and be heard a while."""
        self.mast = Mast(period_s, lead_s)
        for _ in range(3):
            self.pass_on()

    def pass_on(self) -> None:
        """Measure and send, the value being the number of the message."""
        self.mast.clock.advance(self.mast.period_s)
        self.mast.measures(0.0001 * (self.mast.seq + 1))
        if len(self.mast.waiting) == 1:
            self.mast.sends()

    @rule(count=st.integers(1, 12))
    def is_heard(self, count: int) -> None:
        """Say so much at its pace; what waits goes first."""
        for _ in range(count):
            self.drains(0.01)
            self.pass_on()
            self.holds()

    @rule(count=st.integers(1, 60))
    def is_away(self, count: int) -> None:
        """Measure while the link is away."""
        for _ in range(count):
            self.mast.clock.advance(self.mast.period_s)
            self.mast.measures(0.0001 * (self.mast.seq + 1))
            self.holds()

    @rule(share=st.floats(0.001, 0.3))
    def drains(self, share: float) -> None:
        """Send what waits, quicker than it is measured."""
        while self.mast.waiting:
            self.mast.clock.advance(share * self.mast.period_s)
            self.mast.sends()
            self.holds()

    @rule(leap_s=st.one_of(st.floats(-7200, 7200), st.floats(-1e8, 1e8)))
    def leaps(self, leap_s: float) -> None:
        """Set its clock, whatever to."""
        self.mast.lead_s += leap_s

    @rule(seconds=st.floats(-7200, 7200))
    def console_is_set(self, seconds: float) -> None:
        """Set the clock of the console."""
        self.mast.clock.jump_wall(seconds)
        self.mast.lead_s -= seconds
        self.mast.delay_s += seconds

    @invariant()
    def holds(self) -> None:
        """What counts is never older than promised."""
        known = self.mast.board.get("mast")
        assert known is not None
        now_s, period_s = self.mast.clock.mono_s(), self.mast.period_s
        for value in known.values.values():
            seq = round(value.value / 0.0001)
            if usable(known, value, now_s) and seq not in self.mast.by_chance:
                true_s = self.mast.true_s[seq]
                slack_s = STEADY_PERIODS * period_s + FADE * (now_s - self.mast.true_s[1])
                assert now_s - true_s <= min(900.0, silent_after_s(period_s)) + slack_s


Weather.TestCase.settings = settings(max_examples=150, stateful_step_count=30, deadline=None)
TestWeather = Weather.TestCase


@given(lead_s=st.floats(-1e6, 1e6), wait=st.integers(1, 50), leap_s=st.floats(-1e6, 1e6))
def test_a_clock_that_was_set_counts_again_from_the_second_message_on(lead_s: float, wait: int, leap_s: float) -> None:
    mast = Mast(lead_s=max(0.0, lead_s))
    for _ in range(wait + 2):
        mast.says(3.0)
    assert mast.gate is GateState.OPEN
    mast.lead_s = max(0.0, mast.lead_s + leap_s)
    mast.says(3.0)
    mast.says(3.0)
    assert mast.gate is GateState.OPEN or 0 < -leap_s < 60 * (wait + 3)
