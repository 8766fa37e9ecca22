"""A station on its clock: when it speaks, which notices and triggers it takes, and what faults do to its messages."""

from __future__ import annotations

from datetime import timedelta
from itertools import pairwise
from typing import Any

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from backend_clients.field import messages as m
from backend_clients.field.topics import Down, Up
from backend_clients.simulator.field import faults
from backend_clients.simulator.field.instrument import INSTRUMENTS
from backend_clients.simulator.field.treatment import LONGEST_S, MOST_A_DAY
from tests.backend_clients.simulator.field.rig import Rig

DAY_S = 86_400.0


@pytest.mark.slow
def test_it_says_who_it_is_and_what_it_measures_at_once_and_then_each_period() -> None:
    rig = Rig("soil")
    rig.station.greet()
    assert [(kind, kept) for kind, _, kept in rig.sent] == [(Up.ABOUT, True), (Up.DATA, False)]
    about = rig.sent[0][1]
    assert isinstance(about, m.About)
    assert (about.period_s, about.parcel) == (600.0, "polder-17")
    rig.run(6000)
    assert [one.seq for one in rig.data()] == list(range(11))
    assert {b.utc - a.utc for a, b in pairwise(rig.data())} == {timedelta(seconds=600)}
    declared = {(q.quantity, q.depth_m) for q in about.quantities}
    assert all({(v.quantity, v.depth_m) for v in one.values} == declared for one in rig.data())


def test_what_it_measured_without_a_connection_comes_late_and_in_order() -> None:
    rig = Rig("soil")
    rig.station.greet()
    rig.is_up = False
    rig.run(3600)
    assert len(rig.data()) == 1
    rig.is_up = True
    rig.station.greet()
    assert [one.seq for one in rig.data()] == list(range(8))
    assert rig.data()[1].utc < rig.clock.utc() - timedelta(seconds=2900)


def test_a_new_boot_counts_from_zero() -> None:
    one, other = Rig(), Rig()
    one.station.greet()
    other.station.greet()
    assert one.data()[0].boot != other.data()[0].boot
    assert one.data()[0].seq == other.data()[0].seq == 0


def test_faster_weather_is_told_with_a_shorter_period() -> None:
    rig = Rig("soil", speed=60.0)
    rig.station.greet()
    about = rig.sent[0][1]
    assert isinstance(about, m.About)
    assert about.period_s == 10.0
    begin = rig.value("soil_temperature", 0.1)
    rig.run(360)  # six hours
    assert abs(rig.value("soil_temperature", 0.1) - begin) > 0.5
    assert rig.data()[-1].utc <= rig.clock.utc()


# ---- treatment ---------------------------------------------------------------------------------------


def test_under_a_notice_it_measures_six_times_as_often_and_says_so() -> None:
    rig = Rig("weather")
    rig.station.greet()
    assert rig.notice(for_s=300).outcome == "accepted"
    rig.run(290)
    told = rig.data()[1:]
    assert len(told) == 29
    assert {one.notice for one in told} == {"notice-01"}
    rig.run(600)
    after = [one for one in rig.data() if one.utc > told[-1].utc]
    assert {one.notice for one in after[1:]} == {msgspec.UNSET}
    assert 9 <= len(after) <= 11


@pytest.mark.slow
@settings(max_examples=25, deadline=None)
@given(st.floats(1, 7200), st.lists(st.floats(0.1, 900), max_size=12))
def test_a_notice_is_never_obeyed_after_its_end(for_s: float, steps: list[float]) -> None:
    rig = Rig("weather")
    rig.station.greet()
    end = rig.clock.utc() + timedelta(seconds=min(for_s, LONGEST_S))
    rig.notice(for_s=for_s)
    for step in steps:
        rig.run(step)
    assert all(one.notice is msgspec.UNSET or one.utc < end for one in rig.data())


def test_a_notice_ends_by_the_stations_own_time_when_its_clock_is_set_back() -> None:
    rig = Rig("weather")
    rig.station.greet()
    rig.notice(for_s=300)
    rig.clock.jump_wall(-86_400)
    rig.run(301)
    rig.run(60)
    assert rig.data()[-1].notice is msgspec.UNSET


def test_a_renewed_notice_goes_on_with_the_same_id_and_a_repeat_does_not() -> None:
    rig = Rig("weather")
    rig.station.greet()
    rig.notice(for_s=100)
    rig.run(90)
    assert rig.notice(for_s=100).outcome == "accepted"
    rig.run(60)
    assert rig.data()[-1].notice == "notice-01"
    rig.run(60)
    assert rig.data()[-1].notice is msgspec.UNSET


