"""What speaks to a forecast service; built by ``hmi.app.forecast``."""

from __future__ import annotations

from backend_clients.forecast.client import ForecastClient
from backend_clients.service.connection import Service
from hmi.forecast.http import HttpForecast
from hmi.forecast.port import ForecastSource
from hmi.settings import Settings

ANSWER_S = 8.0


def make_source(settings: Settings) -> ForecastSource:
    """Return the source; raises ``BadRequest`` for settings it cannot work with."""
    assert settings.forecast_url is not None
    ca = str(settings.forecast_ca) if settings.forecast_ca else ""
    return HttpForecast(ForecastClient(Service(settings.forecast_url, settings.forecast_token, ca, ANSWER_S)))
