"""STOP over a real broker and real HTTP, the gateway in its own process."""

from __future__ import annotations

import asyncio
import contextlib
import json
import subprocess
import sys
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import httpx
import psutil
import pytest
from websockets.asyncio.client import connect
from websockets.exceptions import InvalidStatus

from hmi.app.stop_relay import StopRelay
from hmi.domain.stop_token import StopToken
from hmi.keeper.ports import free_port
from hmi.settings import Settings
from tests.hmi.stop_gateway.broker import Broker
from tests.hmi.stop_gateway.conftest import MakeRobot
from tests.hmi.stop_gateway.running import CONSOLE_PORT, SECRET, TOKEN, RunningGateway, Tablet

pytestmark = pytest.mark.broker
OpenTablet = Callable[[], Awaitable[Tablet]]


async def _linked(tablet: Tablet, *robots: str) -> None:
    """Wait until the gateway hears the robots."""
    await tablet.until_frame(
        "hb", lambda f: all((f["robots"].get(r) or {}).get("heard_ms") is not None for r in robots)
    )


def is_late(step: dict[str, Any]) -> bool:
    """Say whether a busy machine missed the limits; then NOT CONFIRMED in between is the truth."""
    return bool(step["ack_ms"] > 1000 or step["standstill_ms"] > 1000)


async def _until_answer(http: httpx.AsyncClient, path: str, is_right: Callable[[httpx.Response], bool]) -> None:
    """Ask over and over, as a browser without a websocket would, until the answer is right."""
    async with asyncio.timeout(5):
        answer = await http.get(path)
        while not is_right(answer):
            answer = await http.get(path)


async def test_a_press_is_sent_acknowledged_and_confirmed_with_its_times(
    gateway: RunningGateway, make_robot: MakeRobot, open_tablet: OpenTablet
) -> None:
    robot = await make_robot(speed_mps=0.5)
    gateway.register(robot)
    gateway.start()
    tablet = await open_tablet()
    await _linked(tablet, robot.id)
    stop_id = await tablet.press([robot.id])
    step = await tablet.until_state(stop_id, robot.id, "standstill")
    states = tablet.states[stop_id, robot.id]
    assert states == ["sent", "acknowledged", "standstill"] or is_late(step), states
    assert step["by"] == "Martha Keller"
    assert step["device"] == "Tablet 3"
    assert step["sent_ms"] <= step["ack_ms"] < step["standstill_ms"]
    assert step["standstill_ms"] >= 500  # zero for half a second is what standstill means
    assert step["stopping_distance_m"] == 0.31
    assert robot.stops_by_mqtt[0] == robot.stops_by_http[0] == stop_id
    assert robot.speed_mps == 0


async def test_copies_end_once_standstill_is_confirmed(
    gateway: RunningGateway, make_robot: MakeRobot, open_tablet: OpenTablet
) -> None:
    robot = await make_robot(speed_mps=0.5)
    gateway.register(robot)
    gateway.start()
    tablet = await open_tablet()
    await _linked(tablet, robot.id)
    stop_id = await tablet.press([robot.id])
    step = await tablet.until_state(stop_id, robot.id, "standstill")
    assert step["count"] >= 3  # 5 Hz while it brakes
    heard = len(robot.stops_by_mqtt)
    beats = len([f for f in tablet.frames if f["k"] == "hb"])
    await tablet.until(lambda t: len([f for f in t.frames if f["k"] == "hb"]) >= beats + 3)
    assert len(robot.stops_by_mqtt) <= heard + 1  # one may have been on its way


async def test_without_the_broker_stop_goes_by_http_and_standstill_comes_back_by_http(
    gateway: RunningGateway, make_robot: MakeRobot, open_tablet: OpenTablet, broker: Broker
) -> None:
    robot = await make_robot(speed_mps=0.4)
    gateway.register(robot)
    gateway.start()
    tablet = await open_tablet()
    await _linked(tablet, robot.id)
    broker.kill()
    await tablet.until_frame("hb", lambda f: f["broker"] == "down")
    stop_id = await tablet.press([robot.id])
    step = await tablet.until_state(stop_id, robot.id, "standstill")
    assert step["ack_ms"] is not None
    assert step["paths"]["mqtt"] == 0
    assert step["paths"]["http"] >= 1
    assert not robot.stops_by_mqtt