def test_a_repeat_gets_the_same_answer_even_when_it_comes_after_the_end() -> None:
    rig = Rig("weather")
    now = rig.clock.utc()
    same: dict[str, Any] = {"utc": now, "until_utc": now + timedelta(seconds=30)}
    first = rig.notice(**same)
    rig.run(60)
    assert rig.notice(**same) == first
    rig.run(60)
    assert rig.data()[-1].notice is msgspec.UNSET


def test_a_notice_that_is_over_or_older_than_the_one_obeyed_changes_nothing() -> None:
    rig = Rig("weather")
    rig.station.greet()
    late = rig.notice("notice-00", for_s=-20)
    assert (late.outcome, late.text) == ("rejected", "The notice ended 20 s before it came.")
    rig.notice(for_s=300)
    older = rig.notice("notice-02", is_treating=False, utc=rig.clock.utc() - timedelta(seconds=5))
    assert older.outcome == "rejected"
    rig.run(60)
    assert rig.data()[-1].notice == "notice-01"
    assert rig.notice("notice-03", is_treating=False).text == "Treatment is over."
    rig.run(61)
    assert rig.data()[-1].notice is msgspec.UNSET


def test_a_notice_that_is_taken_away_needs_no_answer_and_still_ends_at_its_time() -> None:
    rig = Rig("weather")
    rig.station.greet()
    rig.notice(for_s=100)
    rig.station.hear(Down.NOTICE, b"", is_retained=False)
    rig.run(50)
    assert rig.data()[-1].notice == "notice-01"
    rig.run(100)
    assert rig.data()[-1].notice is msgspec.UNSET
    assert len(rig.acks()) == 1
    assert rig.station.unreadable == 0


def test_a_field_camera_takes_a_picture_when_treatment_begins_and_when_it_ends() -> None:
    rig = Rig("camera")
    rig.station.greet()
    rig.notice(for_s=30)
    assert rig.shots == 1
    rig.run(31)
    assert rig.shots == 2


def test_what_it_cannot_read_is_counted_and_not_answered() -> None:
    rig = Rig("camera")
    for payload in (b"{", b'{"station":"other","id":"12345678"}', b"[" * 1000):
        rig.station.hear(Down.TRIGGER, payload, is_retained=False)
    assert rig.station.unreadable == 3
    assert rig.acks() == []


# ---- pictures ------------------------------------------------------------------------------------------


def test_a_field_camera_takes_a_picture_each_hour_and_tells_its_battery() -> None:
    rig = Rig("camera")
    rig.station.greet()
    rig.run(6 * 3600)
    assert rig.shots == 6
    assert sum(kind is Up.FRAME for kind, _, _ in rig.sent) == 6
    assert all(one.values == [] and isinstance(one.battery, float) for one in rig.data())


@given(st.floats(-600, 600), st.floats(0.1, 60))
def test_a_trigger_older_than_its_time_to_live_is_refused(age_s: float, ttl_s: float) -> None:
    rig = Rig("camera")
    answer = rig.trigger(age_s=age_s, ttl_s=ttl_s)
    is_fresh = abs(age_s) < ttl_s - 1e-3
    if abs(abs(age_s) - ttl_s) > 1e-3:
        assert (answer.outcome == "accepted") == is_fresh
        assert rig.shots == is_fresh


def test_the_refusal_of_a_late_trigger_says_how_old_it_was() -> None:
    assert Rig("camera").trigger(age_s=14, ttl_s=5).text == "Trigger is 14 s old, limit 5 s."


def test_a_repeated_trigger_takes_one_picture() -> None:
    rig = Rig("camera")
    assert rig.trigger() == rig.trigger()
    rig.run(10)
    assert rig.trigger().outcome == "accepted"
    assert rig.shots == 1


def test_two_triggers_within_five_seconds_take_one_picture() -> None:
    rig = Rig("camera")
    rig.trigger()
    rig.run(2)
    refused = rig.trigger("trigger-2")
    assert (refused.outcome, refused.text) == ("rejected", "The last picture was 2.0 s ago, at most one in 5 s.")
    rig.run(3.5)
    assert rig.trigger("trigger-3").outcome == "accepted"
    assert rig.shots == 2


def test_a_camera_takes_a_hundred_pictures_a_day_and_goes_on_the_next_day() -> None:
    rig = Rig("camera")
    for number in range(MOST_A_DAY + 1):
        rig.clock.advance(6)
        answer = rig.trigger(f"trigger-{number}")
    assert (answer.outcome, rig.shots) == ("rejected", MOST_A_DAY)
    assert "100 pictures" in answer.text
    rig.clock.advance(DAY_S)
    assert rig.trigger("trigger-new").outcome == "accepted"


