"""Field stations in the cloud: each value once, with its own time, valid against the models."""

from __future__ import annotations

from pathlib import Path

import httpx
import pytest

from hmi.cloud.outbox import Piece, Rank
from hmi.cloud.stations import StationStates
from hmi.domain.sensors.observation import SensorKind
from hmi.domain.sensors.quantity import QUANTITIES, Channel
from hmi.domain.sensors.station import FieldStation, Report
from hmi.store.sensor_board import SensorBoard
from tests.hmi.app.test_cloud_report import codes, report_of
from tests.hmi.cloud.rig import Rig
from tests.hmi.fiware.test_entities import check

SOIL = tuple(Channel(name, depth) for depth in (10, 30) for name in ("soil_moisture", "soil_temperature"))
WEATHER = tuple(Channel(name) for name in
                ("air_temperature", "air_humidity", "rain_rate", "wind_speed", "wind_gust", "wind_bearing",
                 "radiation"))  # fmt: skip
AIR = (Channel("co2"), Channel("h2o"), Channel("soil_temperature", 5))


class Farm(Rig):
    """A mirror with stations."""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        self.board, self.seq = SensorBoard(self.clock, lambda *_: None), 0
        self.board.load([], [], [], [])
        self.states = StationStates(self.board, self.urns)
        self.mirror._others = lambda: [self.states]

    def station(self, station_id: str, kind: SensorKind, channels: tuple[Channel, ...], **parts: object) -> None:
        """Take a station in."""
        units = {one: QUANTITIES[one.quantity].unit for one in channels}
        given = {"is_accepted": True, "parcel": "north", **parts}
        self.board.put(
            FieldStation(station_id, station_id, kind, 52.0, 5.0, 60.0, units, **given)  # type: ignore[arg-type]
        )

    def measure(self, station_id: str, *values: tuple[Channel, float]) -> None:
        """Let it measure now."""
        self.seq += 1
        report = Report(station_id, "boot-0001", self.seq, self.clock.utc(), values, 0.8)
        self.board.reported(report, self.clock.mono_s())


@pytest.fixture
async def farm(tmp_path: Path) -> Farm:
    """Return a farm whose cloud is there."""
    made = Farm(tmp_path)
    await made.run(2)
    return made


async def test_every_kind_of_station_fits_its_models_and_arrives(farm: Farm) -> None:
    farm.station("soil-1", SensorKind.SOIL, SOIL)
    farm.station("weather-1", SensorKind.WEATHER, WEATHER)
    farm.station("resp-1", SensorKind.RESPIRATION, AIR)
    farm.station("cam-1", SensorKind.CAMERA, ())
    farm.measure("soil-1", *((one, 0.25) for one in SOIL))
    farm.measure("weather-1", *((one, 0.5) for one in WEATHER))
    farm.measure("resp-1", *((one, 412.0 if one.quantity == "co2" else 12.0) for one in AIR))
    for entity in farm.states.reports(100):
        check(entity)
    await farm.run(2)
    assert len(await farm.in_cloud("Device")) == 4
    records = await farm.in_cloud("AgriParcelRecord")
    assert sorted(one["depth"] for one in records.values()) == [0.05, 0.1, 0.3]
    [weather] = (await farm.in_cloud("WeatherObserved")).values()
    assert (weather["windSpeed"], weather["gustSpeed"], weather["relativeHumidity"]) == (0.5, 0.5, 0.5)
    measured = await farm.in_cloud("DeviceMeasurement")
    assert {one["controlledProperty"]: (one["numValue"], one["unit"]) for one in measured.values()} == {
        "co2": (412.0, "59"), "h2o": (12.0, "NX")
    }  # fmt: skip
    await farm.close()


async def test_nothing_is_told_twice_and_what_is_old_keeps_its_time(farm: Farm) -> None:
    farm.station("soil-1", SensorKind.SOIL, SOIL)
    farm.measure("soil-1", (SOIL[0], 0.25))
    at = farm.clock.utc()
    await farm.run(2)
    told = farm.mirror.counts.others
    await farm.run(60)
    assert (told, farm.mirror.counts.others) == (2, 2)
    [record] = (await farm.in_cloud("AgriParcelRecord")).values()
    assert record["dateObserved"] == at.isoformat(timespec="milliseconds").replace("+00:00", "Z")
    farm.measure("soil-1", (SOIL[0], 0.26))
    await farm.run(2)
    [record] = (await farm.in_cloud("AgriParcelRecord")).values()
    assert record["soilMoistureVwc"] == 0.26
    await farm.close()


async def test_a_station_that_nobody_took_in_and_a_value_that_cannot_be_stay_here(farm: Farm) -> None:
    farm.station("soil-1", SensorKind.SOIL, SOIL)
    farm.station("soil-2", SensorKind.SOIL, SOIL, is_accepted=False)
    farm.measure("soil-1", (SOIL[0], 0.95))
    farm.measure("soil-2", (SOIL[0], 0.2))
    await farm.run(2)
    assert list(await farm.in_cloud("Device")) == [farm.urns.of("Device", "soil-1")]
    assert await farm.in_cloud("AgriParcelRecord") == {}
    await farm.close()


