"""The forecast in words and as a row; a forecast is always called one, with its age."""

from __future__ import annotations

from datetime import datetime, timedelta
from typing import Any
from zoneinfo import ZoneInfo

from hmi.domain.forecast import Forecast, ForecastAge
from hmi.domain.queue.reason import clock_text

NOT_SET = "No forecast is set."
HOUR = timedelta(hours=1)


def forecast_row(
    forecast: Forecast | None, trouble: str, now: datetime, zone: ZoneInfo, *, is_set: bool = True
) -> dict[str, Any]:
    """Return the forecast as ``GET /sensors`` tells it: state off, fresh, old or failed.

    Args:
        forecast: the newest there is, however old; ``None`` if none ever came.
        trouble: what is wrong with the link, empty if nothing is.
        is_set: a service is set.
    """
    if not is_set:
        return {"state": "off", "sentence": NOT_SET, "made_utc": None, "hours": []}
    why = f" {trouble}." if trouble else ""
    if forecast is None:
        return {"state": "failed", "sentence": f"No forecast.{why or ' None came yet.'}", "made_utc": None, "hours": []}
    reliance, made = forecast.reliance(now), clock_text(forecast.made_at, now, zone)
    age = age_text(forecast.age(now))
    source = f" by {forecast.source}" if forecast.source else ""
    state = "failed" if reliance is ForecastAge.REFUSED else reliance.value
    if reliance is ForecastAge.REFUSED:
        sentence = f"No forecast: the one of {made} is {age} old and not used any more.{why}"
    elif reliance is ForecastAge.OLD:
        sentence = f"Old forecast{source}, made {made}, {age} ago.{why}"
    else:
        sentence = f"Forecast{source}, made {made}, {age} ago."
    hours = [] if reliance is ForecastAge.REFUSED else [_hour(one) for one in forecast.hours if one.utc + HOUR > now]
    return {"state": state, "sentence": sentence, "made_utc": _utc(forecast.made_at), "hours": hours}


def age_text(age: timedelta) -> str:
    """Return an age in minutes or hours."""
    minutes = int(age.total_seconds() // 60)
    return f"{minutes} min" if minutes < 120 else f"{minutes // 60} h"


def _hour(one: Any) -> dict[str, Any]:
    return {
        "utc": _utc(one.utc),
        "air_temperature": one.air_temperature,
        "rain_rate": one.rain_rate,
        "wind_speed": one.wind_speed,
        "wind_gust": one.wind_gust,
    }


def _utc(at: datetime) -> str:
    return at.isoformat(timespec="milliseconds")
