"""Stations as screens show them: who they are, how old what they say is, what is wrong."""

from __future__ import annotations

from datetime import timedelta
from pathlib import Path

import pytest
from msgspec.structs import replace as replace_struct

from backend_clients.field.codec import encode
from backend_clients.field.topics import Down, Up, topic
from hmi.app.sensor_weather import feed_weather
from hmi.clock import FakeClock
from hmi.commands.weather import WeatherBoard
from hmi.domain.queue.facts import Weather
from hmi.domain.role import Role
from hmi.domain.sensors.calibration import Calibration
from hmi.domain.sensors.gate import GateState, gate
from hmi.domain.sensors.limit import SensorLimit
from hmi.domain.sensors.observation import SensorKind
from hmi.domain.sensors.quantity import Channel
from hmi.domain.sensors.station import FieldStation, Report
from hmi.store import machine_boot
from hmi.store.sensor_board import SensorBoard
from tests.hmi.sensors.rig import PARCEL, SensorRig

MOISTURE = Channel("soil_moisture", 10)


def values(rig: SensorRig, station: str = "soil-03") -> dict[str, float]:
    """Return the values a screen shows, by key."""
    return {one["key"]: one["value"] for one in rig.shown(station)["values"]}


async def test_a_new_station_shows_what_it_says_and_is_not_recorded_before_it_is_accepted(rig: SensorRig) -> None:
    rig.says(rig.about(), is_retained=True)
    rig.measures(soil_moisture_10=0.213, soil_temperature_10=11.26, battery=0.8)
    shown = rig.shown()
    assert (shown["name"], shown["is_accepted"], shown["state"], shown["battery"]) == ("Soil 3", False, "fresh", 0.8)
    assert values(rig) == {"soil_moisture@0.10": 21, "soil_temperature@0.10": 11.3}
    assert [one["label"] for one in shown["values"]] == ["Soil 10 cm", "Soil temperature 10 cm"]
    assert shown["sentence"] == "New here: it is not recorded before it is accepted."
    rig.work.history.flush()
    assert not rig.work.history.has_any("soil-03")


async def test_a_station_gets_older_before_ones_eyes(rig: SensorRig) -> None:
    await rig.accepted()
    rig.measures(soil_moisture_10=0.2, battery=0.09)
    assert rig.shown()["sentence"] == "Battery 9 %."
    await rig.passes(150)
    assert (rig.shown()["state"], rig.shown()["values"][0]["state"]) == ("late", "late")
    await rig.passes(6 * 3600 - 150, 60)
    shown = rig.shown()
    assert (shown["state"], shown["age_s"]) == ("silent", 6 * 3600)
    assert shown["sentence"] == "Soil 3 silent for 6 h. Battery 9 % when last heard."


async def test_screens_are_told_of_a_state_that_changed_and_not_of_each_value(rig: SensorRig) -> None:
    await rig.accepted()
    for _ in range(5):
        rig.measures(soil_moisture_10=0.2)
    rig.work._tell()
    before = len(rig.events)
    assert rig.events[-1] == {"kind": "sensors"}
    rig.measures(soil_moisture_10=0.21)
    assert len(rig.events) == before


async def test_after_a_restart_the_last_values_show_their_true_age(rig: SensorRig) -> None:
    await rig.accepted()
    rig.measures(soil_moisture_10=0.2, battery=0.5)
    await rig.passes(120)
    await rig.restart()
    shown = rig.shown()
    assert (shown["state"], shown["is_accepted"], shown["battery"]) == ("late", True, 0.5)
    assert shown["values"][0]["age_s"] == pytest.approx(120, abs=1)


@pytest.mark.parametrize("behind_s", [120.0, 7 * 3600.0])
async def test_after_a_restart_with_the_clock_behind_nothing_that_is_kept_counts_as_measured_now(
    rig: SensorRig, behind_s: float
) -> None:
    await rig.accepted()
    rig.measures(soil_moisture_10=0.2)
    await rig.passes(3600)
    rig.clock.jump_wall(-3600 - behind_s)
    await rig.restart()
    board = rig.work.board
    board.limits = [SensorLimit(MOISTURE, None, 0.35, is_treatment=True)]
    assert (rig.shown()["state"], rig.shown()["values"]) == ("late", [])
    assert gate(board.limits, board.measured()).state is GateState.UNKNOWN
    rig.measures(seq=2, soil_moisture_10=0.21)
    assert gate(board.limits, board.measured()).state is GateState.OPEN


