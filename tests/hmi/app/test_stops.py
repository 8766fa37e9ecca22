"""What the console knows of open presses: its own, and those in the gateway's file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from hmi.app.stops import StopDesk
from hmi.clock import FakeClock
from hmi.domain.stop import StopAttempt, StopTarget
from hmi.domain.stop_token import StopToken
from hmi.stop_gateway.outbox import Outbox

MARTHA = StopToken("tablet-3", "Tablet 3", "martha", "Martha Keller", "farm")
NAMESAKE = StopToken("tablet-4", "Tablet 4", "martha-2", "Martha Keller", "farm")
NOBODY = StopToken("tablet-5", "Tablet 5", "", "", "farm")


class Quiet:
    """Stands for registry, wire, audit and leases, none of which these tests look at."""

    def all(self) -> list[Any]:
        return []

    def send(self, _order: object) -> bool:
        return True

    async def stop_by_http(self, _order: object) -> None:
        return None

    def append(self, _entry: object) -> None:
        return None

    def stopped(self, *_told: object) -> None:
        return None


def desk(folder: Path) -> StopDesk:
    quiet: Any = Quiet()
    return StopDesk(quiet, FakeClock(), quiet, quiet, quiet, folder / "outbox.json")


def held_by_gateway(folder: Path, stop_id: str, token: StopToken) -> None:
    """Leave the gateway's file as it is after a press."""
    clock = FakeClock()
    target = StopTarget("weeder-01", "Weeder 01")
    attempt = StopAttempt.press(
        stop_id, target, token.who, token.device_name, now_s=0.0, utc=clock.utc(), user_id=token.user_id
    )
    Outbox(folder / "outbox.json", clock).save([attempt])


async def test_who_pressed_is_known_by_account_from_both_paths(tmp_path: Path) -> None:
    stops = desk(tmp_path)
    held_by_gateway(tmp_path, "press-of-gateway", NAMESAKE)
    stops.press("press-of-console", ["weeder-01"], MARTHA)
    stops.press("press-of-nobody", ["weeder-01"], NOBODY)
    assert await stops.pressers("weeder-01") == {
        "press-of-gateway": {"martha-2"},
        "press-of-console": {"martha"},
        "press-of-nobody": {""},
    }
    assert await stops.pressers("weeder-02") == {}
    await stops.stop()


async def test_who_pressed_survives_a_restart_of_gateway_and_console(tmp_path: Path) -> None:
    held_by_gateway(tmp_path, "press-of-gateway", MARTHA)
    outbox = Outbox(tmp_path / "outbox.json", FakeClock())
    outbox.save(outbox.load())
    assert await desk(tmp_path).pressers("weeder-01") == {"press-of-gateway": {"martha"}}


async def test_a_press_that_only_the_gateway_holds_is_open(tmp_path: Path) -> None:
    stops = desk(tmp_path)
    assert not await stops.is_open_at("weeder-01")
    held_by_gateway(tmp_path, "press-of-gateway", MARTHA)
    assert await stops.is_open_at("weeder-01")
    assert not await stops.is_open_at("weeder-02")


async def test_a_press_of_an_older_version_belongs_to_nobody_known(tmp_path: Path) -> None:
    (tmp_path / "outbox.json").write_text('[{"stop_id": "press-one", "robot": "weeder-01"}]')
    assert await desk(tmp_path).pressers("weeder-01") == {}