async def test_a_station_that_was_taken_out_is_told_as_removed_and_as_in_use_when_it_comes_back(farm: Farm) -> None:
    async def state() -> str:
        await farm.run(2)
        [device] = (await farm.in_cloud("Device")).values()
        return str(device["deviceState"])

    farm.station("soil-1", SensorKind.SOIL, SOIL)
    assert await state() == "in use"
    farm.board.remove("soil-1")
    [gone] = farm.states.reports(100)
    check(gone)
    farm.states.forget()
    assert await state() == "removed", "also where the broker was away meanwhile"
    assert farm.states.reports(100) == []
    farm.station("soil-1", SensorKind.SOIL, SOIL)
    assert await state() == "in use"
    await farm.close()


async def test_what_was_measured_while_the_cloud_was_away_arrives_as_the_newest_of_each(farm: Farm) -> None:
    farm.station("soil-1", SensorKind.SOIL, SOIL)
    farm.road.broken = lambda request: httpx.ConnectError("away", request=request)
    for number in range(20):
        farm.measure("soil-1", (SOIL[0], 0.2 + number / 1000))
        await farm.run(1)
    farm.road.broken = None
    await farm.run(120)
    [record] = (await farm.in_cloud("AgriParcelRecord")).values()
    assert record["soilMoistureVwc"] == pytest.approx(0.219)
    await farm.close()


async def test_what_is_measured_at_two_depths_is_two_entities(farm: Farm) -> None:
    wet = tuple(Channel("soil_conductivity", depth) for depth in (10, 30))
    farm.board.put(FieldStation("soil-1", "soil-1", SensorKind.SOIL, 52.0, 5.0, 60.0, dict.fromkeys(wet, "mS/m"),
                                is_accepted=True))  # fmt: skip
    farm.measure("soil-1", (wet[0], 20.0), (wet[1], 30.0))
    for entity in farm.states.reports(100):
        check(entity)
    await farm.run(2)
    found = await farm.in_cloud("DeviceMeasurement")
    assert {key.rpartition("soil_conductivity")[2]: one["numValue"] for key, one in found.items()} == {
        ":10cm": 20.0, ":30cm": 30.0
    }  # fmt: skip
    await farm.close()


def mission_waits(farm: Farm) -> None:
    """Let something wait that comes after the stations."""
    body = '{"id": "urn:ngsi-ld:AgriParcelOperation:hof:m1", "type": "AgriParcelOperation", "status": "finished"}'
    farm.backlog.put(Piece("r", Rank.MISSION, farm.clock.utc().timestamp(), body))


async def test_two_things_under_one_id_hold_up_nothing(farm: Farm, monkeypatch: pytest.MonkeyPatch) -> None:
    farm.station("soil-1", SensorKind.SOIL, SOIL)
    farm.measure("soil-1", (SOIL[0], 0.25))
    told = farm.states.reports(100)
    monkeypatch.setattr(farm.states, "reports", lambda _limit: [*told, {**told[0], "name": "Twin"}])
    mission_waits(farm)
    await farm.run(2)
    [device] = (await farm.in_cloud("Device")).values()
    assert device["name"] == "soil-1"
    assert "two at once" in farm.mirror.counts.last_refusal
    assert (farm.backlog.total, len(await farm.in_cloud("AgriParcelOperation"))) == (0, 1)
    await farm.close()


async def test_a_kind_of_thing_that_fails_here_is_said_and_holds_up_no_other(
    farm: Farm, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(_limit: int) -> list[dict[str, object]]:
        raise KeyError("no such unit")

    report = report_of(farm)
    with monkeypatch.context() as patch:
        patch.setattr(farm.states, "reports", broken)
        mission_waits(farm)
        await farm.run(2)
        assert (farm.backlog.total, len(await farm.in_cloud("AgriParcelOperation"))) == (0, 1)
        shown = report.whole()
        assert (shown["head"], shown["level"]) == ("Connected, but not everything goes up", "bad")
        assert "Field stations: KeyError: 'no such unit'" in shown["why"]
        assert codes(report) == ["cloud-stuck"]
        assert report.health()["cloud"]["state"] == "degraded"
    await farm.run(2)
    assert (report.whole()["head"], codes(report)) == ("Connected", [])
    await farm.close()


async def test_what_is_not_measured_any_more_does_not_stay_in_the_cloud_under_a_new_time(farm: Farm) -> None:
    wind, air = Channel("wind_speed"), Channel("air_temperature")
    farm.station("weather-1", SensorKind.WEATHER, WEATHER)
    farm.station("soil-1", SensorKind.SOIL, SOIL)
    farm.measure("weather-1", (wind, 2.0), (air, 10.0))
    farm.measure("soil-1", (SOIL[0], 0.31), (SOIL[1], 8.0))
    await farm.run(2)
    farm.clock.advance(120)
    farm.measure("weather-1", (wind, 93.0), (air, 11.0))  # broken
    farm.measure("soil-1", (SOIL[1], 9.0))
    await farm.run(2)
    [weather] = (await farm.in_cloud("WeatherObserved")).values()
    assert (weather["temperature"], "windSpeed" in weather) == (11.0, False)
    [record] = (await farm.in_cloud("AgriParcelRecord")).values()
    assert (record["soilTemperature"], "soilMoistureVwc" in record) == (9.0, False)
    farm.station("soil-1", SensorKind.SOIL, SOIL, parcel="")
    await farm.run(2)
    assert "controlledAsset" not in (await farm.in_cloud("Device"))[farm.urns.of("Device", "soil-1")]
    before = len(farm.road.requests)
    for _ in range(3):
        farm.clock.advance(60)
        farm.measure("weather-1", (air, 12.0))
        await farm.run(0.5)
    assert len(farm.road.requests) - before < 12, "nobody is asked for what is known to be gone"
    await farm.close()
