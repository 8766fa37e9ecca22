"""Field sensors over REST: who may, what a screen gets, what is refused with which sentence."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from datetime import timedelta
from types import SimpleNamespace
from typing import Any

import pytest

from backend_clients.field.topics import Down, Up, topic
from hmi.commands.camera_source_book import SourceWish
from hmi.domain.camera import SourceKind
from hmi.domain.mission import MissionStatus
from hmi.domain.robot import OrderStatus
from hmi.domain.role import Permission, Role, may
from hmi.domain.sensors.quantity import Channel
from hmi.domain.sensors.series import Point
from hmi.store.pictures import PictureFilter
from tests.hmi.commands.field import FARM
from tests.hmi.pictures.jpeg import picture
from tests.hmi.sensors.rig import PARCEL, SensorRig

P = Permission
CALIBRATION = {"quantity": "soil_moisture", "depth_m": 0.1, "offset": 2.0, "gain": 1.1, "note": "Oven dried"}
WIND = {"quantity": "wind_speed", "low": None, "high": 5.0, "is_treatment": True, "note": ""}
ROUTES: list[tuple[str, str, Any, Permission]] = [
    ("GET", "/sensors", None, P.WATCH),
    ("GET", "/sensors/soil-03/series?quantity=soil_moisture&depth_m=0.1", None, P.WATCH),
    ("GET", "/sensors/soil-03/calibration", None, P.WATCH),
    ("GET", "/sensor-limits", None, P.WATCH),
    ("POST", "/sensors/soil-03/accept", {}, P.MANAGE_SENSORS),
    ("PUT", "/sensors/soil-03", {"name": "Soil 3", "parcel": "north"}, P.MANAGE_SENSORS),
    ("PUT", "/sensors/soil-03/calibration", CALIBRATION, P.MANAGE_SENSORS),
    ("PUT", "/sensor-limits", {"limits": [WIND]}, P.MANAGE_SENSORS),
    ("POST", "/sensors/soil-03/trigger", None, P.TRIGGER_SENSOR),
    ("DELETE", "/sensors/soil-03", None, P.MANAGE_SENSORS),
]


@pytest.mark.parametrize("role", list(Role))
async def test_each_role_may_exactly_what_the_table_says(rig: SensorRig, role: Role) -> None:
    await rig.accepted()
    wrong = []
    async with rig.browser(role) as client:
        for method, path, body, permission in ROUTES:
            answer = await client.request(method, path, json=body)
            is_refused = answer.status_code == 403 and answer.json()["code"] == "not_allowed"
            if is_refused == may(role, permission) or (answer.status_code >= 400 and not is_refused):
                wrong.append((method, path, answer.status_code, answer.text))
        can = (await client.get("/sensors")).json()["can"]
    assert wrong == []
    assert can["accept"] == can["limits"] == can["calibrate"] == may(role, P.MANAGE_SENSORS)
    assert can["trigger"] == may(role, P.TRIGGER_SENSOR)


async def test_nobody_gets_anywhere_without_signing_in(rig: SensorRig) -> None:
    async with rig.browser(None) as client:
        for method, path, body, _permission in ROUTES:
            assert (await client.request(method, path, json=body)).status_code == 401, path


async def test_planners_set_limits_in_the_units_of_the_screen(rig: SensorRig) -> None:
    soil = {"quantity": "soil_moisture", "depth_m": 0.3, "low": None, "high": 38, "is_treatment": False, "note": "Ruts"}
    async with rig.browser(Role.PLANNER) as client:
        told = (await client.put("/sensor-limits", json={"limits": [soil, WIND]})).json()
        assert told == (await client.get("/sensor-limits")).json()
    assert [(one["label"], one["unit"], one["high"], one["by"]) for one in told] == [
        ("Wind", "m/s", 5.0, "Planner Person"), ("Soil 30 cm", "%", 38, "Planner Person")
    ]  # fmt: skip
    assert rig.work.board.limits[0].high == pytest.approx(0.38)
    await rig.restart()
    assert len(rig.work.board.limits) == 2


async def test_who_set_a_limit_stays_when_another_one_is_changed(rig: SensorRig) -> None:
    async with rig.browser(Role.PLANNER) as client:
        await client.put("/sensor-limits", json={"limits": [WIND]})
    rain = {**WIND, "quantity": "rain_rate", "high": 0.5}
    async with rig.browser(Role.ADMIN) as client:
        told = (await client.put("/sensor-limits", json={"limits": [WIND, rain]})).json()
    assert {one["label"]: one["by"] for one in told} == {"Wind": "Planner Person", "Rain": "Admin Person"}


async def test_limits_that_somebody_changed_meanwhile_are_not_written_over(rig: SensorRig) -> None:
    rain = {**WIND, "quantity": "rain_rate", "high": 0.5}
    async with rig.browser(Role.PLANNER) as client:
        first = await client.put("/sensor-limits", json={"limits": [WIND], "revision": ""})
        seen = first.json()[0]["revision"]
        second = await client.put("/sensor-limits", json={"limits": [WIND, rain], "revision": seen})
        assert (first.status_code, second.status_code) == (200, 200)
        for old in (seen, ""):
            late = await client.put("/sensor-limits", json={"limits": [{**WIND, "high": 6}], "revision": old})
            assert (late.status_code, late.json()["text"]) == (
                409, "Somebody changed the limits meanwhile. Look again."
            )  # fmt: skip
        assert (await client.get("/sensor-limits")).json() == second.json()


async def test_a_station_that_somebody_changed_meanwhile_is_not_written_over(rig: SensorRig) -> None:
    await rig.accepted()
    async with rig.browser(Role.PLANNER) as client:
        seen = next(one for one in (await client.get("/sensors")).json()["stations"] if one["id"] == "soil-03")
        wish = {"parcel": None, "revision": seen["revision"]}
        first = await client.put("/sensors/soil-03", json={**wish, "name": "By the pond"})
        late = await client.put("/sensors/soil-03", json={**wish, "name": "By the gate"})
        assert (first.status_code, late.status_code) == (200, 409)
        assert late.json()["text"] == "Somebody changed By the pond meanwhile. Look again."
        again = await client.put(
            "/sensors/soil-03", json={**wish, "name": "By the gate", "revision": first.json()["revision"]}
        )
        assert again.json()["name"] == "By the gate"


async def test_a_station_is_accepted_without_the_field_that_it_says_itself(rig: SensorRig) -> None:
    rig.says(rig.about(parcel="north"))
    async with rig.browser(Role.PLANNER) as client:
        told = (await client.post("/sensors/soil-03/accept", json={"name": "Soil 3", "parcel": ""})).json()
    assert told["parcel"] is None


@pytest.mark.parametrize(
    ("limits", "field", "text"),
    [
        ([{**WIND, "high": None}], "limits.0.high", "Wind: say the lowest or the highest value."),
        ([{**WIND, "low": 7}], "limits.0.low", "Wind: the lowest value must be below the highest."),
        ([{**WIND, "high": 200}], "limits.0.high", "Wind: 200.0 m/s never happens."),
        ([WIND, {**WIND, "high": 6}], "limits.1.high", "Wind has two limits. Keep one."),
    ],
)
async def test_a_limit_that_makes_no_sense_names_its_input(
    rig: SensorRig, limits: list[Any], field: str, text: str
) -> None:
    async with rig.browser(Role.PLANNER) as client:
        answer = await client.put("/sensor-limits", json={"limits": limits})
    assert (answer.status_code, answer.json()["field"], answer.json()["text"]) == (422, field, text)
    assert rig.work.board.limits == []


@pytest.mark.parametrize(
    ("body", "field"),
    [
        ({**CALIBRATION, "gain": 0.0}, "gain"),
        ({**CALIBRATION, "offset": 99.0}, "offset"),
        ({**CALIBRATION, "depth_m": 0.6}, "quantity"),
        ({**CALIBRATION, "quantity": "co2", "depth_m": None}, "quantity"),
    ],
)
async def test_a_calibration_that_makes_no_sense_names_its_input(
    rig: SensorRig, body: dict[str, Any], field: str
) -> None:
    await rig.accepted()
    async with rig.browser(Role.PLANNER) as client:
        answer = await client.put("/sensors/soil-03/calibration", json=body)
    assert (answer.status_code, answer.json()["field"]) == (422, field)


async def test_calibrations_come_newest_first_with_who_and_when(rig: SensorRig) -> None:
    await rig.accepted()
    async with rig.browser(Role.PLANNER) as client:
        await client.put("/sensors/soil-03/calibration", json=CALIBRATION)
        told = (await client.put("/sensors/soil-03/calibration", json={**CALIBRATION, "gain": 1.0, "note": ""})).json()
    assert [(one["offset"], one["gain"], one["note"], one["by"]) for one in told] == [
        (2.0, 1.0, "", "Planner Person"), (2.0, 1.1, "Oven dried", "Planner Person")
    ]  # fmt: skip


async def test_a_station_or_parcel_that_is_not_there_is_said(rig: SensorRig) -> None:
    rig.says(rig.about(), is_retained=True)
    async with rig.browser(Role.PLANNER) as client:
        gone = await client.post("/sensors/soil-99/accept", json={})
        nowhere = await client.post("/sensors/soil-03/accept", json={"parcel": "south"})
        new = await client.put("/sensors/soil-03", json={"name": "Soil", "parcel": None})
    assert (gone.status_code, gone.json()["code"]) == (404, "unknown_station")
    assert (nowhere.status_code, nowhere.json()["field"]) == (422, "parcel")
    assert nowhere.json()["text"] == "There is no parcel south on the map."
    assert (new.status_code, new.json()["text"]) == (409, "Soil 3 is new here. Accept it first.")


async def test_the_gate_says_what_treatment_waits_for(rig: SensorRig) -> None:
    async def gate() -> Any:
        return (await client.get("/sensors")).json()["gate"]

    await rig.accepted("weather-01", "weather")
    async with rig.browser(Role.PLANNER) as client:
        assert await gate() == {"state": "open", "sentence": "No treatment limits are set.", "facts": []}
        await client.put("/sensor-limits", json={"limits": [WIND, {**WIND, "quantity": "rain_rate", "high": 0.5}]})
        assert (await gate())["sentence"] == "Rain: no station measures it: waits"
        rig.measures("weather-01", wind_speed=6.1, rain_rate=0.0)
        found = await gate()
        assert (found["state"], found["sentence"]) == ("waits", "Wind 6.1 m/s, limit 5.0: waits")
        assert found["facts"][1] == {"label": "Wind", "text": "6.1 m/s, limit 5.0", "ok": False}
        rig.measures("weather-01", wind_speed=4.0, rain_rate=0.0)
        assert (await gate())["state"] == "open"
        rig.clock.advance(901)
        found = await gate()
        assert (found["state"], found["sentence"]) == ("unknown", "Rain: nothing fresh is known: waits")


async def test_a_chart_has_steps_gaps_limits_and_treatments(rig: SensorRig) -> None:
    await rig.accepted()
    now, channel = rig.clock.utc(), Channel("soil_moisture", 10)
    points = [Point(now - timedelta(hours=hours), 0.2, 0.2, 0.2) for hours in (5, 4, 1)]
    await rig.records.database.run(rig.work.history.put, "soil-03", channel, 600, points)
    async with rig.browser(Role.PLANNER) as client:
        await client.put("/sensor-limits", json={"limits": [{**WIND, "quantity": "soil_moisture", "high": 30}]})
        found = (await client.get("/sensors/soil-03/series?quantity=soil_moisture&depth_m=0.10&span=7d")).json()
    assert (found["unit"], found["step_s"], found["limits"]) == ("%", 3600, {"low": None, "high": 30})
    means = [one[1] for one in found["points"]]
    assert means == [20, 20, None, None, 20, None]
    assert found["treatments"] == []


@pytest.mark.parametrize("name", ["Wheat 1", "Wheat 1, Weeder 01"])
async def test_a_chart_shows_when_the_parcel_was_treated(rig: SensorRig, name: str) -> None:
    from hmi.domain.mission import MissionStatus, Mover

    await rig.accepted()
    missions, run = rig.records.missions, rig.records.database.run
    await run(missions.rename, "farm", "wheat-1", name, "x")
    begin = rig.clock.utc()
    steps = ((MissionStatus.SENT, Mover.PERSON), (MissionStatus.ACCEPTED, Mover.ROBOT),
             (MissionStatus.RUNNING, Mover.ROBOT))  # fmt: skip
    for status, mover in steps:
        await run(missions.move, "farm", "wheat-1", status, mover, "x", "", at=begin)
    rig.weeder(OrderStatus.RUNNING)
    async with rig.browser(Role.VIEWER) as client:
        found = (await client.get("/sensors/soil-03/series?quantity=soil_moisture&depth_m=0.1")).json()
    [treated] = found["treatments"]
    assert (treated["to_utc"], treated["text"]) == (None, "Wheat 1, Weeder 01"), "its robot is named, and once"


@pytest.mark.parametrize("is_heard", [True, False])
async def test_a_chart_shows_no_flight_of_a_uav_as_treatment(
    rig: SensorRig, is_heard: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    from hmi.domain.family import Family
    from hmi.domain.mission import MissionStatus, Mover
    from hmi.domain.planned_machine import MACHINE

    await rig.accepted()
    missions, run = rig.records.missions, rig.records.database.run
    steps = ((MissionStatus.SENT, Mover.PERSON), (MissionStatus.ACCEPTED, Mover.ROBOT),
             (MissionStatus.RUNNING, Mover.ROBOT))  # fmt: skip
    for status, mover in steps:
        await run(missions.move, "farm", "wheat-1", status, mover, "x", "", at=rig.clock.utc())
    rig.weeder(OrderStatus.RUNNING)
    weeder = rig.fleet.robots["weeder-01"]
    if is_heard:
        assert weeder.factsheet is not None
        rig.fleet.robots["weeder-01"] = replace(weeder, factsheet=replace(weeder.factsheet, family=Family.UAV))
    else:
        rig.fleet.robots.clear()
        [flown] = missions.all_known("farm")
        flown = replace(flown, statistics={MACHINE: {"robot_id": "weeder-01", "family": "uav"}})
        monkeypatch.setattr(missions, "all_known", lambda _farm: [flown])
    async with rig.browser(Role.VIEWER) as client:
        found = (await client.get("/sensors/soil-03/series?quantity=soil_moisture&depth_m=0.1")).json()
    assert found["treatments"] == []


@pytest.mark.parametrize("depth", ["deep", "-1", "nan", "30"])
async def test_a_depth_that_is_none_is_refused(rig: SensorRig, depth: str) -> None:
    await rig.accepted()
    async with rig.browser(Role.VIEWER) as client:
        answer = await client.get(f"/sensors/soil-03/series?quantity=soil_moisture&depth_m={depth}")
    assert (answer.status_code, answer.json()["field"]) == (422, "depth_m")


# ---- pictures ----


async def camera(rig: SensorRig) -> None:
    """Take a camera station in."""
    await rig.accepted("multispec-01", "camera", period_s=3600.0)


async def taken(rig: SensorRig, data: bytes | None = None) -> None:
    """Let the camera send a picture, and wait until it is where pictures go."""
    rig.hears(topic("multispec-01", Up.FRAME), data or picture())
    await rig.work.pictures.stop()


async def test_a_picture_of_an_accepted_camera_is_the_newest_frame_of_its_field_camera(rig: SensorRig) -> None:
    await camera(rig)
    data = picture(80, 60)
    await taken(rig, data)
    assert (await rig.desk.frames.newest("multispec-01")).data == data
    shown = rig.shown("multispec-01")
    assert (shown["camera"], shown["pictures_today"], shown["pictures_limit"]) == ("multispec-01", 1, 100)
    (kept,) = (await rig.desk.book.listed(rig.person(Role.VIEWER), PictureFilter(), 5)).pictures
    station = rig.work.board.get("multispec-01").station
    assert (kept.moment.lat_deg, kept.moment.lon_deg) == (station.lat_deg, station.lon_deg), "it stands where it stands"
    await rig.restart()
    assert rig.shown("multispec-01")["pictures_today"] == 1


async def test_pictures_of_others_too_many_or_too_fast_are_counted_and_dropped(rig: SensorRig) -> None:
    await taken(rig)
    await camera(rig)
    for _ in range(5):
        await taken(rig)
    counts = rig.work.pictures.counts
    assert (counts["not_accepted"], counts["taken"], counts["too_often"]) == (1, 3, 2)
    await taken(rig, b"\xff\xd8\xff and no picture")
    for _ in range(120):
        rig.clock.advance(10)
        await taken(rig)
    assert (counts["taken"], counts["too_many"] > 0) == (100, True)
    assert rig.shown("multispec-01")["pictures_today"] == 100
    rig.clock.advance(86_400)
    await taken(rig)
    assert rig.shown("multispec-01")["pictures_today"] == 1


async def test_a_camera_is_expected_as_often_as_it_says_and_may_send_what_it_is_triggered_for(rig: SensorRig) -> None:
    await camera(rig)
    (source,) = rig.desk.sources.field_cameras()
    assert source.period_s == 3600.0
    for _ in range(6):
        rig.clock.advance(6.0)
        await taken(rig)
    assert rig.work.pictures.counts["taken"] == 6


async def test_a_camera_from_before_its_period_counted_follows_it_from_the_next_start_on(rig: SensorRig) -> None:
    await camera(rig)
    await rig.records.database.run(
        rig.records.camera_sources.put, replace(rig.desk.sources.field_cameras()[0], period_s=5.0)
    )
    await rig.desk.sources.load()
    await rig.restart()
    await rig.desk.sources.load()
    assert rig.desk.sources.field_cameras()[0].period_s == 3600.0, "and it is kept"


async def test_a_camera_follows_its_station_that_reports_more_rarely_from_now_on(rig: SensorRig) -> None:
    await camera(rig)
    rig.says(rig.about("multispec-01", "camera", period_s=7200.0))
    await rig.work.pictures.stop()
    assert rig.desk.sources.field_cameras()[0].period_s == 7200.0
    await rig.desk.sources.load()
    assert rig.desk.sources.field_cameras()[0].period_s == 7200.0, "and it is kept"


async def test_a_time_that_an_admin_set_stays_whatever_the_station_says(rig: SensorRig) -> None:
    await camera(rig)
    wish = SourceWish(SourceKind.UPLOAD, period_s=60.0)
    await rig.desk.sources.put(rig.person(Role.ADMIN), "field", "multispec-01", wish)
    rig.says(rig.about("multispec-01", "camera", period_s=7200.0))
    await rig.work.pictures.stop()
    assert rig.desk.sources.field_cameras()[0].period_s == 60.0


async def test_a_snapshot_of_a_stations_camera_says_where_it_stands(rig: SensorRig) -> None:
    await camera(rig)
    await taken(rig)
    kept = await rig.desk.book.snapshot(rig.person(Role.OPERATOR), "field", "multispec-01", "")
    station = rig.work.board.get("multispec-01").station
    assert (kept.moment.lat_deg, kept.moment.lon_deg) == (station.lat_deg, station.lon_deg)


async def test_a_camera_that_is_taken_out_leaves_no_source_behind(rig: SensorRig) -> None:
    await camera(rig)
    await rig.work.book.remove(rig.person(Role.PLANNER), "multispec-01")
    assert rig.desk.sources.field_cameras() == []


async def trigger(rig: SensorRig, answer: tuple[str, str] | None = None) -> dict[str, str]:
    """Ask for a picture; the station answers as told."""
    rig.link.asked.clear()
    async with rig.browser(Role.OPERATOR) as client:
        asking = asyncio.create_task(client.post("/sensors/multispec-01/trigger"))
        if answer is not None:
            await rig.link.asked.wait()
            rig.answers(rig.told(Down.TRIGGER, "multispec-01")[-1].id, "multispec-01", *answer)
        told: dict[str, str] = (await asking).json()
        return told


async def test_a_picture_on_demand_is_told_as_the_station_answered(rig: SensorRig) -> None:
    await camera(rig)
    assert await trigger(rig, ("accepted", "Picture taken.")) == {"outcome": "accepted", "text": "Picture taken."}
    assert await trigger(rig, ("rejected", "Too soon.")) == {"outcome": "rejected", "text": "Too soon."}
    [sent, _] = rig.told(Down.TRIGGER, "multispec-01")
    assert (sent.ttl_s, sent.utc) == (10.0, rig.clock.utc())
    assert all(not retain for address, _, _, retain in rig.link.published if address.kind is Down.TRIGGER)


async def test_without_an_answer_nobody_says_that_it_was_taken(rig: SensorRig) -> None:
    await camera(rig)
    rig.work.trigger._answer_s = 0.01
    told = await trigger(rig)
    assert told["outcome"] == "timed_out"
    assert "may have taken a picture all the same" in told["text"]


async def test_what_cannot_be_asked_for_is_said_at_once(rig: SensorRig) -> None:
    await camera(rig)
    rig.link.is_up = False
    assert await trigger(rig) == {"outcome": "rejected", "text": "No link to the broker. Nothing was sent."}
    await rig.accepted()
    async with rig.browser(Role.OPERATOR) as client:
        answer = await client.post("/sensors/soil-03/trigger")
    assert answer.json() == {"outcome": "rejected", "text": "Soil 3 has no camera."}


@pytest.mark.parametrize("last", [MissionStatus.SENT, MissionStatus.DONE, None])
async def test_a_treatment_ends_when_its_mission_does_or_is_sent_anew(
    rig: SensorRig, monkeypatch: pytest.MonkeyPatch, last: MissionStatus | None
) -> None:
    start = rig.clock.utc()
    steps = [MissionStatus.SENT, MissionStatus.RUNNING, MissionStatus.PAUSED, *([last] if last is not None else [])]
    log = [SimpleNamespace(status=one, at=start + timedelta(minutes=n)) for n, one in enumerate(steps)]
    missions: Any = SimpleNamespace(
        all_known=lambda _farm: [replace(mission, updated_at=start) for mission in known], log=lambda _farm, _id: log
    )
    watch, known = rig.work.treatment, rig.records.missions.all_known(FARM)
    monkeypatch.setattr(watch, "_missions", missions)
    [(begin, end, _)] = await watch.treated(PARCEL, start - timedelta(hours=1))
    assert (begin, end) == (log[1].at, None if last is None else log[3].at)
