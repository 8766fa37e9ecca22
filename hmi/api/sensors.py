"""Field sensors: stations and their values, charts, calibration, limits, a picture on demand; see docs/sensors.md."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal

from fastapi import APIRouter, Path, Query
from pydantic import Field

from hmi.api.access import SignedIn, Watcher
from hmi.api.body import Body, Name, Reason
from hmi.api.errors import ApiError
from hmi.domain.ids import ID_PATTERN
from hmi.domain.sensors.calibration import Calibration
from hmi.domain.sensors.limit import SensorLimit
from hmi.domain.sensors.quantity import Channel
from hmi.domain.sensors.series import Span

if TYPE_CHECKING:
    from hmi.api.sensor_view import SensorView
    from hmi.commands.sensor_book import SensorBook, StationWish
    from hmi.commands.sensor_trigger import SensorTrigger

StationId = Annotated[str, Path(pattern=ID_PATTERN.removesuffix("$") + r"\z")]
QuantityName = Annotated[str, Field(pattern=ID_PATTERN.removesuffix("$") + r"\z")]
DepthM = Annotated[float, Field(ge=0, le=20)]
Bound = Annotated[float, Field(ge=-1e9, le=1e9)]
Lat = Annotated[float, Field(ge=-90, le=90)]
Lon = Annotated[float, Field(ge=-180, le=180)]
ParcelId = Annotated[str, Field(max_length=80)]
MOST_LIMITS = 100


class AcceptBody(Body):
    """Its name and parcel, as it says itself where left out."""

    name: Name | None = None
    parcel: ParcelId | None = None


class StationBody(Body):
    """Name, parcel (empty or null is none) and place; ``revision`` of the station that was seen, null asks nothing."""

    name: Name
    parcel: ParcelId | None
    lat_deg: Lat | None = None
    lon_deg: Lon | None = None
    revision: Annotated[str, Field(max_length=64)] | None = None


class CalibrationBody(Body):
    """From the next value on: measured times ``gain`` plus ``offset``, which is in the unit shown."""

    quantity: QuantityName
    depth_m: DepthM | None = None
    offset: Bound
    gain: Bound
    note: Reason = ""


class LimitBody(Body):
    """One limit; ``low`` and ``high`` in the unit shown, null asks nothing."""

    quantity: QuantityName
    depth_m: DepthM | None = None
    low: Bound | None = None
    high: Bound | None = None
    is_treatment: bool = False
    note: Reason = ""


class LimitsBody(Body):
    """Every limit of the farm; ``revision`` of those that were seen, empty for none, null asks for no comparison."""

    limits: Annotated[list[LimitBody], Field(max_length=MOST_LIMITS)]
    revision: Annotated[str, Field(max_length=64)] | None = None


@dataclass(frozen=True, slots=True)
class SensorServices:
    """What the routes need."""

    view: SensorView
    book: SensorBook
    trigger: SensorTrigger


Services = Callable[[], Awaitable[SensorServices]]
"""Loads what is not needed before somebody asks."""


def sensor_routes(services: Services) -> APIRouter:
    """Return the routes of stations and limits."""
    router = APIRouter(tags=["sensors"])
    _add_reading(router, services)
    _add_keeping(router, services)
    _add_settings(router, services)
    return router


def _add_reading(router: APIRouter, services: Services) -> None:
    @router.get("/sensors", summary="Every station with its newest values, the treatment gate, what I may do")
    async def every(session: Watcher) -> dict[str, Any]:
        return (await services()).view.whole(session)

    @router.get("/sensors/{station}/series", summary="One quantity over time, with gaps, limits and treatments")
    async def series(
        station: StationId,
        session: Watcher,
        quantity: Annotated[str, Query(max_length=64)],
        depth_m: Annotated[str, Query(max_length=16)] = "",
        span: Literal["24h", "7d", "season"] = "24h",
    ) -> dict[str, Any]:
        found = await services()
        return await found.view.series(found.book.station(station), _channel(quantity, _depth(depth_m)), Span(span))

    @router.get("/sensors/{station}/calibration", summary="Every calibration there was, newest first")
    async def calibration(station: StationId, session: Watcher) -> list[dict[str, Any]]:
        found = await services()
        return found.view.calibrations(found.book.calibrations(station))


def _add_keeping(router: APIRouter, services: Services) -> None:
    @router.post("/sensors/{station}/accept", summary="Take a station in: it is recorded from now on")
    async def accept(station: StationId, body: AcceptBody, session: SignedIn) -> dict[str, Any]:
        found = await services()
        wish = _wish(name=body.name, parcel=body.parcel)
        await _tried(found.book.accept(session, station, wish))
        return found.view.station(found.book.station(station))

    @router.put("/sensors/{station}", summary="Name and place it anew")
    async def change(station: StationId, body: StationBody, session: SignedIn) -> dict[str, Any]:
        found = await services()
        wish = _wish(name=body.name, parcel=body.parcel or "", lat_deg=body.lat_deg, lon_deg=body.lon_deg)
        await _tried(found.book.change(session, station, wish, seen=body.revision))
        return found.view.station(found.book.station(station))

    @router.delete("/sensors/{station}", status_code=204, summary="Take it out; its history stays")
    async def remove(station: StationId, session: SignedIn) -> None:
        await (await services()).book.remove(session, station)

    @router.post("/sensors/{station}/trigger", summary="Take a picture now; says how it went")
    async def trigger(station: StationId, session: SignedIn) -> dict[str, str]:
        found = await services()
        told = await found.trigger.send(session, found.book.station(station).station)
        return {"outcome": told.outcome, "text": told.text}


def _add_settings(router: APIRouter, services: Services) -> None:
    @router.put("/sensors/{station}/calibration", summary="Correct one quantity from its next value on")
    async def calibrate(station: StationId, body: CalibrationBody, session: SignedIn) -> list[dict[str, Any]]:
        found, channel = await services(), _channel(body.quantity, body.depth_m)
        offset = body.offset / channel.about().factor
        await _tried(found.book.calibrate(session, Calibration(station, channel, offset, body.gain, body.note)))
        return found.view.calibrations(found.book.calibrations(station))

    @router.get("/sensor-limits", summary="Limits of the farm; treatment waits beyond those of treatment")
    async def limits(session: Watcher) -> list[dict[str, Any]]:
        return (await services()).view.limits()

    @router.put("/sensor-limits", summary="Set all of them; what is left out goes")
    async def set_limits(body: LimitsBody, session: SignedIn) -> list[dict[str, Any]]:
        found = await services()
        await _tried(found.book.set_limits(session, [_limit(one) for one in body.limits], seen=body.revision))
        return found.view.limits()


async def _tried(work: Awaitable[Any]) -> None:
    """Do it; what is refused names the input at fault."""
    from hmi.commands.sensor_book import SensorRefused  # with what it keeps, only where it is used

    try:
        await work
    except SensorRefused as error:
        raise ApiError(422, error.code, error.text, error.field or None) from error


def _wish(**parts: Any) -> StationWish:
    from hmi.commands.sensor_book import StationWish

    return StationWish(**parts)


def _channel(quantity: str, depth_m: float | None) -> Channel:
    return Channel.of(quantity, depth_m)


def _depth(text: str) -> float | None:
    """An empty depth is none: a form sends it so."""
    if not text:
        return None
    try:
        depth_m = float(text)
    except ValueError:
        depth_m = -1.0
    if not 0 <= depth_m <= 20:
        raise ApiError(422, "invalid", "depth_m: give metres below ground, 0 to 20.", "depth_m")
    return depth_m


def _limit(body: LimitBody) -> SensorLimit:
    channel = _channel(body.quantity, body.depth_m)
    factor = channel.about().factor
    low, high = (None if bound is None else bound / factor for bound in (body.low, body.high))
    return SensorLimit(channel, low, high, body.is_treatment, body.note)
