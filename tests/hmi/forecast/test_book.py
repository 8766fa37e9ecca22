"""The forecast a console keeps: asked now and then, old ones refused, a service that fails left alone."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from zoneinfo import ZoneInfo

import pytest

from backend_clients.forecast.client import ForecastClient
from backend_clients.service.connection import Service
from backend_clients.service.errors import ServiceFailed
from backend_clients.simulator.faulty_http import FaultyHttp
from backend_clients.simulator.forecast import ForecastEndpoint
from hmi.clock import FakeClock
from hmi.domain.forecast import Forecast, Hour
from hmi.forecast.book import ASK_EVERY_S, ForecastBook
from hmi.forecast.http import HttpForecast
from hmi.forecast.port import Told
from hmi.presenters.forecast import forecast_row
from hmi.service_link import LinkState, ServiceLink
from tests.served import served

NOW = datetime(2026, 6, 15, 12, 20, tzinfo=UTC)
ZONE = ZoneInfo("Europe/Amsterdam")
PLACE = (4.26, 51.78)


def made(age: timedelta, source: str = "Test") -> Forecast:
    """Return a forecast of that age."""
    begin = (NOW - age).replace(minute=0)
    hours = tuple(Hour(begin + timedelta(hours=k), 15.0, 0.0, 6.0, 9.0) for k in range(48))
    return Forecast(NOW - age, hours, PLACE, source)


class Source:
    """A service that is played."""

    def __init__(self) -> None:
        self.told: Forecast | Exception | None = made(timedelta(minutes=20))
        self.asked = self.forgot = 0

    async def ask(self, place: tuple[float, float], hours: int) -> Told:
        """See ``ForecastSource``."""
        self.asked += 1
        assert (place, hours) == (PLACE, 48)
        if isinstance(self.told, Exception):
            raise self.told
        return Told(self.told)

    def forget(self) -> None:
        """See ``ForecastSource``."""
        self.forgot += 1

    async def close(self) -> None:
        """See ``ForecastSource``."""


class Rig:
    """A book with a played service."""

    def __init__(self) -> None:
        self.clock, self.source = FakeClock(NOW), Source()
        self.link = ServiceLink(self.clock, jitter=1.0)
        self.place: tuple[float, float] | None = PLACE
        self.book = ForecastBook(self.source, self.link, self.clock, self._place)

    async def _place(self) -> tuple[float, float] | None:
        return self.place


async def test_it_is_asked_each_half_hour_and_not_where_there_is_no_farm_yet() -> None:
    rig = Rig()
    rig.place = None
    await rig.book.look()
    assert rig.source.asked == 0
    rig.place = PLACE
    for _ in range(3):
        await rig.book.look()
    assert (rig.source.asked, rig.link.state) == (1, LinkState.OK)
    assert rig.book.latest is rig.source.told
    rig.clock.advance(ASK_EVERY_S)
    rig.source.told = None
    await rig.book.look()
    assert rig.source.asked == 2
    assert rig.book.latest is not None


@pytest.mark.parametrize(
    ("age", "words"),
    [(timedelta(hours=25), "25 h old"), (-timedelta(minutes=12), "12 min in the future; check both clocks")],
)
async def test_too_old_a_forecast_and_one_from_the_future_are_refused(age: timedelta, words: str) -> None:
    rig = Rig()
    rig.source.told = made(age)
    await rig.book.look()
    assert rig.book.latest is None
    assert rig.link.state is LinkState.NOT_UNDERSTOOD
    assert words in rig.link.why
    assert rig.source.forgot == 1


async def test_a_service_that_fails_is_left_alone_longer_each_time_and_what_is_known_grows_old() -> None:
    rig = Rig()
    await rig.book.look()
    rig.source.told = ServiceFailed(503, "")
    rig.clock.advance(ASK_EVERY_S)
    pauses = []
    for _ in range(8):
        await rig.book.look()
        await rig.book.look()
        pauses.append(round(rig.link.again_in_s))
        rig.clock.advance(rig.link.again_in_s)
    assert rig.source.asked == 9
    assert pauses == [10, 20, 40, 80, 160, 300, 300, 300]
    assert rig.book.latest is not None
    rig.clock.advance(24 * 3600)
    assert rig.book.latest is None
    assert rig.book.kept is not None


async def test_an_older_one_does_not_take_the_place_of_a_newer_one() -> None:
    rig = Rig()
    await rig.book.look()
    newer = rig.book.latest
    rig.source.told = made(timedelta(hours=2))
    rig.clock.advance(ASK_EVERY_S)
    await rig.book.look()
    assert rig.book.latest is newer


async def test_a_clock_that_is_off_is_seen() -> None:
    clock = FakeClock(datetime.now(UTC))
    faulty = FaultyHttp(ForecastEndpoint(clock=clock).application(), clock=clock)
    faulty.set(clock_s=-3600.0)
    async with served(faulty, has_date=False) as url:
        link, source = ServiceLink(clock), HttpForecast(ForecastClient(Service(url)))

        async def place() -> tuple[float, float]:
            return PLACE

        book = ForecastBook(source, link, clock, place)
        await book.look()
        await source.close()
    assert link.is_well
    assert link.skew_s is not None
    assert link.skew_s == pytest.approx(-3600, abs=5)
    assert book.latest is not None
    assert book.latest.source == "Simulated service"


def test_a_row_says_what_it_is_and_how_old() -> None:
    fresh = forecast_row(made(timedelta(minutes=20)), "", NOW, ZONE)
    assert (fresh["state"], fresh["sentence"]) == ("fresh", "Forecast by Test, made 14:00, 20 min ago.")
    assert fresh["hours"][0] == {
        "utc": "2026-06-15T12:00:00.000+00:00", "air_temperature": 15.0, "rain_rate": 0.0, "wind_speed": 6.0,
        "wind_gust": 9.0,
    }  # fmt: skip
    old = forecast_row(made(timedelta(hours=5)), "The service: not reachable", NOW, ZONE)
    assert (old["state"], old["sentence"]) == (
        "old", "Old forecast by Test, made 09:20, 5 h ago. The service: not reachable.",
    )  # fmt: skip
    gone = forecast_row(made(timedelta(hours=30)), "", NOW, ZONE)
    assert (gone["state"], gone["hours"]) == ("failed", [])
    assert "30 h old and not used any more" in gone["sentence"]
    assert (
        forecast_row(None, "The service: connecting", NOW, ZONE)["sentence"] == "No forecast. The service: connecting."
    )
    assert forecast_row(None, "", NOW, ZONE, is_set=False)["state"] == "off"