async def test_a_station_that_stays_dead_over_a_restart_with_the_clock_behind_is_silent(rig: SensorRig) -> None:
    await rig.accepted()
    rig.measures(soil_moisture_10=0.2)
    rig.clock.jump_wall(-1800)
    await rig.restart()
    rig.clock.jump_wall(8 * 3600)  # set right
    await rig.passes(3600, 60)
    assert rig.shown()["state"] == "silent"
    assert [one.code for _, found in rig.work.findings().values() for one in found] == ["station-silent"]


async def test_a_station_that_was_removed_hides_none_of_the_others(rig: SensorRig) -> None:
    await rig.accepted()
    rig.measures(soil_moisture_10=0.2)
    rig.work.history.see("gone-01", MOISTURE, rig.clock.utc() + timedelta(days=30), 0.2)
    await rig.restart()
    assert values(rig) == {"soil_moisture@0.10": 20}


@pytest.mark.parametrize("saved_s", [0.0, 90.0])
async def test_after_the_machine_was_off_what_was_kept_opens_no_gate_before_the_station_speaks(
    rig: SensorRig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, saved_s: float
) -> None:
    def judged() -> GateState:
        return gate([SensorLimit(MOISTURE, None, 0.35, is_treatment=True)], rig.work.board.measured()).state

    boot = tmp_path / "boot_id"
    monkeypatch.setattr(machine_boot, "BOOT_ID", boot)
    boot.write_text("one\n")
    await rig.restart()
    await rig.accepted()
    await rig.passes(100)
    rig.measures(soil_moisture_10=0.2)
    await rig.passes(20)
    await rig.restart()
    assert judged() is GateState.OPEN, "the console alone began again"
    boot.write_text("two\n")  # the machine was off for hours, and its clock went on where it was saved last
    rig.clock.jump_wall(-saved_s)
    await rig.passes(40)
    await rig.restart()
    assert judged() is GateState.UNKNOWN
    await rig.passes(60)
    await rig.restart()
    assert judged() is GateState.UNKNOWN, "nor does it once the console begins again"
    rig.measures(seq=2, soil_moisture_10=0.21)
    assert judged() is GateState.OPEN
    await rig.passes(20)
    await rig.restart()
    assert judged() is GateState.OPEN
    boot.unlink()
    await rig.restart()
    assert judged() is GateState.UNKNOWN, "where it is not known, nothing that is kept counts"


async def test_the_weather_of_the_queue_takes_no_wind_of_before_the_machine_was_off() -> None:
    clock, wind, told = FakeClock(), Channel("wind_speed"), list[Weather]()
    board = SensorBoard(clock, lambda *_: None)
    weather = WeatherBoard(clock, lambda *_: None, "hof")  # type: ignore[arg-type]  # nobody reports by hand
    about = FieldStation("wx", "Wx", SensorKind.WEATHER, 52.0, 5.0, 60.0, {wind: "m/s"}, is_accepted=True)
    board.load([about], [], [], [("wx", wind, clock.utc() - timedelta(seconds=30), 2.0)])
    weather.take = told.append  # type: ignore[assignment,method-assign]
    feed_weather(board, weather, clock)
    assert not told
    board.reported(Report("wx", "boot-0001", 1, clock.utc(), ((wind, 3.0),), None), clock.mono_s())
    feed_weather(board, weather, clock)
    assert [one.wind_mps for one in told] == [3.0]


async def test_a_repeat_changes_nothing_and_what_is_late_only_fills_the_history(rig: SensorRig) -> None:
    await rig.accepted()
    start = rig.clock.utc()
    await rig.passes(600)
    rig.measures(seq=9, soil_moisture_10=0.3)
    rig.measures(seq=9, soil_moisture_10=0.1)
    rig.measures(seq=4, at=start, soil_moisture_10=0.2)
    assert values(rig)["soil_moisture@0.10"] == 30
    rig.work.history.flush()
    kept = rig.work.history.points("soil-03", MOISTURE, start - timedelta(days=1))
    assert [(one.at, one.mean) for one in kept] == [(start, 0.2), (start + timedelta(seconds=600), 0.3)]
    counts = rig.work.diagnostics()["dropped"]
    assert (counts["repeated"], counts["late"]) == (1, 1)


