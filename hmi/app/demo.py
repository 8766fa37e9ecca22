"""The demo's stage: the tester's HTTP of the simulator, on this machine only, and its weather."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

import httpx

from hmi.api.demo import StageAway
from hmi.clock import Clock
from hmi.commands.weather import WeatherBoard
from hmi.demo.fleet import read_demo_fleet
from hmi.demo.weather import PERIOD_S, STATION, WeatherStation
from hmi.domain.queue.facts import WEATHER_FRESH_S, Weather

LIMIT_S = 5.0  # the simulator shares a small machine with everything else of the demo


class SimulatorStage:
    """Speaks to the simulator whose robots stand in the data folder's fleet file.

    Args:
        data: the data folder.
        transport: instead of the network, in tests.
    """

    def __init__(self, data: Path, transport: httpx.AsyncBaseTransport | None = None) -> None:
        self._data, self._transport = data, transport

    async def situations(self) -> dict[str, Any]:
        """Return what can be played and what is on."""
        answer = await self._ask("GET", "/_situations")
        if not answer.is_success:
            raise StageAway(f"it answered {answer.status_code}")
        told: dict[str, Any] = answer.json()
        return told

    async def play(self, robot_id: str, situation: str | None) -> str:
        """Play or end a situation; return why not. Raises ``KeyError`` for an unknown robot or situation."""
        answer = await self._ask("POST", f"/_situations/{robot_id}", {"situation": situation})
        if answer.status_code == 404:
            raise KeyError(robot_id)
        return "" if answer.is_success else str(answer.json().get("text", "The simulator refused it."))

    async def _ask(self, method: str, path: str, body: dict[str, Any] | None = None) -> httpx.Response:
        rows = read_demo_fleet(self._data)
        if not rows:
            raise StageAway("there is no fleet file")
        base = rows[0]["http_url"].rsplit("/", 1)[0]
        try:
            # plain HTTP on this machine: reading the certificates would only cost time
            client = httpx.AsyncClient(transport=self._transport, timeout=LIMIT_S, trust_env=False, verify=False)  # noqa: S501
            async with client:
                return await client.request(method, f"{base}{path}", json=body)
        except httpx.HTTPError as error:
            raise StageAway(str(error)) from error


class DemoWeather:
    """Weather of a demo that nobody reports any: made up, under the name of a simulated station.

    A station that a person connects is left alone for as long as it speaks.
    """

    def __init__(self, board: WeatherBoard, clock: Clock, station: WeatherStation | None = None) -> None:
        self._board, self._clock = board, clock
        self._station = station or WeatherStation()
        self._task: asyncio.Task[None] | None = None

    def start(self) -> None:
        """Measure now and then each minute."""
        self._task = asyncio.create_task(self._run(), name="demo-weather")

    async def stop(self) -> None:
        """End it."""
        if self._task is not None:
            self._task.cancel()
            await asyncio.gather(self._task, return_exceptions=True)

    def measure(self) -> None:
        """Put the weather of this minute on the board, unless a real station speaks."""
        now, latest = self._clock.utc(), self._board.latest
        if latest is not None and latest.at > now:
            return
        if latest is not None and latest.station != STATION and (now - latest.at).total_seconds() <= WEATHER_FRESH_S:
            return
        at_s = now.timestamp()
        self._board.take(Weather(now, self._station.rain_mm_h(at_s), self._station.wind_mps(at_s), STATION))

    async def _run(self) -> None:
        while True:
            self.measure()
            await asyncio.sleep(PERIOD_S)
