"""Stations of a parcel know that it is treated, for as long as it is, and nobody guesses that they do."""

from __future__ import annotations

from backend_clients.field.topics import Down
from hmi.domain.alarm.catalogue import catalogue
from hmi.domain.robot import OrderStatus
from hmi.domain.role import Role
from hmi.domain.sensors.limit import SensorLimit
from hmi.domain.sensors.quantity import Channel
from hmi.presenters.diagnosis import diagnose
from hmi.presenters.scene import Scene
from tests.hmi.sensors.rig import OUTSIDE, SensorRig


def notice(rig: SensorRig) -> tuple[str, str] | None:
    """Return what a screen shows of the notice."""
    shown = rig.shown()["notice"]
    return None if shown is None else (shown["state"], shown["text"])


async def test_a_robot_that_reaches_the_field_lets_the_stations_there_know(rig: SensorRig) -> None:
    await rig.accepted()
    await rig.accepted("soil-04", parcel="")
    rig.weeder(OrderStatus.RUNNING, OUTSIDE)
    await rig.passes(10)
    assert (rig.told(Down.NOTICE)[-1:], notice(rig)) == ([None], None)
    rig.weeder(OrderStatus.RUNNING)
    await rig.passes(5)
    told = rig.told(Down.NOTICE)[-1]
    assert (told.is_treating, told.robots, told.parcel) == (True, ["weeder-01"], "north")
    assert (told.until_utc - told.utc).total_seconds() == 600
    assert rig.told(Down.NOTICE, "soil-04") == [None]
    assert notice(rig) == ("sent", "Treatment on North, Weeder 01")
    rig.answers(told.id)
    assert notice(rig) == ("acknowledged", "Treatment on North, Weeder 01")


async def test_an_answer_to_something_else_acknowledges_nothing(rig: SensorRig) -> None:
    await rig.accepted()
    rig.weeder(OrderStatus.RUNNING)
    await rig.passes(5)
    rig.answers("somebody-elses")
    rig.answers(rig.told(Down.NOTICE)[-1].id, station="soil-04")
    assert notice(rig) == ("sent", "Treatment on North, Weeder 01")


async def test_without_an_answer_it_is_unconfirmed_and_sent_again(rig: SensorRig) -> None:
    await rig.accepted()
    rig.weeder(OrderStatus.RUNNING)
    await rig.passes(25)
    assert notice(rig) == ("unconfirmed", "Treatment on North, Weeder 01. Not acknowledged.")
    first = rig.told(Down.NOTICE)[-1]
    await rig.passes(60)
    again = rig.told(Down.NOTICE)[-1]
    assert again.id != first.id
    assert again.until_utc > first.until_utc
    rig.answers(again.id)
    assert notice(rig) == ("acknowledged", "Treatment on North, Weeder 01")


async def test_a_refusal_is_shown_with_its_reason(rig: SensorRig) -> None:
    await rig.accepted()
    rig.weeder(OrderStatus.RUNNING)
    await rig.passes(5)
    rig.answers(rig.told(Down.NOTICE)[-1].id, outcome="rejected", text="Notice is over.")
    assert notice(rig) == ("refused", "Treatment on North, Weeder 01. Notice is over.")


async def test_it_is_renewed_and_a_renewal_without_an_answer_leaves_nothing_acknowledged(rig: SensorRig) -> None:
    await rig.accepted()
    rig.weeder(OrderStatus.RUNNING)
    await rig.passes(5)
    first = rig.told(Down.NOTICE)[-1]
    rig.answers(first.id)
    await rig.passes(245)
    renewed = rig.told(Down.NOTICE)[-1]
    assert renewed.id != first.id
    assert renewed.until_utc > first.until_utc
    shown = notice(rig)
    assert shown is not None
    assert shown[0] == "acknowledged"
    await rig.passes(20)
    assert notice(rig) == ("unconfirmed", "Treatment on North, Weeder 01. Not acknowledged.")


async def test_it_is_withdrawn_at_the_end_and_taken_off_the_broker(rig: SensorRig) -> None:
    await rig.accepted()
    rig.weeder(OrderStatus.RUNNING)
    await rig.passes(5)
    rig.answers(rig.told(Down.NOTICE)[-1].id)
    rig.weeder(OrderStatus.DONE)
    await rig.passes(5)
    over = rig.told(Down.NOTICE)[-1]
    assert (over.is_treating, over.robots, over.parcel) == (False, [], "")
    assert notice(rig) == ("sent", "Treatment on North, Weeder 01, over")
    rig.answers(over.id)
    await rig.passes(5)
    assert notice(rig) is None
    assert rig.told(Down.NOTICE)[-1] is None


async def test_a_station_that_never_answers_is_let_go_when_its_notice_has_ended_by_itself(rig: SensorRig) -> None:
    await rig.accepted()
    rig.weeder(OrderStatus.RUNNING)
    await rig.passes(5)
    rig.weeder(None)
    await rig.passes(300)
    assert notice(rig) == ("unconfirmed", "Treatment on North, Weeder 01, over. Not acknowledged.")
    await rig.passes(310)
    assert notice(rig) is None


async def test_without_a_broker_nothing_is_sent_later_than_it_is_true(rig: SensorRig) -> None:
    await rig.accepted()
    await rig.passes(5)
    rig.link.is_up = False
    rig.weeder(OrderStatus.RUNNING)
    await rig.passes(60)
    assert notice(rig) == ("unconfirmed", "Treatment on North, Weeder 01. No link to the broker: not sent.")
    rig.link.is_up = True
    await rig.passes(5)
    [told] = [one for one in rig.told(Down.NOTICE) if one is not None]
    assert told.utc == rig.clock.utc()


