"""The field sensors of a simulator process: they begin some seconds after the robots, and cost nothing before."""

from __future__ import annotations

import asyncio
import importlib
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import structlog

from hmi.clock import Clock

if TYPE_CHECKING:
    from backend_clients.simulator.config import SimulatorConfig
    from backend_clients.simulator.field.station import StationConfig
    from backend_clients.simulator.field.yard import Yard

LATER_S = 8.0  # who waits for the demo to start does not wait for the weather
StationsMaker = Callable[[], "tuple[StationConfig, ...]"]

log = structlog.get_logger(__name__)


class LateSensors:
    """Stations beside the robots, and the tester's doors to them. Until they have begun there are none."""

    def __init__(self, config: SimulatorConfig, clock: Clock) -> None:
        self._config, self._clock = config, clock
        self._yard: Yard | None = None

    async def run(self) -> None:
        """Begin later, and live until cancelled; without stations it returns at once."""
        make = self._config.stations
        if make is None:
            return
        await asyncio.sleep(LATER_S if self._config.robots else 0.0)
        try:
            self._yard = await asyncio.to_thread(self._made, make)
            await self._yard.run()
        except Exception:  # robots go on without weather
            log.exception("the field sensors ended")
            self._yard = None

    def told(self) -> dict[str, Any]:
        """Return stations, what can happen to them and what does."""
        return self._yard.told() if self._yard is not None else {"stations": [], "situations": [], "now": {}}

    def provoke(self, station_id: str, situation_id: str | None) -> None:
        """Play a situation, ``None`` ends it; raises ``KeyError`` and ``ValueError`` as the director does."""
        self._known(station_id).provoke(station_id, situation_id)

    def has(self, station_id: str) -> bool:
        """Say whether there is such a station now."""
        return self._yard is not None and station_id in self._yard.sessions

    def set_fault(self, station_id: str, payload: bytes) -> None:
        """Switch a fault on; raises ``KeyError``, ``msgspec.DecodeError``."""
        self._known(station_id).set_fault(station_id, payload)

    def clear_fault(self, station_id: str, name: str | None) -> None:
        """Switch one fault, or all, off; raises ``KeyError``."""
        self._known(station_id).clear_fault(station_id, name)

    def faults(self, station_id: str) -> dict[str, Any]:
        """Return the active faults by name; raises ``KeyError``."""
        return self._known(station_id).faults(station_id)

    def _known(self, station_id: str) -> Yard:
        if self._yard is None:
            raise KeyError(station_id)
        return self._yard

    def _made(self, make: StationsMaker) -> Yard:
        module = importlib.import_module("backend_clients.simulator.field.yard")
        config = self._config
        yard: Yard = module.Yard(
            module.YardConfig(
                config.broker_url,
                make(),
                seed=config.seed,
                speed=config.sensor_speed,
                features=config.features,
                is_always_day=config.is_always_day,
            ),
            self._clock,
        )
        return yard
