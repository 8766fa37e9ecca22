"""The console's field sensors against a real broker and the simulated stations."""

from __future__ import annotations

import asyncio
import shutil
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest

from backend_clients.simulator.field.station import StationConfig
from backend_clients.simulator.field.yard import Yard, YardConfig
from hmi.app.sensors import SensorRoom, SensorWiring
from hmi.clock import SystemClock
from hmi.commands.sensor_book import StationWish
from hmi.commands.weather import WeatherBoard
from hmi.domain.robot import OrderStatus
from hmi.domain.role import Role
from tests.brokers import MOSQUITTO, start_mosquitto
from tests.hmi.commands.field import FARM
from tests.hmi.pictures.rig import FakeCameras
from tests.hmi.sensors.rig import PARCEL, SensorRig, live_store

pytestmark = [
    pytest.mark.broker,
    pytest.mark.slow,
    pytest.mark.skipif(MOSQUITTO is None, reason="mosquitto is not installed"),
]
WAIT_S = 20.0
STATIONS = (
    StationConfig("weather-01", "Weather", "weather", 52.005, 5.005, PARCEL),
    StationConfig("multispec-01", "Multispectral 1", "camera", 52.005, 5.005, PARCEL),
)


@asynccontextmanager
async def simulated(url: str) -> AsyncIterator[None]:
    """Let the stations live on a broker."""
    yard = asyncio.create_task(Yard(YardConfig(url, STATIONS, is_always_day=True)).run())
    try:
        yield
    finally:
        yard.cancel()
        await asyncio.gather(yard, return_exceptions=True)


class Farm(SensorRig):
    """A console on a real broker, with the clock of this machine."""

    def __init__(self, folder: Path, url: str) -> None:
        super().__init__(folder, process=FakeCameras(SystemClock()), broker_url=url)  # type: ignore[arg-type]

    def _made_room(self) -> SensorRoom:
        self.real = SystemClock()
        self.weather = WeatherBoard(self.real, self.authorize, FARM)
        return SensorRoom(
            SensorWiring(self.settings, self.real, self.records, live_store(self.fleet), self.authorize,
                         self.events.append, self.weather, self.desk)
        )  # fmt: skip

    async def until(self, claim: Callable[[], Any]) -> Any:
        """Return what ``claim`` returns as soon as that is something."""
        async with asyncio.timeout(WAIT_S):
            while not (found := claim()):  # noqa: ASYNC110 - much of what is waited for has no event
                await asyncio.sleep(0.05)
            return found

    def seen(self, station: str) -> dict[str, Any] | None:
        """Return what a screen shows of a station, if it is there."""
        whole = self.work.view.whole(self.person(Role.PLANNER))
        return next((one for one in whole["stations"] if one["id"] == station), None)


@pytest.mark.slow
async def test_stations_are_heard_told_of_treatment_and_send_pictures(tmp_path: Path, migrated: Path) -> None:
    shutil.copyfile(migrated, tmp_path / "headland.db")
    with start_mosquitto(tmp_path) as url:
        farm = Farm(tmp_path, url)
        await farm.begin()
        try:
            await farm.until(lambda: farm.work.link.is_up)
            async with simulated(url):
                await story(farm)
        finally:
            await farm.end()


async def story(farm: Farm) -> None:
    """Everything a station and a console have to say to each other."""
    planner = farm.person(Role.PLANNER)
    for one in STATIONS:
        await farm.until(lambda one=one: farm.seen(one.id))
        await farm.work.book.accept(planner, one.id, StationWish())
    shown = await farm.until(lambda: (farm.seen("weather-01") or {}).get("values") and farm.seen("weather-01"))
    assert (shown["state"], shown["parcel_name"], len(shown["values"])) == ("fresh", "North", 7)

    farm.weeder(OrderStatus.RUNNING)
    await farm.work.round()
    for one in STATIONS:
        await farm.until(lambda one=one: (farm.seen(one.id) or {})["notice"]["state"] == "acknowledged")
    farm.weeder(OrderStatus.DONE)
    await farm.work.round()
    await farm.until(lambda: all(farm.work.notices.of(one.id).is_answered for one in STATIONS))  # type: ignore[union-attr]
    await farm.work.round()
    assert [farm.work.notices.of(one.id) for one in STATIONS] == [None, None]

    await farm.until(lambda: farm.work.pictures.counts["taken"])
    assert (farm.seen("multispec-01") or {})["pictures_today"] >= 1
    known = farm.work.board.get("multispec-01")
    assert known is not None
    told = await farm.work.trigger.send(farm.person(Role.OPERATOR), known.station)
    assert told.outcome in ("accepted", "rejected")  # a picture 5 s before is a reason to refuse
    assert farm.work.diagnostics()["refused"] == {}
