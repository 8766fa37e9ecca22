"""What goes to a context broker fits the published schemas, and comes back as it went."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from typing import Any

import httpx
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from jsonschema import ValidationError

from backend_clients.ngsi.client import NgsiClient
from backend_clients.ngsi.connection import Broker
from backend_clients.ngsi.entity import entity_from_wire
from backend_clients.simulator.context_broker.application import make_application
from backend_clients.simulator.context_broker.broker import ContextBroker
from backend_clients.simulator.context_broker.faults import FaultSwitch
from hmi.domain.alarm.priority import Priority
from hmi.domain.camera import CameraInfo, CameraPtz
from hmi.domain.event import RobotEvent
from hmi.domain.mission import MissionStatus
from hmi.domain.robot import Mode, Robot
from hmi.domain.sensors.observation import Measurement, SensorKind, SoilReading, Station, WeatherReading
from hmi.fiware.alert import alert_entity
from hmi.fiware.camera import camera_entity
from hmi.fiware.device import device_entity, event_entity, measurement_entity
from hmi.fiware.farm_map import map_entities
from hmi.fiware.normalized import key_values, normalized
from hmi.fiware.operation import Operation, operation_entity, read_operation
from hmi.fiware.robot import state_message
from hmi.fiware.soil import record_entity
from hmi.fiware.uav import uav_entity
from hmi.fiware.urn import Urns
from hmi.fiware.weather import weather_entity
from hmi.map_files.fiware_reader import read
from hmi.mapping.feature import MapFeature
from tests.hmi.fiware.models import check
from tests.hmi.fiware.robots import LAT, LON, a_robot
from tests.hmi.map_files.features import maps

AT = datetime(2026, 5, 4, 12, 0, 1, 250_000, tzinfo=UTC)
URNS = Urns("hof")
TURNS = CameraInfo("front", "Front", 2048, 1536, ptz=CameraPtz("pan", "tilt"), fov_deg=80.0)
STATION = Station("soil-3", "Soil 3", SensorKind.SOIL, LAT, LON, battery=0.09, parcel_id="north", heard_at=AT)
shares = st.one_of(st.none(), st.floats(0, 1))
texts = st.text(st.characters(codec="utf-8", exclude_categories=("Cs",)), max_size=40)


def sent_and_back(entity: dict[str, Any]) -> dict[str, Any]:
    """Return key-values after the wire."""
    return key_values(entity_from_wire(normalized(entity).to_wire()))


@pytest.mark.slow
@given(written=maps)
@settings(max_examples=20, deadline=None)
def test_a_map_comes_back_from_the_broker_as_it_went(written: list[MapFeature]) -> None:
    entities, without_model = map_entities(written, "hof", "Hof")
    for entity in entities:
        check(entity)
        assert sent_and_back(entity) == entity
    back = read([sent_and_back(entity) for entity in entities]).layers[0].features
    kept = {one.id: one for one in written if one not in without_model}
    assert {one.id for one in back} == set(kept)
    for one in back:
        assert one.id is not None
        assert (one.properties, one.geometry) == (kept[one.id].properties, kept[one.id].geometry)


@given(text=texts, soc=st.floats(0, 1), speed=st.floats(-2, 2), mode=st.sampled_from(Mode))
@settings(max_examples=40, deadline=None)
def test_a_robot_fits_its_model_and_comes_back_with_any_words_in_its_faults(
    text: str, soc: float, speed: float, mode: Mode
) -> None:
    for robot, make in ((a_robot("weeder-01"), state_message), (a_robot("uav-01", family="uav"), uav_entity)):
        entity = make(URNS, a_robot(robot.id, text=text, soc=soc, speed_mps=speed, mode=mode), AT)
        check(entity)
        assert sent_and_back(entity) == entity
        assert text[:100] in str(entity) or repr(text[:100])[1:-1] in str(entity)


def test_what_a_robot_has_not_told_is_left_out_and_never_zero() -> None:
    silent = replace(a_robot("weeder-01"), telemetry=None, safety=None)
    entity = state_message(URNS, silent, AT)
    assert not {"battery", "location", "speed"} & set(entity)
    assert (entity["pose"], entity["accuracy"], entity["destination"]) == ({}, {}, {})
    assert "stopLatched" not in entity["headland"]
    with pytest.raises(ValidationError, match="battery"):  # the schema wants one: named in docs/cloud.md
        check(entity)


def test_a_latched_stop_is_an_error_whatever_the_mode_says() -> None:
    robot = a_robot("weeder-01", mode=Mode.AUTO)
    assert robot.safety is not None
    assert state_message(URNS, robot, AT)["mode"] == "navi"
    stopped = replace(robot, safety=replace(robot.safety, latched=True))
    entity = state_message(URNS, stopped, AT)
    assert entity["mode"] == "error"
    assert entity["headland"]["stopLatched"] is True


@pytest.mark.parametrize("status", MissionStatus)
def test_a_mission_fits_its_model_in_every_status_and_is_read_back(status: MissionStatus) -> None:
    work = Operation("m1", "Maize (north)", status, 2, "ab" * 32, AT, AT, 1800.0, "north", "weeder-01",
                     started_at=AT, ended_at=AT + timedelta(hours=1), why="It's done; \"ok\"")  # fmt: skip
    entity = operation_entity(URNS, work)
    check(entity)
    assert sent_and_back(entity) == entity
    assert read_operation(URNS, sent_and_back(entity)) == ("m1", status)
    assert read_operation(Urns("other"), entity) is None


def test_a_mission_that_was_aborted_is_not_told_as_finished() -> None:
    work = Operation("m1", "North", MissionStatus.ABORTED, 1, "a", AT, AT)
    entity = operation_entity(URNS, work)
    assert (entity["status"], entity["result"]) == ("cancelled", "aborted")
    assert entity["hasAgriParcel"] == URNS.farm  # drawn free of a parcel


@pytest.mark.slow
@given(
    battery=shares, moisture=shares, humidity=shares, wind=st.one_of(st.none(), st.floats(0, 60)),
    depth=st.floats(0, 3), name=texts,
)  # fmt: skip
@settings(max_examples=40, deadline=None)
def test_stations_and_what_they_measure_fit_their_models(
    battery: float | None, moisture: float | None, humidity: float | None, wind: float | None, depth: float, name: str
) -> None:
    station = replace(STATION, battery=battery, name=name)
    entities = [
        *(device_entity(URNS, replace(station, kind=kind, parcel_id="")) for kind in SensorKind),
        device_entity(URNS, station),
        measurement_entity(URNS, station, Measurement("resp-1", AT, "gasConcentration", 412.0, "59")),
        weather_entity(URNS, station, WeatherReading("w", AT, 21.5, humidity, 0.0, wind, 270.0, 640.0)),
        record_entity(URNS, station, SoilReading("soil-3", AT, depth, moisture, 14.2)),
        camera_entity(URNS, "field", CameraInfo("mast", name, 640, 480), name, place=(LAT, LON)),
        camera_entity(URNS, "weeder-01", TURNS, name, is_on=True),
    ]
    for entity in entities:
        check(entity)
        assert sent_and_back(entity) == entity


def test_two_events_of_a_robot_are_two_entities_and_one_sent_twice_is_one() -> None:
    one = RobotEvent("weeder-01", "b1-7", "mission", "done", "It's done (row 12)", {"row": 12}, at_utc=AT)
    entity = event_entity(URNS, one, "StateMessage")
    check(entity)
    assert sent_and_back(entity) == entity
    assert event_entity(URNS, one, "StateMessage")["id"] == entity["id"]
    assert event_entity(URNS, replace(one, event_id="b1-8"), "StateMessage")["id"] != entity["id"]


@pytest.mark.parametrize("priority", Priority)
def test_an_alarm_fits_its_model_while_it_stands_and_after(priority: Priority) -> None:
    for ended in (None, AT + timedelta(minutes=2)):
        entity = alert_entity(URNS, "link-lost.weeder-01", "weeder-01", "No link for 12 s.", priority=priority,
                              raised_at=AT, state="unacknowledged", ended_at=ended)  # fmt: skip
        check(entity)
        assert sent_and_back(entity) == entity
        assert ("validTo" in entity) == (ended is not None)


def test_a_broker_takes_every_kind_of_entity_and_gives_it_back() -> None:
    async def story() -> None:
        application = make_application(ContextBroker(None, None), FaultSwitch())
        broker = Broker("http://broker.test")
        async with NgsiClient(broker, transport=httpx.ASGITransport(application)) as client:
            for entity in _one_of_each():
                await client.upsert(normalized(entity))
                found = await client.find(normalized(entity).ref)
                assert found is not None
                assert key_values(found) == entity, entity["type"]

    asyncio.run(story())


def _one_of_each() -> list[dict[str, Any]]:
    robot: Robot = a_robot("weeder-01")
    square = [[10.0, 50.0], [10.001, 50.0], [10.001, 50.001], [10.0, 50.001], [10.0, 50.0]]
    shape = {"type": "Polygon", "coordinates": [square]}
    drawn = [
        MapFeature("f", "farm", "Hof", shape, {}),
        MapFeature(
            "n", "parcel", "North's (2)", shape, {"crop": "Maize", "soil_type": "Sandy loam", "seeded": "2026-04-01"}
        ),
        MapFeature("b", "building", "Barn", shape, {"category": "barn"}),
        MapFeature("r", "road", "Lane", {"type": "LineString", "coordinates": square[:2]}, {"width_m": 4.5}),
    ]
    return [
        *map_entities(drawn, "hof", "Hof")[0],
        operation_entity(URNS, Operation("m1", "North", MissionStatus.RUNNING, 1, "a", AT, AT)),
        state_message(URNS, robot, AT),
        uav_entity(URNS, a_robot("uav-01", family="uav"), AT),
        device_entity(URNS, STATION),
        weather_entity(URNS, STATION, WeatherReading("w", AT, wind_mps=3.2)),
        record_entity(URNS, STATION, SoilReading("soil-3", AT, 0.3, 0.21, 14.0)),
        camera_entity(URNS, "weeder-01", TURNS, "Front", is_on=False),
        alert_entity(URNS, "a.b", "b", "x", priority=Priority.LOW, raised_at=AT, state="returned"),
    ]
