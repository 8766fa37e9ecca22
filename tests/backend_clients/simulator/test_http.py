"""The robot's HTTP endpoint, spoken to by the console's own client."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import httpx
import pytest

from backend_clients.edge import messages_down as down
from backend_clients.edge.codec import MAX_BYTES, mission_hash
from backend_clients.edge.http import RobotHttp
from backend_clients.edge.messages_up import Ack
from backend_clients.errors import Refused, TransportError
from backend_clients.simulator import tester_http
from backend_clients.simulator.config import RobotConfig
from backend_clients.simulator.director import Director
from backend_clients.simulator.http_server import RobotEndpoint, application
from backend_clients.simulator.world import World
from hmi.clock import FakeClock
from tests.backend_clients.simulator.rig import small_mission


class Site:
    """Two robots behind one address."""

    def __init__(self, client: tuple[str, int] = ("127.0.0.1", 5000)) -> None:
        self.clock = FakeClock()
        robots = [
            RobotConfig("weeder-01", "Weeder 01", "secret-1"),
            RobotConfig("weeder-02", "Weeder 02", "secret-2"),
        ]
        self.world = World(robots, self.clock)
        self.acks: list[Any] = []
        self.answered = asyncio.Event()
        self.endpoint = RobotEndpoint(self.world, self.on_ack)
        app = application(self.endpoint, tester_http.routes(self.world, Director(self.world.robots, self.world.clock)))
        self.transport = httpx.ASGITransport(app, client=client)

    def on_ack(self, robot: str, ack: Ack) -> None:
        self.acks.append((robot, ack.ref))
        self.answered.set()

    def robot(self, robot_id: str = "weeder-01", token: str = "secret-1") -> RobotHttp:
        return RobotHttp(robot_id, f"http://robots/{robot_id}", token, transport=self.transport)

    def raw(self, token: str = "secret-1") -> httpx.AsyncClient:
        headers = {"Authorization": f"Bearer {token}"} if token else {}
        return httpx.AsyncClient(transport=self.transport, base_url="http://robots", headers=headers)

    def live(self, seconds: float) -> None:
        for _ in range(round(seconds / 0.05)):
            self.clock.advance(0.05)
            self.world.step(0.05)


@pytest.fixture
async def site() -> AsyncIterator[Site]:
    site = Site()
    yield site
    site.endpoint.close()


def press(robot: str = "weeder-01", stop_id: str = "stop-000001") -> down.Stop:
    return down.Stop(robot=robot, stop_id=stop_id, by="Martha", device="Tablet 3")


async def test_stop_by_http_latches_only_the_robot_it_names(site: Site) -> None:
    ack = await site.robot().stop(press())
    assert (ack.outcome, ack.ref) == ("accepted", "stop-000001")
    assert (await site.robot().safety()).latched
    assert not (await site.robot("weeder-02", "secret-2").safety()).latched
    assert site.acks == [("weeder-01", "stop-000001")]


async def test_a_wrong_or_missing_token_is_refused_even_for_stop(site: Site) -> None:
    for token in ("secret-2", "", "x" * 5000, "s\u00e9cret"):
        with pytest.raises(TransportError) as caught:
            await site.robot(token=token).stop(press())
        if isinstance(caught.value, Refused):
            assert caught.value.code == "bad_token"
    assert not (await site.robot().safety()).latched


async def test_an_unknown_robot_is_told_so(site: Site) -> None:
    with pytest.raises(Refused, match="unknown_robot"):
        await site.robot("weeder-09").safety()


async def test_a_stop_for_another_robot_is_refused(site: Site) -> None:
    async with site.raw() as client:
        body = '{"robot":"weeder-02","stop_id":"stop-000001","by":"Anna"}'
        answer = await client.post("/weeder-01/stop", content=body)
    assert (answer.status_code, answer.json()["code"]) == (400, "bad_request")
    assert not (await site.robot().safety()).latched


@pytest.mark.parametrize(
    "body",
    [b"", b"not json", b"[1,2]", b'{"robot":"weeder-01"}', b'{"robot":"weeder-01","stop_id":"new-stop-1","x":1}'],
)
async def test_a_stop_that_cannot_be_read_stops_all_the_same(site: Site, body: bytes) -> None:
    async with site.raw() as client:
        first = (await client.post("/weeder-01/stop", content=body)).json()
        again = (await client.post("/weeder-01/stop", content=body)).json()
    assert (first["outcome"], first["code"]) == ("accepted", "ok")
    assert (again["ref"], again["code"]) == (first["ref"], "already_latched")
    assert (await site.robot().safety()).latched


async def test_reset_by_http_follows_the_same_rules(site: Site) -> None:
    await site.robot().stop(press())
    site.live(1)
    boot = site.world.robots["weeder-01"].boot
    assert boot is not None
    reset = down.StopReset(
        robot="weeder-01",
        reset_id="reset-0001",
        stop_ids=["stop-000001"],
        by="Martha",
        reason="Test",
        lease_token=1,
        lease_seq=1,
        challenge="no-such-challenge",
    )
    assert (await site.robot().reset(reset)).code == "stale_challenge"
    fresh = down.StopReset(
        robot="weeder-01",
        reset_id="reset-0002",
        stop_ids=["stop-000001"],
        by="Martha",
        reason="Test",
        lease_token=1,
        lease_seq=2,
        challenge=boot.reporter.heartbeat().challenge,
    )
    assert (await site.robot().reset(fresh)).outcome == "accepted"
    assert not (await site.robot().safety()).latched


async def test_a_mission_is_stored_and_read_back_by_its_hash(site: Site) -> None:
    mission = small_mission()
    ack = await site.robot().upload_mission(mission)
    assert (ack.outcome, ack.sha256) == ("accepted", mission_hash(mission))
    async with site.raw() as client:
        back = await client.get("/weeder-01/missions/mission-1")
        assert back.json()["mission_id"] == "mission-1"
        assert (await client.get("/weeder-01/missions/other")).json()["code"] == "no_mission"
        wrong = await client.put("/weeder-01/missions/other", content=back.content)
        assert wrong.json()["code"] == "wrong_mission"
        field = (await client.get("/weeder-01/map")).json()
    assert field["features"][0]["properties"]["name"] == "Test field"
    state = await site.robot().state()
    assert state.order is not None
    assert state.order.sha256 == mission_hash(mission)


async def test_what_the_robot_does_not_have_is_said_with_a_reason(site: Site) -> None:
    async with site.raw() as client:
        answer = await client.get("/weeder-01/map")
        assert (answer.status_code, answer.json()["code"]) == (404, "no_map")
        assert "<robot" in (await client.get("/weeder-01/model")).text
        assert [camera["id"] for camera in (await client.get("/weeder-01/cameras")).json()] == [
            "front",
            "rear",
            "side",
            "tool",
            "tof",
        ]
        assert (await client.get("/weeder-01/factsheet")).json()["family"] == "weeder"


async def test_logs_are_the_newest_lines(site: Site) -> None:
    await site.robot().stop(press())
    site.live(0.1)
    assert "STOP" in await site.robot().logs(20)
    assert len((await site.robot().logs(1)).splitlines()) == 1
    async with site.raw() as client:
        assert (await client.get("/weeder-01/logs?lines=-1")).status_code == 400
        of_node = (await client.get("/weeder-01/logs?lines=50&node=supervisor")).text
        assert "STOP" in of_node
        assert all("[supervisor]" in line for line in of_node.splitlines())
        assert (await client.get("/weeder-01/logs?node=crane")).json()["code"] == "unknown_node"


async def test_an_oversized_body_is_refused(site: Site) -> None:
    async with site.raw() as client:
        answer = await client.post("/weeder-01/stop", content=b" " * (MAX_BYTES + 1))
    assert (answer.status_code, answer.json()["code"]) == (413, "too_large")


async def test_a_silent_robot_hears_a_stop_but_does_not_answer(site: Site) -> None:
    async with site.raw() as client:
        await client.post("/_faults/weeder-01", content=b'{"fault":"silence","http":true}')
    attempt = asyncio.create_task(site.robot().stop(press()))
    await site.answered.wait()
    assert not attempt.done()
    async with site.raw() as client:
        assert (await client.get("/_world/weeder-01")).json()["latched"] is True
        await client.delete("/_faults/weeder-01?fault=silence")
    site.endpoint.close()
    with pytest.raises(Refused):
        await attempt


async def test_testers_switch_faults_and_see_the_truth(site: Site) -> None:
    async with site.raw(token="") as client:
        on = await client.post("/_faults/weeder-01", content=b'{"fault":"hardware-stop"}')
        assert list(on.json()["faults"]) == ["hardware-stop"]
        site.live(0.2)
        world = (await client.get("/_world/weeder-01")).json()
        assert (world["mode"], world["faults"], world["drive_age_s"]) == ("stopped", ["hardware-stop"], None)
        assert (await client.delete("/_faults/weeder-01")).json()["faults"] == {}
        assert (await client.post("/_faults/weeder-01", content=b'{"fault":"fire"}')).status_code == 400
        assert (await client.get("/_faults/weeder-09")).status_code == 404
        moved = await client.post("/_world/weeder-01", content=b'{"x_m": 5.0, "soc": 0.5}')
        assert (moved.json()["x_m"], moved.json()["soc"]) == (5.0, 0.5)
        assert (await client.post("/_world", content=b'{"speed": 10}')).json()["speed"] == 10


async def test_testers_play_a_situation_and_end_it(site: Site) -> None:
    async with site.raw(token="") as client:
        told = (await client.get("/_situations")).json()
        assert told["now"] == {}
        assert {"id", "title", "text", "families"} == set(told["situations"][0])
        path = "/_situations/weeder-01"
        assert (await client.post(path, content=b'{"situation": "rtk-float"}')).json()["now"] == {
            "weeder-01": "rtk-float"
        }
        assert site.world.robots["weeder-01"].machine.is_rtk_float
        assert (await client.post(path, content=b'{"situation": null}')).json()["now"] == {}
        assert not site.world.robots["weeder-01"].machine.is_rtk_float
        assert (await client.post(path, content=b'{"situation": "crane-limit"}')).status_code == 409
        assert (await client.post(path, content=b'{"situation": "fire"}')).status_code == 404
        assert (await client.post("/_situations/weeder-99", content=b'{"situation": null}')).status_code == 404


async def test_testers_doors_are_closed_to_other_machines() -> None:
    site = Site(client=("192.168.1.20", 5000))
    async with site.raw() as client:
        for path in ("/_faults/weeder-01", "/_world/weeder-01", "/_world", "/_situations"):
            answer = await client.get(path)
            assert (answer.status_code, answer.json()["code"]) == (403, "loopback_only")
    assert (await site.robot().safety()).robot == "weeder-01"


async def test_mission_and_latch_are_on_disk_before_the_answer(tmp_path: Path) -> None:
    clock = FakeClock()
    config = RobotConfig("weeder-01", "Weeder 01", "secret-1")
    for attempt in range(2):
        world = World([config], clock, state_dir=tmp_path)
        endpoint = RobotEndpoint(world, lambda robot, ack: None)
        transport = httpx.ASGITransport(application(endpoint, []))
        robot = RobotHttp("weeder-01", "http://robots/weeder-01", "secret-1", transport=transport)
        if attempt == 0:
            await robot.upload_mission(small_mission())
            await robot.stop(press())
        else:
            state, safety = await robot.state(), await robot.safety()
            assert safety.latched
            assert state.order is not None
            assert state.order.mission_id == "mission-1"
        await robot.close()
