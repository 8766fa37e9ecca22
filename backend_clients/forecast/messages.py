"""What a forecast service answers. Units: degC, mm/h, m/s; times RFC 3339 with offset."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal

from pydantic import AwareDatetime, BaseModel, ConfigDict, Field, field_validator

VERSION: Literal[1] = 1
MAX_ANSWER = 512 * 1024
MAX_HOURS = 240


class _Told(BaseModel):
    """Unknown fields are left alone, newer services may say more; NaN and infinities are refused."""

    model_config = ConfigDict(frozen=True, extra="ignore", allow_inf_nan=False)


class HourForecast(_Told):
    """The hour that begins at ``utc``; null or left out: nothing is said of it."""

    utc: AwareDatetime
    air_temperature: Annotated[float | None, Field(ge=-90, le=65, description="degC, mean of the hour at 2 m")] = None
    rain_rate: Annotated[float | None, Field(ge=0, le=500, description="mm/h, mean of the hour")] = None
    wind_speed: Annotated[float | None, Field(ge=0, le=120, description="m/s, mean of the hour at 10 m")] = None
    wind_gust: Annotated[float | None, Field(ge=0, le=150, description="m/s, highest of the hour")] = None


class ForecastReport(_Told):
    """Answer of ``GET /forecast``."""

    v: Literal[1] = VERSION
    made_utc: Annotated[AwareDatetime, Field(description="when it was made; its age counts from here")]
    lat_deg: Annotated[float, Field(ge=-90, le=90, description="place it is for")]
    lon_deg: Annotated[float, Field(ge=-180, le=180)]
    source: Annotated[str, Field(max_length=80, description="who made it, to be shown")] = ""
    hours: Annotated[list[HourForecast], Field(min_length=1, max_length=MAX_HOURS, description="in order, no gaps")]

    @field_validator("hours")
    @classmethod
    def _in_order(cls, hours: list[HourForecast]) -> list[HourForecast]:
        if any((b.utc - a.utc).total_seconds() != 3600 for a, b in pairwise(hours)):
            raise ValueError("hours must follow one another, an hour apart")
        return hours


class Problem(_Told):
    """Why not."""

    code: Annotated[str, Field(max_length=64)]
    text: Annotated[str, Field(max_length=400)]