async def test_a_clock_that_is_behind_makes_values_look_old_and_says_so(rig: SensorRig) -> None:
    await rig.accepted()
    for _ in range(3):
        rig.measures(at=rig.clock.utc() - timedelta(minutes=40), soil_moisture_10=0.2)
        await rig.passes(60)
    shown = rig.shown()
    assert shown["state"] == "silent"
    assert "Its clock is 40 min behind, or its values come so late: they count as old." in shown["sentence"]


async def test_a_clock_that_leaps_is_told_as_the_reason_why_values_do_not_count(rig: SensorRig) -> None:
    await rig.accepted()
    for ahead_s in (0, 0, 7200):
        rig.measures(at=rig.clock.utc() + timedelta(seconds=ahead_s), soil_moisture_10=0.2)
        await rig.passes(60)
    leapt = "Its clock was set, or its values waited: they count from the next ones on."
    assert leapt in rig.shown()["sentence"]
    for _ in range(2):
        rig.measures(soil_moisture_10=0.2)
    assert rig.shown()["sentence"] == ""


async def test_a_clock_that_is_ahead_is_noticed_and_its_values_keep_their_age(rig: SensorRig) -> None:
    await rig.accepted()
    for _ in range(3):
        rig.measures(at=rig.clock.utc() + timedelta(hours=3), soil_moisture_10=0.2)
        await rig.passes(60)
    shown = rig.shown()
    assert (shown["state"], shown["sentence"]) == ("fresh", "Its clock is 3 h ahead.")
    await rig.passes(1900, 60)
    assert rig.shown()["state"] == "silent"


async def test_what_cannot_be_is_shown_as_such_and_neither_kept_nor_judged(rig: SensorRig) -> None:
    await rig.accepted()
    rig.measures(soil_moisture_10=0.95)
    [value] = rig.shown()["values"]
    assert (value["value"], value["is_plausible"], value["is_over"]) == (95, False, False)
    assert rig.shown()["sentence"] == "Soil 10 cm 95 % cannot be true."
    rig.work.history.flush()
    assert not rig.work.history.has_any("soil-03")


async def test_values_in_another_unit_than_the_wire_has_are_not_taken(rig: SensorRig) -> None:
    about = rig.about("weather-02", "weather")
    wrong = encode(about).replace(b'"m/s"', b'"km/h"')
    rig.hears(topic("weather-02", Up.ABOUT), wrong, is_retained=True)
    rig.measures("weather-02", wind_speed=20.0, rain_rate=0.0)
    assert values(rig, "weather-02") == {"rain_rate": 0.0}
    assert rig.work.diagnostics()["refused"]["wrong_unit"] == 1
    assert rig.work.diagnostics()["dropped"]["unannounced"] == 1


async def test_what_a_station_announces_no_longer_is_gone(rig: SensorRig) -> None:
    await rig.accepted("weather-01", "weather")
    rig.measures("weather-01", wind_speed=93.0, rain_rate=0.0)
    assert rig.shown("weather-01")["sentence"] == "Wind 93.0 m/s cannot be true."
    about = rig.about("weather-01", "weather")
    rig.says(replace_struct(about, quantities=[one for one in about.quantities if one.quantity != "wind_speed"]))
    rig.measures("weather-01", rain_rate=0.0)
    assert (values(rig, "weather-01"), rig.shown("weather-01")["sentence"]) == ({"rain_rate": 0.0}, "")
    assert rig.work.findings() == {}
    rig.work.board.fill([("weather-01", Channel("wind_speed"), rig.clock.utc(), 3.0)])
    assert values(rig, "weather-01") == {"rain_rate": 0.0}


