"""A press that came to the console alone: the gateway is told until it holds it."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from pathlib import Path

import httpx
import pytest

from hmi.app import stop_relay
from hmi.app.stop_relay import StopRelay
from hmi.clock import FakeClock
from hmi.domain.stop import StopAttempt, StopTarget
from hmi.domain.stop_token import StopToken
from hmi.settings import Settings
from hmi.stop_gateway.outbox import Outbox

ANNA = StopToken("", "a program", "anna", "Anna Ostermeier", "farm")
PRESS = "0123456789abcdef0123456789abcdef"


class FakeGateway:
    """Answers as told; remembers what it was sent, and keeps its outbox as the real one does."""

    def __init__(self, folder: Path) -> None:
        self.settings = Settings(data=folder, demo=True)
        self.statuses: list[int] = []
        self.heard: list[tuple[str, list[str]]] = []
        self.outbox = Outbox(folder / "stop" / "outbox.json", FakeClock())

    def listens(self) -> None:
        note = self.settings.data / "run" / "stop.json"
        note.parent.mkdir(parents=True, exist_ok=True)
        note.write_text(json.dumps({"pid": 1, "port": 8081, "url": "http://farm.example/stop"}))

    def answer(self, request: httpx.Request) -> httpx.Response:
        assert str(request.url) == "http://127.0.0.1:8081/stop"
        token = StopToken.read(request.headers["Authorization"].removeprefix("Bearer "), self.settings.secret)
        body = json.loads(request.content)
        self.heard.append((token.who, body["robots"]))
        status = self.statuses.pop(0) if self.statuses else 202
        if status == 0:
            raise httpx.ConnectError("nobody listens")
        return httpx.Response(status, json={"stop_id": body["stop_id"], "steps": []})

    def holds(self, robot: str) -> None:
        self.outbox.save([
            StopAttempt.press(PRESS, StopTarget(robot, robot), "Anna", "", now_s=0, utc=FakeClock().utc(), user_id="a")
        ])  # fmt: skip

    def relay(self, open_at: Callable[[str], list[str]]) -> StopRelay:
        return StopRelay(self.settings, open_at, httpx.MockTransport(self.answer))


@pytest.fixture
def gateway(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> FakeGateway:
    monkeypatch.setattr(stop_relay, "FIRST_S", 0.01)
    return FakeGateway(tmp_path)


async def settled(relay: StopRelay) -> None:
    async with asyncio.timeout(5):
        await relay.settled()


async def test_the_gateway_is_told_in_the_name_of_who_pressed(gateway: FakeGateway) -> None:
    gateway.listens()
    relay = gateway.relay(lambda _stop_id: ["weeder-10", "weeder-11"])
    relay.press(PRESS, ANNA)
    await settled(relay)
    assert gateway.heard == [("Anna Ostermeier", ["weeder-10", "weeder-11"])]


async def test_what_the_gateway_holds_already_is_not_sent_twice(gateway: FakeGateway) -> None:
    gateway.listens()
    gateway.holds("weeder-10")
    relay = gateway.relay(lambda _stop_id: ["weeder-10"])
    relay.press(PRESS, ANNA)
    await settled(relay)
    assert gateway.heard == []


async def test_it_is_told_when_it_is_back(gateway: FakeGateway) -> None:
    gateway.statuses = [0, 503]
    relay = gateway.relay(lambda _stop_id: ["weeder-10"])
    relay.press(PRESS, ANNA)
    await asyncio.sleep(0.05)
    assert gateway.heard == [], "it has not said where it listens"
    gateway.listens()
    await settled(relay)
    assert len(gateway.heard) == 3


async def test_what_was_reset_meanwhile_is_not_told_any_more(gateway: FakeGateway) -> None:
    gateway.listens()
    gateway.statuses = [0, 0]
    here = ["weeder-10"]
    relay = gateway.relay(lambda _stop_id: list(here))
    relay.press(PRESS, ANNA)
    await asyncio.sleep(0.02)
    here.clear()
    await settled(relay)
    assert len(gateway.heard) == 1


async def test_many_robots_go_in_requests_that_the_gateway_reads(gateway: FakeGateway) -> None:
    gateway.listens()
    robots = [f"{'weeder':x<60}{number}" for number in range(1001)]
    relay = gateway.relay(lambda _stop_id: robots)
    relay.press(PRESS, ANNA)
    await settled(relay)
    assert [len(some) for _who, some in gateway.heard] == [500, 500, 1]
    assert [one for _who, some in gateway.heard for one in some] == robots


async def test_it_ends_with_the_console(gateway: FakeGateway) -> None:
    relay = gateway.relay(lambda _stop_id: ["weeder-10"])
    relay.press(PRESS, ANNA)
    await relay.close()
    await settled(relay)
    assert gateway.heard == []