async def test_a_pause_on_the_field_is_still_treatment_and_going_home_in_it_too(rig: SensorRig) -> None:
    await rig.accepted()
    rig.weeder(OrderStatus.RUNNING)
    await rig.passes(5)
    rig.answers(rig.told(Down.NOTICE)[-1].id)
    rig.weeder(OrderStatus.PAUSED, OUTSIDE)
    await rig.passes(30)
    assert notice(rig) == ("acknowledged", "Treatment on North, Weeder 01")


async def test_what_a_console_before_us_left_at_the_broker_is_taken_away_once(rig: SensorRig) -> None:
    await rig.accepted()
    await rig.passes(30)
    assert rig.told(Down.NOTICE) == [None]


# ---- alarms ----


def alarms(rig: SensorRig) -> dict[str, list[str]]:
    """Return the codes that hold, by source."""
    found = rig.work.findings()
    assert all(one.code in catalogue() for _, findings in found.values() for one in findings)
    return {source: [one.code for one in findings] for source, (_name, findings) in found.items()}


async def test_silence_battery_clock_and_nonsense_are_alarms_of_the_station(rig: SensorRig) -> None:
    await rig.accepted()
    rig.measures(soil_moisture_10=0.9, battery=0.1)
    assert alarms(rig) == {"station-soil-03": ["station-battery", "value-implausible"]}
    rig.clock.advance(1801)
    assert alarms(rig) == {"station-soil-03": ["station-silent"]}
    [finding] = rig.work.findings()["station-soil-03"][1]
    assert finding.text == "Nothing for 30 min. Battery 10% when last heard."


async def test_a_station_that_nobody_took_in_raises_nothing(rig: SensorRig) -> None:
    rig.says(rig.about(), is_retained=True)
    rig.measures(soil_moisture_10=0.9, battery=0.01)
    assert alarms(rig) == {}


async def test_weather_beyond_the_limit_is_an_alarm_only_while_somebody_treats(rig: SensorRig) -> None:
    await rig.accepted("weather-01", "weather")
    await rig.accepted()
    limits = [
        SensorLimit(Channel("wind_speed"), high=5.0, is_treatment=True), SensorLimit(Channel("soil_moisture"), high=0.3)
    ]  # fmt: skip
    await rig.work.book.set_limits(rig.person(Role.PLANNER), limits)
    rig.measures("weather-01", wind_speed=6.1, rain_rate=0.0)
    rig.measures(soil_moisture_10=0.35)
    await rig.passes(5)
    assert alarms(rig) == {}
    rig.weeder(OrderStatus.RUNNING)
    await rig.passes(5)
    for station in ("weather-01", "soil-03"):
        rig.answers(rig.told(Down.NOTICE, station)[-1].id, station)
    assert alarms(rig) == {"station-weather-01": ["weather-over-limit"], "station-soil-03": ["soil-too-wet"]}
    texts = [one.text for _, findings in rig.work.findings().values() for one in findings]
    assert texts == ["Wind 6.1 m/s, limit 5.0. At work: Weeder 01.", "Soil 10 cm 35 %, limit 30. At work: Weeder 01."]


async def test_a_value_that_got_silent_raises_nothing_though_its_station_is_heard(rig: SensorRig) -> None:
    await rig.accepted()
    await rig.work.book.set_limits(rig.person(Role.PLANNER), [SensorLimit(Channel("soil_moisture"), high=0.3)])
    rig.weeder(OrderStatus.RUNNING)
    rig.measures(soil_moisture_10=0.9, soil_moisture_30=0.35)
    await rig.passes(5)
    rig.answers(rig.told(Down.NOTICE)[-1].id)
    assert alarms(rig) == {"station-soil-03": ["value-implausible", "soil-too-wet"]}
    for _ in range(4):
        rig.clock.advance(60)
        rig.measures(soil_temperature_10=11.0)
    assert alarms(rig) == {}
    seen = rig.work.condition_of("station-soil-03")
    assert seen is not None
    assert (seen.implausible, rig.shown()["sentence"]) == ((), "")


async def test_a_notice_that_is_not_acknowledged_is_an_alarm(rig: SensorRig) -> None:
    await rig.accepted()
    rig.measures(soil_moisture_10=0.2)
    rig.weeder(OrderStatus.RUNNING)
    await rig.passes(25)
    assert alarms(rig) == {"station-soil-03": ["notice-unconfirmed"]}
    seen = rig.work.condition_of("station-soil-03")
    assert seen is not None
    assert (seen.name, seen.is_clock_wrong) == ("Soil 3", False)
    assert rig.work.condition_of("weeder-01") is None


async def test_the_guided_check_of_a_silent_station_looks_at_it_and_at_the_others(rig: SensorRig) -> None:
    await rig.accepted()
    await rig.accepted("soil-04")
    rig.measures(soil_moisture_10=0.2, battery=0.09)
    rig.clock.advance(7200)
    rig.measures("soil-04", soil_moisture_10=0.2)
    scene = Scene(rig.clock.mono_s(), None, station=rig.work.condition_of("station-soil-03"))
    found = diagnose(catalogue()["station-silent"].diagnosis, scene)
    assert [(one["found"], one["ok"]) for one in found["steps"]] == [
        ("Yes.", True), ("Last 2 h 00 ago.", False), ("1 of 1 are heard.", True), ("9 %.", False)
    ]  # fmt: skip
    assert found["conclusion"] == "The station itself is silent: look at its power and its radio."
    blind = diagnose(catalogue()["station-clock"].diagnosis, Scene(0.0, None))
    assert {one["ok"] for one in blind["steps"]} == {None}
