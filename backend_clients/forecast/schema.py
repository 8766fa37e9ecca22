"""Writes the format for machines: an OpenAPI 3.1 document with JSON Schemas, from the models.

``python -m backend_clients.forecast.schema docs/protocols/forecast`` writes it; a test compares what is committed
with what this makes.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from backend_clients.forecast.messages import MAX_ANSWER, MAX_HOURS, ForecastReport, Problem
from backend_clients.service.openapi import answer, document, parameter, written


def openapi() -> dict[str, Any]:
    """Return the OpenAPI document."""
    lat = parameter("lat_deg", "query", "place, degrees", {"type": "number", "minimum": -90, "maximum": 90})
    lon = parameter("lon_deg", "query", "place, degrees", {"type": "number", "minimum": -180, "maximum": 180})
    hours = parameter("hours", "query", "at most so many", {"type": "integer", "minimum": 1, "maximum": MAX_HOURS})
    tag = parameter("If-None-Match", "header", "the ETag of the last answer", {"type": "string"})
    responses = {
        "200": answer("the newest forecast; ETag tells it from others", "ForecastReport"),
        "304": {"description": "the same as the one of this ETag"},
        "401": answer("the token is missing or wrong", "Problem"),
        "422": answer("the place makes no sense", "Problem"),
        "429": answer("asked too often; Retry-After says when to ask again", "Problem"),
    }
    needed = [{**lat, "required": True}, {**lon, "required": True}, hours, tag]
    get = {"summary": "Weather expected hour by hour", "parameters": needed, "responses": responses}
    about = f"Hourly weather for farms. Answers have at most {MAX_ANSWER} bytes. See forecast.md."
    models: list[type[BaseModel]] = [ForecastReport, Problem]
    return document("Headland weather forecast", about, {"/forecast": {"get": get}}, models)


def main(arguments: Sequence[str] | None = None) -> None:
    """Write the document into the folder named."""
    parser = argparse.ArgumentParser(description="Write the forecast format's OpenAPI document.")
    parser.add_argument("folder", type=Path)
    written(openapi(), parser.parse_args(arguments).folder)


if __name__ == "__main__":
    main()
