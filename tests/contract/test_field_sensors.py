"""Field sensor contract v1 over a real broker: the simulated stations, heard and told as the console does it."""

from __future__ import annotations

import asyncio
import threading
import uuid
from collections.abc import Callable, Iterator
from datetime import UTC, datetime, timedelta
from typing import Any

import httpx
import pytest

from backend_clients.edge.mqtt import LinkState, MqttLink
from backend_clients.field import messages as m
from backend_clients.field.codec import Message, decode, encode
from backend_clients.field.topics import Address, Down, Up, every_station, topic
from backend_clients.simulator.config import SimulatorConfig
from backend_clients.simulator.field.station import StationConfig
from backend_clients.simulator.process import Simulator
from tests.brokers import MOSQUITTO, start_mosquitto

pytestmark = [
    pytest.mark.broker,
    pytest.mark.slow,
    pytest.mark.skipif(MOSQUITTO is None, reason="mosquitto is not installed"),
]
WAIT_S = 20.0
STATIONS = (
    StationConfig("weather-01", "Weather", "weather", 51.786, 4.261),
    StationConfig("soil-01", "Soil 1", "soil", 51.786, 4.261),
    StationConfig("multispec-01", "Multispectral 1", "camera", 51.786, 4.261),
)


class Ear:
    """Hears all stations, as the console does."""

    def __init__(self, url: str) -> None:
        self.heard: list[tuple[Address, Message | bytes, bool]] = []
        self._news = threading.Condition()
        self._is_up = threading.Event()
        self.link = MqttLink(
            url,
            f"ear-{uuid.uuid4().hex[:8]}",
            subscriptions=[(every_station(kind), 1) for kind in Up],
            on_message=self._hear,
            on_link=lambda state, _text: self._is_up.set() if state is LinkState.UP else None,
        )
        self.link.start()
        assert self._is_up.wait(WAIT_S)

    def _hear(self, name: str, payload: bytes, is_retained: bool) -> None:
        with self._news:
            self.heard.append((*decode(name, payload), is_retained))
            self._news.notify_all()

    def wait(self, station: str, kind: Up, wanted: Callable[[Any], bool] = lambda _: True) -> Any:
        """Return the first message of a station and kind that is wanted."""
        with self._news:
            found: list[Any] = []

            def look() -> bool:
                found.extend(one for at, one, _ in self.heard if at == (station, kind) and wanted(one))
                return bool(found)

            assert self._news.wait_for(look, WAIT_S), f"no such {kind} of {station}"
            return found[0]

    def all(self, station: str) -> list[m.Data]:
        """Return the data of a station in the order it came."""
        with self._news:
            return [one for at, one, _ in self.heard if at.station == station and isinstance(one, m.Data)]

    def tell(self, station: str, kind: Down, message: Message, *, retain: bool = False) -> m.Ack:
        """Publish and return the answer."""
        assert self.link.publish(topic(station, kind), encode(message), qos=1, retain=retain)
        answer: m.Ack = self.wait(station, Up.ACK, lambda ack: ack.id == getattr(message, "id", ""))
        return answer