def test_a_trigger_that_the_broker_kept_and_one_to_a_station_without_a_camera_are_refused() -> None:
    assert Rig("camera").trigger(is_retained=True).outcome == "rejected"
    assert Rig("soil").trigger().text == "Soil 1 has no camera."


# ---- faults --------------------------------------------------------------------------------------------


def test_a_silent_station_says_and_hears_nothing_and_is_heard_again_at_once() -> None:
    rig = Rig("camera")
    rig.station.greet()
    many = len(rig.sent)
    rig.station.set_fault(faults.Silence())
    rig.run(7200)
    rig.station.hear(Down.TRIGGER, b"{}", is_retained=False)
    rig.station.greet()
    assert len(rig.sent) == many
    rig.station.clear_fault("silence")
    assert [kind for kind, _, _ in rig.sent[many:]] == [Up.ABOUT, Up.DATA]


def test_a_value_that_drifts_leaves_the_truth_and_stays_in_its_range() -> None:
    rig, honest = Rig("soil"), Rig("soil")
    rig.station.set_fault(faults.Drift(quantity="soil_moisture", share_per_h=0.5))
    for one in (rig, honest):
        one.station.greet()
        one.run(7200)
    away = rig.value("soil_moisture", 0.3) - honest.value("soil_moisture", 0.3)
    assert away == pytest.approx(0.5 * 2 * INSTRUMENTS["soil_moisture"].span, abs=1e-3)
    assert rig.value("soil_temperature", 0.3) == honest.value("soil_temperature", 0.3)
    rig.run(3 * DAY_S)
    assert rig.value("soil_moisture", 0.3) == INSTRUMENTS["soil_moisture"].high


def test_a_stuck_value_stays_while_the_others_go_on() -> None:
    rig = Rig("weather")
    rig.station.set_fault(faults.Stuck(quantity="air_temperature"))
    rig.station.greet()
    rig.run(12 * 3600)
    told = [{v.quantity: v.value for v in one.values} for one in rig.data()]
    assert len({one["air_temperature"] for one in told}) == 1
    assert len({one["radiation"] for one in told}) > 10
    rig.station.clear_fault()
    rig.run(60)
    assert rig.value("air_temperature") != told[0]["air_temperature"]


def test_a_low_battery_is_told() -> None:
    rig = Rig("soil")
    rig.station.set_fault(faults.LowBattery(level=0.09))
    rig.station.greet()
    assert rig.data()[0].battery == 0.09


def test_a_wrong_clock_dates_values_wrong_and_refuses_what_is_fresh() -> None:
    rig = Rig("camera")
    rig.station.set_fault(faults.ClockSkew(offset_s=2700))
    rig.station.greet()
    assert rig.data()[0].utc == rig.clock.utc() + timedelta(seconds=2700)
    assert rig.trigger().text == "Trigger is 45 min old, limit 5 s."
    assert rig.notice(for_s=300).outcome == "rejected"


def test_duplicates_really_come_twice_with_one_number() -> None:
    rig = Rig("weather")
    rig.station.set_fault(faults.Duplicates(copies=2))
    rig.station.greet()
    rig.run(60)
    assert [one.seq for one in rig.data()] == [0, 0, 0, 1, 1, 1]


def test_out_of_order_messages_come_in_the_wrong_order_and_none_is_lost() -> None:
    rig = Rig("weather")
    rig.station.set_fault(faults.OutOfOrder())
    rig.station.greet()
    rig.run(4 * 60)
    assert [one.seq for one in rig.data()] == [1, 0, 3, 2]
    rig.station.clear_fault("out-of-order")
    rig.run(60)
    assert [one.seq for one in rig.data()] == [1, 0, 3, 2, 4, 5]


def test_a_fault_of_an_unknown_quantity_is_refused() -> None:
    with pytest.raises(msgspec.ValidationError, match="no quantity"):
        faults.decode_fault(b'{"fault":"drift","quantity":"moonlight"}')
    assert isinstance(faults.decode_fault(b'{"fault":"drift","quantity":"co2"}'), faults.Drift)


def test_every_situation_is_one_that_its_stations_can_have() -> None:
    assert len({one.id for one in faults.SITUATIONS}) == len(faults.SITUATIONS)
    assert {faults.name_of(one.fault) for one in faults.SITUATIONS} == {
        "silence", "drift", "stuck", "low-battery", "clock-skew", "duplicates", "out-of-order"
    }  # fmt: skip
