"""Planner and forecast in the console: off they load nothing, on they say how they are; their rows, findings, words."""

from __future__ import annotations

import asyncio
import subprocess
import sys
from datetime import UTC, datetime
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from backend_clients.simulator.faulty_http import Fault, FaultyHttp
from backend_clients.simulator.forecast import ForecastEndpoint
from hmi.app import forecast as forecast_module
from hmi.app import planner as planner_module
from hmi.app.forecast import ForecastRoom, middle_of
from hmi.app.planner import PlannerRoom
from hmi.clock import FakeClock, SystemClock
from hmi.keeper.service_checkup import forecast_answers, planner_answers
from hmi.planning_service.application import make_application
from hmi.planning_service.desk import PlanDesk
from hmi.service_link import LinkState
from hmi.settings import Settings
from tests.hmi.missions.rig import farm_map
from tests.hmi.missions.test_document import wish
from tests.hmi.planning_service.rig import HereProcess, until
from tests.served import served


def settings(**values: Any) -> Settings:
    """Return the settings of a demo with some changed."""
    return Settings(demo=True, time_zone="Europe/Amsterdam", **values)


class Features:
    """A farm's map."""

    def all(self, _farm_id: str, kinds: tuple[str, ...]) -> list[Any]:
        """Return what is of these kinds."""
        return [one for one in farm_map() if one.kind in kinds]


class Database:
    """Runs at once."""

    async def run(self, work: Any, *args: Any) -> Any:
        """Return what ``work`` returns."""
        return work(*args)


RECORDS: Any = SimpleNamespace(database=Database(), features=Features())