async def test_a_robot_that_is_silent_is_not_confirmed_and_a_late_confirmation_counts(
    gateway: RunningGateway, make_robot: MakeRobot, open_tablet: OpenTablet
) -> None:
    robot = await make_robot(is_silent=True)
    gateway.register(robot)
    gateway.start()
    tablet = await open_tablet()
    await tablet.until_frame("hello")
    stop_id = await tablet.press([robot.id])
    step = await tablet.until_state(stop_id, robot.id, "not-confirmed")
    assert step["age_ms"] >= 1000
    assert step["ack_ms"] is None
    robot.is_silent = False
    step = await tablet.until_state(stop_id, robot.id, "standstill")
    assert step["ack_ms"] > 1000


async def test_a_robot_that_acknowledges_but_keeps_moving_is_not_confirmed(
    gateway: RunningGateway, make_robot: MakeRobot, open_tablet: OpenTablet
) -> None:
    robot = await make_robot(is_runaway=True, speed_mps=0.5)
    gateway.register(robot)
    gateway.start()
    tablet = await open_tablet()
    await _linked(tablet, robot.id)
    stop_id = await tablet.press([robot.id])
    step = await tablet.until_state(stop_id, robot.id, "not-confirmed")
    states = tablet.states[stop_id, robot.id]
    assert states == ["sent", "acknowledged", "not-confirmed"] or step["ack_ms"] > 1000, states
    assert step["age_ms"] >= 1250  # 0.5 / 2.0 + 1 s


async def test_a_robot_that_moves_after_it_confirmed_is_not_confirmed_again(
    gateway: RunningGateway, make_robot: MakeRobot, open_tablet: OpenTablet
) -> None:
    robot = await make_robot(speed_mps=0.2)
    gateway.register(robot)
    gateway.start()
    tablet = await open_tablet()
    await _linked(tablet, robot.id)
    stop_id = await tablet.press([robot.id])
    await tablet.until_state(stop_id, robot.id, "standstill")
    robot.is_runaway, robot.speed_mps = True, 0.3
    step = await tablet.until_state(stop_id, robot.id, "not-confirmed")
    assert step["standstill_ms"] is None
    robot.is_runaway = False
    await tablet.until_state(stop_id, robot.id, "standstill")


async def test_a_stopped_robot_whose_safety_controller_falls_silent_is_asked_by_http(
    gateway: RunningGateway, make_robot: MakeRobot, open_tablet: OpenTablet
) -> None:
    robot = await make_robot(speed_mps=0.3)
    gateway.register(robot)
    gateway.start()
    tablet = await open_tablet()
    await _linked(tablet, robot.id)
    stop_id = await tablet.press([robot.id])
    await tablet.until_state(stop_id, robot.id, "standstill")
    robot.is_mute = robot.is_runaway = True
    robot.speed_mps = 0.3
    step = await tablet.until_state(stop_id, robot.id, "not-confirmed")
    assert step["text"] == "It moves although it confirmed standstill."


async def test_a_killed_gateway_goes_on_with_the_press_after_its_restart(
    gateway: RunningGateway, make_robot: MakeRobot, open_tablet: OpenTablet
) -> None:
    robot = await make_robot(is_deaf=True, is_runaway=True)
    gateway.register(robot)
    gateway.start()
    tablet = await open_tablet()
    await _linked(tablet, robot.id)
    stop_id = await tablet.press([robot.id])
    await tablet.until_state(stop_id, robot.id, "not-confirmed")
    outbox = gateway.data / "stop" / "outbox.json"
    assert json.loads(outbox.read_text())[0]["stop_id"] == stop_id
    old_url = gateway.url
    gateway.kill()
    robot.is_deaf = robot.is_runaway = False
    gateway.start()
    assert gateway.url == old_url  # browsers find it again
    after = await open_tablet()
    step = await after.until_state(stop_id, robot.id, "standstill")
    assert step["by"] == "Martha Keller"
    assert robot.speed_mps == 0