async def test_a_calibration_holds_from_the_next_value_on(rig: SensorRig) -> None:
    await rig.accepted()
    rig.measures(soil_moisture_10=0.2)
    planner = rig.person(Role.PLANNER)
    await rig.work.book.calibrate(planner, Calibration("soil-03", MOISTURE, 0.05, 1.1, "Oven dried"))
    assert values(rig)["soil_moisture@0.10"] == 20
    rig.measures(soil_moisture_10=0.2)
    assert values(rig)["soil_moisture@0.10"] == 27
    await rig.restart()
    rig.measures(soil_moisture_10=0.3)
    assert values(rig)["soil_moisture@0.10"] == 38


async def test_a_trend_is_told_once_an_hour_is_known(rig: SensorRig) -> None:
    await rig.accepted("weather-01", "weather")
    trends = []
    for minute in range(0, 71, 10):
        rig.measures("weather-01", air_temperature=10 + minute / 20)
        trends.append(rig.shown("weather-01")["values"][0]["trend"])
        await rig.passes(600, 60)
    assert trends == [None, None, None, None, None, "up", "up", "up"]


async def test_a_calibration_is_no_trend(rig: SensorRig) -> None:
    await rig.accepted("weather-01", "weather")
    for _ in range(7):
        rig.measures("weather-01", air_temperature=10.0)
        await rig.passes(600, 60)
    planner = rig.person(Role.PLANNER)
    await rig.work.book.calibrate(planner, Calibration("weather-01", Channel("air_temperature"), 3.0, 1.0, ""))
    rig.measures("weather-01", air_temperature=10.0)
    assert (values(rig, "weather-01"), rig.shown("weather-01")["values"][0]["trend"]) == (
        {"air_temperature": 13.0},
        None,
    )


async def test_a_limit_without_a_depth_holds_for_every_depth_that_has_none_of_its_own(rig: SensorRig) -> None:
    await rig.accepted()
    limits = [SensorLimit(Channel("soil_moisture"), high=0.4), SensorLimit(MOISTURE, high=0.3)]
    await rig.work.book.set_limits(rig.person(Role.PLANNER), limits)
    rig.measures(soil_moisture_10=0.35, soil_moisture_30=0.35)
    shown = {one["key"]: (one["limit"]["high"], one["is_over"]) for one in rig.shown()["values"]}
    assert shown == {"soil_moisture@0.10": (30, True), "soil_moisture@0.30": (40, False)}
    assert {one["limit"]["is_treatment"] for one in rig.shown()["values"]} == {False}


async def test_a_station_that_is_taken_out_and_still_heard_is_a_new_one(rig: SensorRig) -> None:
    await rig.accepted()
    rig.measures(soil_moisture_10=0.2)
    await rig.work.book.remove(rig.person(Role.ADMIN), "soil-03")
    shown = rig.shown()
    assert (shown["is_accepted"], shown["state"]) == (False, "fresh")
    await rig.work._keep()
    await rig.restart()
    assert rig.work.board.all() == []


async def test_a_silent_station_that_is_taken_out_is_gone_and_comes_back_as_a_new_one(rig: SensorRig) -> None:
    await rig.accepted()
    rig.measures(soil_moisture_10=0.2)
    rig.clock.advance(3600)
    await rig.work.book.remove(rig.person(Role.ADMIN), "soil-03")
    assert rig.work.board.get("soil-03") is None
    rig.says(rig.about(), is_retained=True)
    assert not rig.shown()["is_accepted"]


async def test_what_people_named_stays_whatever_the_station_says_later(rig: SensorRig) -> None:
    await rig.accepted(name="Probe 77")
    from hmi.commands.sensor_book import StationWish

    await rig.work.book.change(rig.person(Role.PLANNER), "soil-03", StationWish("By the oak", "", 52.001, 5.001))
    rig.says(rig.about(name="Probe 77", period_s=600.0), is_retained=True)
    shown = rig.shown()
    assert (shown["name"], shown["parcel"], shown["lat_deg"], shown["period_s"]) == ("By the oak", None, 52.001, 600)
    await rig.restart()
    assert rig.shown()["name"] == "By the oak"