@pytest.fixture(autouse=True)
def at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Look at services without waiting for the rest of a console."""
    for module in (planner_module, forecast_module):
        monkeypatch.setattr(module, "LATER_S", 0.0)
        monkeypatch.setattr(module, "LOOK_SOON_S", 0.01)
        monkeypatch.setattr(module, "LOOK_EVERY_S", 0.01)


async def test_what_is_not_set_does_nothing_and_says_so() -> None:
    planner = PlannerRoom(settings(), FakeClock())
    forecast = ForecastRoom(settings(), FakeClock(), RECORDS)
    for room in (planner, forecast):
        room.start()
        assert (room.report()["state"], room.findings()) == ("off", ())
        await room.stop()
    assert forecast.row()["state"] == "off"
    assert forecast.latest() is None


@pytest.mark.slow
def test_a_console_without_services_loads_none_of_their_clients() -> None:
    code = (
        "from hmi.app import LEANLY, lean_start\nwith lean_start(*LEANLY): import hmi.app.server\n"
        "import sys; print([n for n in sys.modules if n.startswith(('backend_clients.planner', "
        "'backend_clients.forecast', 'backend_clients.service.connection', 'hmi.planning_service.planner', "
        "'hmi.forecast'))])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.strip() == "[]"


async def test_a_planner_service_is_looked_after_and_its_state_is_shown() -> None:
    faulty = FaultyHttp(make_application(PlanDesk(process=HereProcess())))
    async with served(faulty) as url:
        clock = FakeClock(datetime.now(UTC))  # its answers bear today's date
        room = PlannerRoom(settings(planner_url=url, planner_timeout_s=20), clock)
        room.start()
        await until(lambda: room.report()["state"] == "ok")
        told = room.report()
        assert (told["level"], told["url"], told["last_error"]) == ("ok", url, None)
        assert told["delay_s"] is not None
        assert room.findings() == ()
        faulty.set(fault=Fault.FAIL)
        await until(lambda: room.report()["state"] == "failing")
        assert [one.code for one in room.findings()] == ["planner-away"]
        told = room.report()
        assert (told["level"], told["text"]) == ("bad", "Missions are planned on this server meanwhile.")
        assert told["mend"]
        assert "503" in told["last_error"]["text"]
        faulty.set()
        clock.advance(room.report()["again_in_s"] + 1)
        await until(lambda: room.report()["state"] == "ok")
        assert "503" in room.report()["last_error"]["text"]
        await room.stop()


async def test_settings_that_cannot_be_used_are_shown_and_missions_are_planned_here(tmp_path: Path) -> None:
    room = PlannerRoom(settings(planner_url="https://planner.test", planner_ca=tmp_path / "none.pem"), FakeClock())
    room.start()
    await until(lambda: room.report()["state"] != "connecting")
    assert "no file of authorities" in room.report()["why"]
    assert [one.code for one in room.findings()] == ["planner-away"]
    await room.stop()


@pytest.mark.slow
async def test_a_plan_made_before_the_service_was_looked_for_says_so() -> None:
    room = PlannerRoom(settings(planner_url="http://planner.test"), FakeClock())
    made = await room.candidate(wish())
    assert made.statistics["planned_at"]["text"] == (
        "Planned on this server: the planner service was not reached yet since the start."
    )
    await room.stop()


async def test_the_clock_of_a_planner_service_that_is_off_is_told() -> None:
    clock = SystemClock()
    faulty = FaultyHttp(make_application(PlanDesk(process=HereProcess())), clock=clock)
    faulty.set(clock_s=900.0)
    async with served(faulty, has_date=False) as url:
        room = PlannerRoom(settings(planner_url=url), clock)
        room.start()
        await until(lambda: room.report()["skew_s"] is not None)
        assert room.report()["skew_s"] == pytest.approx(900, abs=5)
        await room.stop()


async def test_a_forecast_that_comes_after_the_end_has_no_effect() -> None:
    clock = FakeClock()
    faulty = FaultyHttp(ForecastEndpoint(clock=clock).application())
    faulty.set(delay_s=0.2)
    async with served(faulty) as url:
        room = ForecastRoom(settings(forecast_url=url), clock, RECORDS)
        room.start()
        await until(lambda: faulty.requests > 0)
        await room.stop()
        assert room.latest() is None
        assert room.report()["heard_utc"] is None


@pytest.mark.slow
async def test_plans_of_the_room_come_from_the_service_and_rests_do_not() -> None:
    async with served(make_application(PlanDesk(process=HereProcess()))) as url:
        room = PlannerRoom(settings(planner_url=url), SystemClock())
        room.start()
        await until(lambda: room.report()["state"] == "ok")
        made = await room.plan(wish())
        assert made.statistics["planned_at"]["where"] == "service"
        await room.stop()


async def test_a_forecast_comes_for_the_middle_of_the_farm_and_grows_old_when_its_service_is_away() -> None:
    clock = FakeClock()
    faulty = FaultyHttp(ForecastEndpoint(clock=clock).application())
    async with served(faulty) as url:
        room = ForecastRoom(settings(forecast_url=url), clock, RECORDS)
        room.start()
        await until(lambda: room.latest() is not None)
        found = room.latest()
        assert found is not None
        assert found.is_near(middle_of(farm_map()[0].geometry))
        assert room.row()["state"] == "fresh"
        assert len(room.row()["hours"]) == 48
        assert room.report()["facts"][0] == ["Newest forecast", "0 min old"]
        faulty.set(fault=Fault.NOT_JSON)
        clock.advance(4 * 3600)
        await until(lambda: room.report()["state"] == "not_understood")
        assert room.row()["state"] == "old"
        assert room.row()["sentence"].endswith("The service: its answers cannot be used.")
        # its answers bear today's date, which the clock of this test has left behind
        assert [one.code for one in room.findings()] == ["forecast-away", "service-clock"]
        clock.advance(21 * 3600)
        assert (room.latest(), room.row()["state"]) == (None, "failed")
        await room.stop()


async def test_the_check_of_an_installation_asks_both() -> None:
    async with (
        served(make_application(PlanDesk(process=HereProcess()), "right")) as planner,
        served(ForecastEndpoint().application()) as forecast,
    ):
        good = settings(planner_url=planner, planner_token="right", forecast_url=forecast)
        bad = settings(planner_url=planner, planner_token="wrong", forecast_url=planner)
        for asked, is_ok in ((good, True), (bad, False)):
            assert (await asyncio.to_thread(planner_answers, asked))[0] is is_ok
            assert (await asyncio.to_thread(forecast_answers, asked))[0] is is_ok
        text = (await asyncio.to_thread(planner_answers, bad))[1]
        assert text.endswith("The token is missing or wrong. Check the token.")
        assert "right" not in text.replace("wrong", "")


def test_an_address_with_credentials_in_it_is_refused() -> None:
    for name in ("planner_url", "forecast_url"):
        with pytest.raises(ValueError, match="without name and password"):
            settings(**{name: "https://me:secret@planner.example"})


def test_a_link_that_is_away_is_an_alarm_and_one_that_connects_is_none() -> None:
    room = PlannerRoom(settings(planner_url="http://planner.test"), FakeClock())
    assert (room.report()["state"], room.findings()) == (LinkState.CONNECTING.value, ())