async def test_a_robot_that_was_off_gets_the_stop_first_when_it_returns(
    gateway: RunningGateway, make_robot: MakeRobot, open_tablet: OpenTablet
) -> None:
    gateway.data.mkdir(parents=True, exist_ok=True)
    gateway.start()
    tablet = await open_tablet()
    await tablet.until_frame("hello")
    stop_id = await tablet.press(["weeder-01"])
    await tablet.until_state(stop_id, "weeder-01", "not-confirmed")
    robot = await make_robot("weeder-01", speed_mps=0.3)
    step = await tablet.until_state(stop_id, "weeder-01", "standstill")
    assert robot.is_latched
    assert step["standstill_ms"] > 1000


async def test_stop_all_counts_only_robots_that_confirmed(
    gateway: RunningGateway, make_robot: MakeRobot, open_tablet: OpenTablet
) -> None:
    robots = [await make_robot(f"weeder-0{n}", speed_mps=0.3) for n in (1, 2, 3)]
    robots[2].is_silent = True
    gateway.register(*robots)
    gateway.start()
    tablet = await open_tablet()
    await _linked(tablet, "weeder-01", "weeder-02")
    stop_id = await tablet.press("all")
    await tablet.until_state(stop_id, "weeder-01", "standstill")
    await tablet.until_state(stop_id, "weeder-02", "standstill")
    await tablet.until_state(stop_id, "weeder-03", "not-confirmed")
    async with gateway.http() as http:
        steps = (await http.get(f"/stop/{stop_id}")).json()["steps"]
    assert sorted((s["robot"], s["state"]) for s in steps) == [
        ("weeder-01", "standstill"),
        ("weeder-02", "standstill"),
        ("weeder-03", "not-confirmed"),
    ]


async def test_stop_all_stops_a_machine_that_is_heard_but_not_registered_and_names_it_so(
    gateway: RunningGateway, make_robot: MakeRobot, open_tablet: OpenTablet
) -> None:
    stranger = await make_robot("weeder-09", speed_mps=0.3)
    gateway.register()  # a list without robots
    gateway.start()
    tablet = await open_tablet()
    await _linked(tablet, stranger.id)
    stop_id = await tablet.press("all")
    step = await tablet.until_state(stop_id, stranger.id, "standstill")
    assert (step["name"], stranger.speed_mps) == ("weeder-09 (not registered)", 0)


async def test_a_reset_ends_the_press_and_no_late_copy_latches_again(
    gateway: RunningGateway, make_robot: MakeRobot, open_tablet: OpenTablet
) -> None:
    robot = await make_robot(speed_mps=0.2)
    gateway.register(robot)
    gateway.start()
    tablet = await open_tablet()
    await _linked(tablet, robot.id)
    stop_id = await tablet.press([robot.id])
    confirmed = await tablet.until_state(stop_id, robot.id, "standstill")
    robot.reset(stop_id)
    await tablet.until_state(stop_id, robot.id, "reset")
    assert "not-confirmed" not in tablet.states[stop_id, robot.id] or is_late(confirmed)
    await tablet.send({"k": "stop", "stop_id": stop_id, "robots": [robot.id]})
    await tablet.send({"k": "ping", "n": 7})
    await tablet.until_frame("pong")
    assert not robot.is_latched
    latecomer = await open_tablet()
    await latecomer.until_frame("hb")
    assert not latecomer.steps


async def test_a_robot_taken_out_of_the_list_keeps_its_stop_until_it_answers(
    gateway: RunningGateway, make_robot: MakeRobot, open_tablet: OpenTablet
) -> None:
    robot, other = await make_robot("weeder-01", speed_mps=0.2), await make_robot("weeder-02")
    gateway.register(robot, other)
    gateway.start()
    tablet = await open_tablet()
    await _linked(tablet, robot.id, other.id)
    stop_id = await tablet.press([robot.id])
    await tablet.until_state(stop_id, robot.id, "standstill")
    gateway.register(other)
    async with gateway.http() as http:
        await _until_answer(http, "/health", lambda a: a.json()["robots"] == 1)
        assert [s["state"] for s in (await http.get(f"/stop/{stop_id}")).json()["steps"]] == ["standstill"]
    robot.reset(stop_id)
    await tablet.until_state(stop_id, robot.id, "reset")