async def test_each_act_stands_in_the_audit(rig: SensorRig) -> None:
    await rig.accepted()
    planner = rig.person(Role.PLANNER)
    await rig.work.book.calibrate(planner, Calibration("soil-03", MOISTURE, 0.0, 1.2, "Compared"))
    await rig.work.book.set_limits(planner, [SensorLimit(Channel("wind_speed"), high=5.0, is_treatment=True)])
    await rig.work.book.set_limits(planner, [])
    await rig.work.book.remove(planner, "soil-03")
    lines = [(one.outcome, one.text) for one in await rig.audited("sensor")]
    assert lines == [
        ("accepted", "Station Soil 3 belongs to the farm."),
        ("calibrated", "Soil 3, Soil 10 cm: times 1.2, plus 0. Compared"),
        ("limit", "Wind: treatment limit at most 5.0 m/s."),
        ("limit", "Wind: no limit any more."),
        ("removed", "Station Soil 3 is taken out."),
    ]


async def test_nobody_can_flood_the_board_with_invented_stations(rig: SensorRig) -> None:
    for number in range(250):
        rig.says(rig.about(f"probe-{number}"), is_retained=True)
    assert len(rig.work.board.all()) == 200
    assert rig.work.diagnostics()["dropped"]["too_many"] == 50


WRONG: list[tuple[Up, bytes, str]] = [
    (Up.DATA, b"\xff\xfe", "malformed"),
    (Up.DATA, b'{"station":"soil-03"}', "malformed"),
    (Up.DATA, b"[" * 16_000, "malformed"),
    (Up.DATA, b"x" * 20_000, "oversized"),
    (Up.FRAME, b"GIF89a", "malformed"),
    (Up.FRAME, b"\xff\xd8\xff" + b"x" * 600_000, "oversized"),
    (Up.ACK, b'{"station":"soil-04","id":"12345678","outcome":"accepted","text":""}', "wrong_identity"),
    (Up.ABOUT, b"null", "malformed"),
]


async def test_nothing_a_station_sends_ends_the_connection_and_all_of_it_is_counted(rig: SensorRig) -> None:
    for kind, payload, reason in WRONG:
        before = rig.work.diagnostics()["refused"].get(reason, 0)
        rig.hears(topic("soil-03", kind), payload)
        assert rig.work.diagnostics()["refused"][reason] == before + 1
    await rig.accepted()
    assert rig.shown()["name"] == "Soil 3"


async def test_a_topic_of_the_console_or_of_nobody_is_counted(rig: SensorRig) -> None:
    rig.hears(topic("soil-03", Down.NOTICE), b"{}")
    rig.hears("headland/v1/weeder-01/state", b"{}")
    assert rig.work.diagnostics()["refused"] == {"bad_topic": 2}


async def test_a_station_that_takes_its_announcement_back_goes_unless_it_belongs_here(rig: SensorRig) -> None:
    rig.says(rig.about("soil-08"), is_retained=True)
    await rig.accepted("soil-09")
    for station in ("soil-08", "soil-09"):
        rig.hears(topic(station, Up.ABOUT), b"")
    assert [one.station.id for one in rig.work.board.all()] == ["soil-09"]


async def test_data_that_the_broker_kept_is_nobodys_newest(rig: SensorRig) -> None:
    await rig.accepted()
    from backend_clients.field import messages as m

    old = m.Data(station="soil-03", boot="boot-000009", seq=1, utc=rig.clock.utc(), values=[])
    rig.says(old, is_retained=True)
    assert rig.shown()["state"] == "never"
    assert rig.work.diagnostics()["refused"] == {"retained": 1}


async def test_a_dead_network_thread_is_started_again(rig: SensorRig) -> None:
    rig.link.is_alive = False
    rig.work.link.look_after()
    assert (rig.link.is_alive, rig.link.starts) == (True, 2)


async def test_the_parcel_that_a_station_names_is_known_by_name_or_id(rig: SensorRig) -> None:
    await rig.accepted(parcel="north")
    await rig.accepted("soil-04", parcel="North")
    await rig.accepted("soil-05", parcel="Nowhere")
    assert [rig.shown(one)["parcel"] for one in ("soil-03", "soil-04", "soil-05")] == [PARCEL, PARCEL, None]
    assert rig.shown()["parcel_name"] == "North"
