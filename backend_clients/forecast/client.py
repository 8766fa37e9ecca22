"""Asks a forecast service: one small answer an hour, and only if it is another than the last one."""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import Awaitable, Callable

import httpx
from pydantic import ValidationError

from backend_clients.forecast.messages import MAX_ANSWER, ForecastReport
from backend_clients.service.connection import Call, Service, ServiceConnection
from backend_clients.service.errors import Unreadable

PLACE_DIGITS = 2  # about a kilometre: weather knows no more, and the farm's address is nobody's business
NEAR_DEG = 0.3  # services answer for a point of their grid
MAX_TAG = 200


class ForecastClient:
    """One forecast service. Close it; see ``ServiceConnection`` for the test seams."""

    def __init__(
        self,
        service: Service,
        *,
        transport: httpx.AsyncBaseTransport | None = None,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
        mono_s: Callable[[], float] = time.monotonic,
    ) -> None:
        limited = Service(service.url, service.token, service.ca, service.timeout_s, 0, MAX_ANSWER, service.retry)
        self._connection = ServiceConnection(limited, transport=transport, sleep=sleep, mono_s=mono_s)
        self._tag, self._tagged = "", ("", "")

    async def close(self) -> None:
        """Close all connections."""
        await self._connection.close()

    async def forecast(self, lat_deg: float, lon_deg: float, hours: int) -> tuple[ForecastReport | None, str]:
        """Return the forecast for a place and the service's ``Date``; ``None`` if it is the same as last time.

        Raises:
            ServiceError: the service failed, or its answer cannot be used.
        """
        place = (f"{lat_deg:.{PLACE_DIGITS}f}", f"{lon_deg:.{PLACE_DIGITS}f}")
        known = self._tag if place == self._tagged else ""
        headers = {"If-None-Match": known} if known else {}
        parameters = {"lat_deg": place[0], "lon_deg": place[1], "hours": str(hours)}
        reply = await self._connection.send(Call("GET", "forecast", parameters, headers))
        date = reply.headers.get("date", "")
        if reply.status == 304:
            if not known:
                raise Unreadable("the service says that nothing changed, and was told of nothing")
            return None, date
        try:
            report = ForecastReport.model_validate_json(reply.content)
        except ValidationError as error:
            first = error.errors(include_url=False, include_input=False, include_context=False)[0]
            where = ".".join(str(part) for part in first["loc"])[:80]
            raise Unreadable(f"the answer is not what the format promises: {where} {first['msg']}"[:200]) from None
        if not _is_near(report, lat_deg, lon_deg):
            raise Unreadable("the forecast is for another place")
        tag = reply.headers.get("etag", "")
        self._tag, self._tagged = (tag if tag.isascii() and len(tag) <= MAX_TAG else ""), place
        return report, date

    def forget(self) -> None:
        """Ask for the whole answer next time."""
        self._tag = ""


def _is_near(report: ForecastReport, lat_deg: float, lon_deg: float) -> bool:
    east = math.remainder(report.lon_deg - lon_deg, 360) * math.cos(math.radians(lat_deg))
    return math.hypot(report.lat_deg - lat_deg, east) <= NEAR_DEG
