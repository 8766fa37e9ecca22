"""Asks the services outside the farm that are set, for ``headland check``."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from datetime import UTC, datetime, timedelta
from email.utils import parsedate_to_datetime

from backend_clients.http.trouble import OutsideError
from backend_clients.service.errors import ServiceError
from hmi.domain.forecast import ForecastAge
from hmi.settings import Settings

CLOCK_S = 30.0
ANYWHERE = (5.18, 52.1)  # longitude and latitude; a check must not need the farm's database


def cloud_answers(settings: Settings) -> tuple[bool, str]:
    """Return whether the context broker lets us read our tenant; nothing is written."""
    from backend_clients.ngsi.connection import Call
    from backend_clients.ngsi.query import Query
    from hmi.app.cloud_work import make_client

    async def ask() -> tuple[str, str]:
        async with make_client(settings) as client:
            name = await client.version()
            await client.count(Query(types=("AgriFarm",)))
            date = (await client.connection.send(Call("GET", "version", is_repeatable=True))).headers.get("date", "")
        return f"{settings.cloud_url} answers: {name}", date

    return _tried(ask, settings.cloud_url or "")


def planner_answers(settings: Settings) -> tuple[bool, str]:
    """Return whether the planner service answers, and in words what it says or what to mend."""
    from hmi.app.planner_work import make_client

    async def ask() -> tuple[str, str]:
        client = make_client(settings)
        try:
            info, headers = await client.info()
        finally:
            await client.close()
        return f"{settings.planner_url} answers: {info.planner.name} {info.planner.version}", headers.get("date", "")

    return _tried(ask, settings.planner_url or "")


def forecast_answers(settings: Settings) -> tuple[bool, str]:
    """Return whether the forecast service answers, and in words what it says or what to mend."""
    from hmi.app.forecast_work import make_source

    async def ask() -> tuple[str, str]:
        source = make_source(settings)
        try:
            told = await source.ask(ANYWHERE, 24)
        finally:
            await source.close()
        assert told.forecast is not None
        now = datetime.now(UTC)
        age = told.forecast.age(now) // timedelta(minutes=1)
        if told.forecast.reliance(now) is ForecastAge.REFUSED:
            text = f"made {told.forecast.made_at:%Y-%m-%d %H:%M} UTC, which cannot be used now; check both clocks"
            raise ServiceError(text)
        return f"{settings.forecast_url} answers: forecast made {age} min ago", told.date

    return _tried(ask, settings.forecast_url or "")


def _tried(ask: Callable[[], Awaitable[tuple[str, str]]], url: str) -> tuple[bool, str]:
    async def asked() -> tuple[str, str]:
        return await ask()

    try:
        text, date = asyncio.run(asked())
    except OutsideError as error:
        return False, f"{url}: {str(error).rstrip('.')}. {error.mend}"
    return True, text + _clock(date)


def _clock(date: str) -> str:
    try:
        ahead_s = (parsedate_to_datetime(date) - datetime.now(UTC)).total_seconds()
    except (ValueError, TypeError):
        return ""
    if abs(ahead_s) <= CLOCK_S:
        return ""
    return f"; its clock is {abs(ahead_s):.0f} s {'ahead of' if ahead_s > 0 else 'behind'} this one"