@pytest.fixture(scope="module")
def broker(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Return the address of mosquitto."""
    with start_mosquitto(tmp_path_factory.mktemp("mosquitto")) as url:
        yield url


@pytest.fixture(scope="module")
def http(broker: str) -> Iterator[httpx.Client]:
    """Run the stations alone, an hour of weather in six seconds; the value speaks to the testers' doors."""
    ready, ports = threading.Event(), list[int]()

    def on_ready(port: int) -> None:
        ports.append(port)
        ready.set()

    config = SimulatorConfig(broker, (), stations=lambda: STATIONS, sensor_speed=600.0)
    simulator = Simulator(config, on_ready=on_ready)
    thread = threading.Thread(target=lambda: asyncio.run(simulator.run()))
    thread.start()
    assert ready.wait(WAIT_S)
    with httpx.Client(base_url=f"http://127.0.0.1:{ports[0]}", trust_env=False, timeout=5) as client:
        yield client
    simulator.stop()
    thread.join(5)
    assert not thread.is_alive()


@pytest.fixture
def ear(broker: str, http: httpx.Client) -> Iterator[Ear]:
    """Return a listener that has heard every station."""
    ear = Ear(broker)
    for station in STATIONS:
        ear.wait(station.id, Up.ABOUT)
    yield ear
    ear.link.stop()


def test_stations_tell_who_they_are_to_whoever_comes_later(ear: Ear, broker: str) -> None:
    later = Ear(broker)
    try:
        told = later.wait("soil-01", Up.ABOUT)
        assert (told.name, {q.depth_m for q in told.quantities}) == ("Soil 1", {0.1, 0.3, 0.6})
        assert any(kept for at, _, kept in later.heard if at == ("soil-01", Up.ABOUT))
    finally:
        later.link.stop()


def test_a_notice_is_answered_and_named_by_what_is_measured_under_it(ear: Ear) -> None:
    now = datetime.now(UTC)
    notice = m.Notice(
        station="soil-01", id=uuid.uuid4().hex, utc=now, is_treating=True, robots=["weeder-01"], parcel="polder-17",
        until_utc=now + timedelta(seconds=60),
    )  # fmt: skip
    assert ear.tell("soil-01", Down.NOTICE, notice, retain=True).outcome == "accepted"
    ear.wait("soil-01", Up.DATA, lambda data: data.notice == notice.id)
    ear.link.publish(topic("soil-01", Down.NOTICE), b"", qos=1, retain=True)


def test_a_trigger_brings_a_picture_and_a_late_one_an_explanation(ear: Ear) -> None:
    late = m.Trigger(station="multispec-01", id=uuid.uuid4().hex, utc=datetime(2026, 1, 1, tzinfo=UTC), ttl_s=5.0)
    refused = ear.tell("multispec-01", Down.TRIGGER, late)
    assert refused.outcome == "rejected"
    assert refused.text.startswith("Trigger is ")
    fresh = m.Trigger(station="multispec-01", id=uuid.uuid4().hex, utc=datetime.now(UTC), ttl_s=5.0)
    assert ear.tell("multispec-01", Down.TRIGGER, fresh).outcome == "accepted"
    assert ear.wait("multispec-01", Up.FRAME)[:3] == b"\xff\xd8\xff"


@pytest.mark.slow
def test_provoked_faults_really_are_on_the_wire(ear: Ear, http: httpx.Client) -> None:
    assert http.post("/_faults/soil-01", json={"fault": "duplicates"}).status_code == 200
    data = ear.wait("soil-01", Up.DATA, lambda one: sum(o.seq == one.seq for o in ear.all("soil-01")) == 2)
    assert data.values
    http.delete("/_faults/soil-01").raise_for_status()
    http.post("/_situations/weather-01", json={"situation": "sensor-late"}).raise_for_status()
    ear.wait(
        "weather-01", Up.DATA, lambda one: any(o.seq < one.seq for o in _after(ear.all("weather-01"), one))
    )  # fmt: skip
    told = http.get("/_situations").json()
    assert told["now"] == {"weather-01": "sensor-late"}
    assert {one["id"] for one in told["stations"]} == {one.id for one in STATIONS}
    http.post("/_situations/weather-01", json={"situation": None}).raise_for_status()
    assert http.get("/_situations").json()["now"] == {}


def test_what_cannot_be_provoked_is_refused_with_a_sentence(http: httpx.Client, ear: Ear) -> None:
    refused = http.post("/_situations/multispec-01", json={"situation": "sensor-drift"})
    assert (refused.status_code, refused.json()["text"]) == (409, "Values drift cannot happen to Multispectral 1.")
    assert http.post("/_situations/no-such", json={"situation": None}).status_code == 404
    assert http.post("/_situations/soil-01", json={"situation": "no-such"}).status_code == 404
    assert http.post("/_faults/soil-01", json={"fault": "moon"}).status_code == 400
    assert http.get("/_faults/no-such").status_code == 404


def _after(all_of: list[m.Data], one: m.Data) -> list[m.Data]:
    return all_of[next(n for n, other in enumerate(all_of) if other.seq == one.seq) :]