async def test_http_alone_stops_a_robot_and_a_token_in_the_body_spares_the_preflight(
    gateway: RunningGateway, make_robot: MakeRobot
) -> None:
    robot = await make_robot(speed_mps=0.2)
    gateway.register(robot)
    gateway.start()
    async with gateway.http() as http:
        body = json.dumps({"stop_id": "a" * 32, "robots": [robot.id], "token": TOKEN})
        del http.headers["Authorization"]
        answer = await http.post("/stop", content=body, headers={"Content-Type": "text/plain"})
        assert answer.status_code == 202
        assert answer.json()["steps"][0]["robot"] == robot.id
        http.headers["Authorization"] = f"Bearer {TOKEN}"
        await _until_answer(http, f"/stop/{'a' * 32}", lambda a: a.json()["steps"][0]["state"] == "standstill")


@pytest.mark.parametrize("token", ["", "nonsense", TOKEN[:-2] + "xx", "x" * 5000, "é\x00"])
async def test_a_token_that_is_not_ours_is_refused(gateway: RunningGateway, token: str) -> None:
    gateway.start()
    tablet = await Tablet.open(gateway, token)
    refused = await tablet.until_frame("refused")
    assert refused["code"] == "bad_token"
    await tablet.close()
    assert tablet.close_code == 4401
    async with gateway.http() as http:
        body = {"stop_id": "a" * 32, "robots": "all", "token": token}
        answer = await http.post("/stop", json=body, headers={"Authorization": ""})
        assert answer.status_code == 401


async def test_a_revoked_tablet_is_refused_as_soon_as_the_file_says_so(
    gateway: RunningGateway, make_robot: MakeRobot, open_tablet: OpenTablet
) -> None:
    robot = await make_robot()
    gateway.register(robot)
    gateway.start()
    tablet = await open_tablet()
    await _linked(tablet, robot.id)
    (gateway.data / "stop" / "revoked.json").write_text('["tablet-3"]')
    async with gateway.http() as http:
        await _until_answer(http, "/stop/unknown-id", lambda a: a.status_code == 401)
    await tablet.press([robot.id])
    assert (await tablet.until_frame("error"))["code"] == "bad_token"
    assert not robot.stops_by_mqtt


async def test_garbage_gets_an_answer_and_the_gateway_goes_on(
    gateway: RunningGateway, make_robot: MakeRobot, open_tablet: OpenTablet
) -> None:
    robot = await make_robot(speed_mps=0.2)
    gateway.register(robot)
    gateway.start()
    tablet = await open_tablet()
    await _linked(tablet, robot.id)
    garbage: list[str | bytes] = [
        "", "{", "[]", "null", "7", '"stop"', "{}", '{"k":7}', '{"k":"stop"}', b"\xff\xfe\x00",
        '{"k":"stop","stop_id":7,"robots":"all"}',
        '{"k":"stop","stop_id":"../../etc","robots":"all"}',
        '{"k":"stop","stop_id":"aaaaaaaa\\n","robots":"all"}',
        '{"k":"stop","stop_id":"aaaaaaaa","robots":"some"}',
        '{"k":"stop","stop_id":"aaaaaaaa","robots":[]}',
        '{"k":"stop","stop_id":"aaaaaaaa","robots":["#"]}',
        '{"k":"stop","stop_id":"aaaaaaaa","robots":["+/stop"]}',
        '{"k":"ping","n":NaN}', '{"k":"ping","n":-1}', '{"k":"ping","n":1e999}', "[" * 5000,
    ]  # fmt: skip
    for frame in garbage:
        before = len([f for f in tablet.frames if f["k"] == "error"])
        await tablet.send(frame)
        await tablet.until(lambda t, n=before: len([f for f in t.frames if f["k"] == "error"]) > n)
    async with gateway.http() as http:
        for content in (b"", b"{", b"[1]", b"\xff", b"x" * 200_000, b'{"stop_id":"aaaaaaaa","robots":null}'):
            assert (await http.post("/stop", content=content)).status_code == 400
    stop_id = await tablet.press([robot.id])
    await tablet.until_state(stop_id, robot.id, "standstill")


async def test_a_frame_over_the_limit_closes_only_that_browser(
    gateway: RunningGateway, open_tablet: OpenTablet
) -> None:
    gateway.start()
    rude, polite = await open_tablet(), await open_tablet()
    await polite.until_frame("hello")
    await rude.send("x" * 100_000)
    await rude.until(lambda t: t.close_code is not None)
    await polite.send({"k": "ping", "n": 3})
    assert (await polite.until_frame("pong"))["n"] == 3


