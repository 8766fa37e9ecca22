"""What the console needs of whoever forecasts weather."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from hmi.domain.forecast import Forecast


@dataclass(frozen=True, slots=True)
class Told:
    """An answer: the forecast, ``None`` if it is the one of last time; ``date`` tells the service's clock."""

    forecast: Forecast | None
    date: str = ""


class ForecastSource(Protocol):
    """A forecast service."""

    async def ask(self, place: tuple[float, float], hours: int) -> Told:
        """Return the newest forecast for longitude and latitude.

        Raises:
            ServiceError: the service failed, or its answer cannot be used.
        """
        ...

    def forget(self) -> None:
        """Ask for the whole answer next time."""
        ...

    async def close(self) -> None:
        """Close all connections."""
        ...
