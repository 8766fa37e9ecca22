"""The forecast's format and client over real HTTP: what is taken, what is refused, and that nothing comes twice."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from pydantic import SecretStr

from backend_clients.forecast.client import ForecastClient
from backend_clients.forecast.messages import ForecastReport
from backend_clients.forecast.schema import main, openapi
from backend_clients.service import errors
from backend_clients.service.connection import Service
from backend_clients.simulator.faulty_http import Fault, FaultyHttp
from backend_clients.simulator.field.weather import Weather
from backend_clients.simulator.forecast import ForecastEndpoint
from hmi.clock import FakeClock
from hmi.keeper.certificates import make_certificates
from tests.served import served

DOCS = Path(__file__).parents[3] / "docs/protocols/forecast"
PLACE = (51.78, 4.26)


def test_generating_gives_the_committed_file(tmp_path: Path) -> None:
    main([str(tmp_path)])
    made, kept = ((folder / "openapi.json").read_text("utf-8") for folder in (tmp_path, DOCS))
    assert made == kept, "run: python -m backend_clients.forecast.schema docs/protocols/forecast"


async def test_a_forecast_is_asked_for_once_and_then_only_if_it_is_another() -> None:
    clock = FakeClock(datetime(2026, 6, 15, 10, 20, tzinfo=UTC))
    service = FaultyHttp(ForecastEndpoint(token="t", clock=clock).application())
    async with served(service) as url:
        client = ForecastClient(Service(url, SecretStr("t")))
        first, date = await client.forecast(*PLACE, 48)
        assert first is not None
        assert (first.made_utc, len(first.hours)) == (datetime(2026, 6, 15, 10, tzinfo=UTC), 48)
        assert date
        assert (await client.forecast(*PLACE, 48))[0] is None
        clock.advance(3600)
        assert (await client.forecast(*PLACE, 48))[0] is not None
        client.forget()
        assert (await client.forecast(*PLACE, 48))[0] is not None
        await client.close()


async def test_the_simulated_service_forecasts_the_simulated_weather_better_the_nearer() -> None:
    clock = FakeClock(datetime(2026, 6, 15, 10, tzinfo=UTC))
    async with served(ForecastEndpoint(seed=3, clock=clock).application()) as url:
        client = ForecastClient(Service(url))
        report, _ = await client.forecast(*PLACE, 48)
        await client.close()
    assert report is not None
    schema = {"$ref": "#/components/schemas/ForecastReport", "components": openapi()["components"]}
    jsonschema.validate(report.model_dump(mode="json"), schema)
    weather = Weather(3, *PLACE)
    off = [
        abs((one.wind_speed or 0.0) - weather.wind_mps((one.utc + timedelta(minutes=30)).timestamp()))
        for one in report.hours
    ]
    assert max(off) < 1.5
    assert all(0 <= (one.rain_rate or 0.0) < 20 for one in report.hours)


HOURS = [{"utc": f"2026-06-15T{hour}:00:00Z", "wind_speed": 3.0} for hour in (10, 11)]
REPORT = {"v": 1, "made_utc": "2026-06-15T10:00:00Z", "lat_deg": 51.78, "lon_deg": 4.26, "hours": HOURS}


@pytest.mark.parametrize(
    "change",
    [
        {"v": 2},
        {"made_utc": "2026-06-15T10:00:00"},
        {"made_utc": "yesterday"},
        {"hours": []},
        {"hours": HOURS[::-1]},
        {"hours": [HOURS[0], HOURS[0]]},
        {"hours": [{**HOURS[0], "wind_speed": 400}]},
        {"hours": [{**HOURS[0], "wind_speed": "NaN"}]},
        {"hours": HOURS * 200},
        {"lat_deg": 10.0},
        {"lon_deg": 184.0},
    ],
)
async def test_an_answer_that_cannot_be_used_is_refused(change: dict[str, Any]) -> None:
    service = FaultyHttp(ForecastEndpoint().application())
    service.set(alter=lambda _report: {**REPORT, **change})
    async with served(service) as url:
        client = ForecastClient(Service(url))
        with pytest.raises(errors.Unreadable):
            await client.forecast(*PLACE, 48)
        await client.close()


def test_a_service_may_say_more_than_the_format_knows_and_less_of_an_hour() -> None:
    report = ForecastReport.model_validate({**REPORT, "hours": [{"utc": HOURS[0]["utc"], "snow": 1}], "more": 2})
    assert report.hours[0].wind_speed is None


@pytest.mark.parametrize(
    ("fault", "kind"),
    [
        (Fault.FAIL, errors.ServiceFailed),
        (Fault.REFUSE, errors.NotAllowed),
        (Fault.TOO_LARGE, errors.TooLarge),
        (Fault.NOT_JSON, errors.Unreadable),
        (Fault.HUGE, errors.TooLong),
        (Fault.CUT, errors.Unreachable),
        (Fault.HALF_OPEN, errors.NoAnswer),
    ],
)
async def test_each_fault_of_a_service_has_its_own_error(fault: Fault, kind: type[errors.ServiceError]) -> None:
    service = FaultyHttp(ForecastEndpoint().application())
    service.set(fault=fault)
    async with served(service) as url:
        client = ForecastClient(Service(url, timeout_s=0.3 if fault is Fault.HALF_OPEN else 30.0))
        with pytest.raises(kind):
            await client.forecast(*PLACE, 48)
        await client.close()


async def test_a_slow_service_is_not_waited_for_longer_than_is_set() -> None:
    service = FaultyHttp(ForecastEndpoint().application())
    service.set(delay_s=30.0)
    async with served(service) as url:
        client = ForecastClient(Service(url, timeout_s=0.2))
        with pytest.raises(errors.NoAnswer, match=r"no answer in 0\.2 s"):
            await client.forecast(*PLACE, 48)
        await client.close()


async def test_a_certificate_that_is_not_ours_is_not_trusted_and_one_that_is_named_is(tmp_path: Path) -> None:
    made = make_certificates(["127.0.0.1"], tmp_path, days=2)
    async with served(ForecastEndpoint().application(), cert=made.cert, key=made.key) as url:
        stranger, friend = ForecastClient(Service(url)), ForecastClient(Service(url, ca=str(made.ca)))
        with pytest.raises(errors.Untrusted) as refused:
            await stranger.forecast(*PLACE, 48)
        assert "its authority in the settings" in refused.value.mend
        assert (await friend.forecast(*PLACE, 48))[0] is not None
        for client in (stranger, friend):
            await client.close()


async def test_the_simulated_service_refuses_a_place_that_is_none() -> None:
    async with served(ForecastEndpoint().application()) as url:
        client = ForecastClient(Service(url))
        with pytest.raises(errors.ServiceRefused, match="Say lat_deg"):
            await client.forecast(*PLACE, 999)
        await client.close()