async def test_only_pages_of_the_console_may_connect(gateway: RunningGateway) -> None:
    gateway.start()
    address = gateway.url.replace("http", "ws") + "/ws"
    for origin in (f"http://192.168.1.20:{CONSOLE_PORT}", f"https://farm.local:{CONSOLE_PORT}"):
        async with connect(address, origin=origin):
            pass
    for origin in ("http://evil.example", f"http://evil.example:{CONSOLE_PORT + 1}", "null"):
        with pytest.raises(InvalidStatus):
            await connect(address, origin=origin)
    async with gateway.http() as http:
        asked = {
            "Origin": f"http://farm.local:{CONSOLE_PORT}",
            "Access-Control-Request-Method": "POST",
            "Access-Control-Request-Headers": "authorization,content-type",
        }
        answer = await http.options("/stop", headers=asked)
        assert answer.headers["access-control-allow-origin"] == f"http://farm.local:{CONSOLE_PORT}"
        assert answer.headers["access-control-max-age"] == "86400"
        answer = await http.options("/stop", headers=asked | {"Origin": "http://evil.example"})
        assert "access-control-allow-origin" not in answer.headers


async def test_health_needs_no_token_and_tells_the_pid_on_loopback_only(gateway: RunningGateway) -> None:
    gateway.start()
    async with gateway.http() as http:
        health = (await http.get("/health", headers={"Authorization": ""})).json()
        assert health["pid"] == gateway.pid
        assert {"status", "version", "broker", "robots", "clients"} <= set(health)
        assert "pid" not in (await http.get("/health", headers={"X-Forwarded-For": "1.2.3.4"})).json()


def test_it_loads_no_screen_and_no_database_so_that_it_starts_at_once() -> None:
    heavy = {"nicegui", "fastapi", "sqlalchemy", "numpy", "shapely"}
    code = f"import sys, hmi.stop_gateway.process; print(sorted({heavy!r} & set(sys.modules)))"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"


async def test_it_ends_at_once_with_browsers_connected(gateway: RunningGateway, open_tablet: OpenTablet) -> None:
    gateway.start()
    tablet = await open_tablet()
    await tablet.until_frame("hello")
    assert gateway.terminate() < 2.0
    await tablet.until(lambda t: t.close_code == 1012)


async def test_it_ends_within_a_second_while_the_broker_is_away(gateway: RunningGateway, broker: Broker) -> None:
    broker.kill()
    gateway.start()
    assert gateway.terminate() < 2.0


async def test_a_press_that_only_the_console_heard_is_shown_by_every_slab(
    gateway: RunningGateway, make_robot: MakeRobot, open_tablet: OpenTablet
) -> None:
    robot = await make_robot()
    gateway.register(robot)
    gateway.start()
    tablet = await open_tablet()
    await _linked(tablet, robot.id)
    settings = Settings(
        data=gateway.data, secret=SECRET, broker_url="mqtt://127.0.0.1:1", host="127.0.0.1", stop_port=0
    )
    relay = StopRelay(settings, lambda _stop_id: [robot.id])
    relay.press("from-a-program-1", StopToken("", "a program", "anna", "Anna Ostermeier", "farm"))
    step = await tablet.until_frame("step", lambda f: f["stop_id"] == "from-a-program-1" and f["state"] == "standstill")
    assert (step["robot"], step["by"], step["device"]) == (robot.id, "Anna Ostermeier", "a program")
    await relay.settled()


async def test_a_disk_that_takes_nothing_does_not_end_the_gateway(tmp_path: Path, broker: Broker) -> None:
    (tmp_path / "run").write_text("the folder for its note is not there")
    gateway = RunningGateway(tmp_path, broker.url)
    port = free_port()
    gateway.begin(port)
    gateway.url = f"http://127.0.0.1:{port}"
    try:
        async with gateway.http() as http, asyncio.timeout(10):
            while True:
                assert psutil.Process(gateway.pid).status() != psutil.STATUS_ZOMBIE, "the gateway ended"
                with contextlib.suppress(httpx.TransportError):
                    assert (await http.get("/health")).status_code == 200
                    break
                await asyncio.sleep(0.02)  # a process has no event to wait for
    finally:
        gateway.kill()
