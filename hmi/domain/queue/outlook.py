"""When a rule that waits for weather is expected to clear, in a sentence; the measurement alone decides."""

from __future__ import annotations

from datetime import datetime
from zoneinfo import ZoneInfo

from hmi.domain.forecast import HOUR, Expected, Forecast, clearing
from hmi.domain.queue.reason import clock_text


def outlook_of(
    forecast: Forecast | None,
    place: tuple[float, float] | None,
    what: Expected,
    limit: float,
    now: datetime,
    zone: ZoneInfo,
) -> str:
    """Return a sentence, empty where nothing can be said.

    Args:
        place: longitude and latitude of the field; a forecast for elsewhere says nothing of it.
        limit: that the measured value is over, in the unit of ``what``.
    """
    if forecast is None or (place is not None and not forecast.is_near(place)):
        return ""
    found = clearing(forecast, what, limit, now)
    if found is None:
        return ""
    made = "" if found.age is None else f" made {found.age // HOUR} h ago"
    if found.at is None:
        return f"Forecast{made}: not below {limit:.1f} before {clock_text(found.until, now, zone)}."
    return f"Forecast{made}: below {limit:.1f} from about {clock_text(found.at, now, zone)}."
