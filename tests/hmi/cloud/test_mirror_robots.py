"""What the cloud says of robots that are gone or silent, and how robots are told over a slow way."""

from __future__ import annotations

import asyncio
import json
from dataclasses import replace
from pathlib import Path

import httpx
import pytest

from hmi.cloud.states import LEFT_AFTER_S
from hmi.service_link import LinkState
from tests.hmi.cloud.rig import Rig
from tests.hmi.cloud.test_mirror import event, played, robot_at
from tests.hmi.fiware.robots import a_robot


def test_a_robot_that_was_taken_out_of_the_farm_is_not_online_in_the_cloud_for_ever(tmp_path: Path) -> None:
    async def story(rig: Rig) -> None:
        robot_at(rig, "weeder-01", 50.0)
        robot_at(rig, "weeder-02", 50.0)
        await rig.run(1)
        rig.fleet.remove("weeder-01")
        await rig.run(1)
        found = {key.rpartition(":")[2]: one["headland"] for key, one in (await rig.in_cloud("StateMessage")).items()}
        assert (found["weeder-01"]["online"], found["weeder-01"]["removed"]) == (False, True)
        assert "removed" not in found["weeder-02"]
        robot_at(rig, "weeder-01", 50.1)
        await rig.run(1)
        found = {key.rpartition(":")[2]: one["headland"] for key, one in (await rig.in_cloud("StateMessage")).items()}
        assert "removed" not in found["weeder-01"]

    played(tmp_path, story)


def test_a_battery_a_robot_tells_no_more_does_not_stay_in_the_cloud(tmp_path: Path) -> None:
    async def story(rig: Rig) -> None:
        robot_at(rig, "weeder-01", 50.0)
        await rig.run(1)
        [found] = (await rig.in_cloud("StateMessage")).values()
        assert found["battery"] == {"remainingPercentage": 80.0}
        robot = rig.fleet.known["weeder-01"]
        assert robot.telemetry is not None
        rig.fleet.put(replace(robot, telemetry=replace(robot.telemetry, battery=None)))
        await rig.run(1)
        [found] = (await rig.in_cloud("StateMessage")).values()
        assert ("battery" in found, "location" in found) == (False, True)

    played(tmp_path, story)


@pytest.mark.parametrize("is_registered", [True, False])
def test_a_robot_that_was_on_when_the_console_ended_and_is_not_heard_again_is_not_online_in_the_cloud(
    tmp_path: Path, is_registered: bool
) -> None:
    async def run() -> None:
        first = Rig(tmp_path)
        for robot_id in ("weeder-01", "weeder-02"):
            robot_at(first, robot_id, 50.0)
        await first.run(1)
        before = await first.in_cloud("StateMessage")
        await first.close()
        again = Rig(tmp_path, clock=first.clock, broker=first.broker)
        silent = a_robot("weeder-01", is_online=False)
        if is_registered:
            again.fleet.put(replace(silent, telemetry=None, state=None, safety=None))
        robot_at(again, "weeder-02", 50.0)
        await again.run(LEFT_AFTER_S + 1)
        found = await again.in_cloud("StateMessage")
        key, other = (f"urn:ngsi-ld:StateMessage:hof:weeder-0{n}" for n in (1, 2))
        own = {**before[key]["headland"], "online": False, **({} if is_registered else {"removed": True})}
        assert found[key] == {**before[key], "headland": own}, "the rest stays with its time"
        assert found[other]["headland"]["online"]
        told = again.mirror.counts.states
        await again.run(5)
        assert again.mirror.counts.states == told
        if is_registered:
            again.fleet.remove("weeder-01")
            await again.run(1)
            assert (await again.in_cloud("StateMessage"))[key]["headland"]["removed"]
        robot_at(again, "weeder-01", 50.1)
        await again.run(1)
        own = (await again.in_cloud("StateMessage"))[key]["headland"]
        assert (own["online"], "removed" in own) == (True, False)
        await again.close()

    asyncio.run(run())


def test_a_long_answer_that_never_gets_through_stops_neither_robots_nor_what_waits(tmp_path: Path) -> None:
    async def story(rig: Rig) -> None:
        inner = rig.road._inner

        class Slow(httpx.AsyncBaseTransport):
            async def handle_async_request(self, request: httpx.Request) -> httpx.Response:
                if request.method == "GET" and "StateMessage" in str(request.url):
                    raise httpx.ReadTimeout("slow", request=request)
                return await inner.handle_async_request(request)

        rig.road._inner = Slow()
        asked = 0
        for number in range(int(LEFT_AFTER_S) + 20):
            robot_at(rig, "weeder-01", 50.0 + number * 1e-3)
            event(rig, number)
            rig.road.requests.clear()
            await rig.run(1, 1)
            asked += sum("StateMessage" in str(one.url) for one in rig.road.requests)
        assert asked == 1, "and is asked for again much later"
        assert (rig.link.link.state, rig.backlog.total) == (LinkState.OK, 0)
        [found] = (await rig.in_cloud("StateMessage")).values()
        assert found["location"]["coordinates"][1] == pytest.approx(50.0 + number * 1e-3)

    played(tmp_path, story)


def crops(count: int) -> list[dict[str, str]]:
    """Return a large map."""
    return [{"id": f"urn:ngsi-ld:AgriCrop:hof:c{n}", "type": "AgriCrop", "name": f"c{n}"} for n in range(count)]


def test_lost_answers_to_one_robot_make_requests_no_smaller_than_they_need_be_and_they_grow_again(
    tmp_path: Path,
) -> None:
    async def story(rig: Rig) -> None:
        robot_at(rig, "weeder-01", 50.0)
        await rig.run(2)
        rig.road.broken = lambda request: httpx.ReadTimeout("dropped", request=request)
        for number in range(5):
            robot_at(rig, "weeder-01", 50.1 + number * 0.01)
            await rig.run(20)
            rig.road.broken = None
            await rig.run(20)
            rig.road.broken = lambda request: httpx.ReadTimeout("dropped", request=request)
        rig.road.broken = None
        assert rig.link.most >= 10
        for number in range(120):
            robot_at(rig, "weeder-01", 51.0 + number * 0.01)
            await rig.run(10, 10)
        assert rig.link.most == 200

    played(tmp_path, story)


def test_robots_are_told_between_the_parts_of_a_large_map(tmp_path: Path) -> None:
    async def story(rig: Rig) -> None:
        robot_at(rig, "weeder-01", 50.0)
        await rig.run(2)
        rig.link.most, rig.whole = 10, crops(60)
        rig.mirror.tell_whole()
        inner, kinds = rig.road._inner, list[str]()

        class Going(httpx.AsyncBaseTransport):
            async def handle_async_request(self, request: httpx.Request) -> httpx.Response:
                if request.url.path == "/v2/op/update":
                    body = json.loads(request.content)
                    if body["actionType"] == "append":
                        kinds.append(body["entities"][0]["type"])
                    robot_at(rig, "weeder-01", 50.0 + len(kinds) * 0.01)
                return await inner.handle_async_request(request)

        rig.road._inner = Going()
        await rig.run(0.5)
        told = [kind for kind in kinds if kind in ("AgriCrop", "StateMessage")]
        first = told.index("AgriCrop")
        assert told[first : first + 4] == ["AgriCrop", "StateMessage", "AgriCrop", "StateMessage"]
        assert len(await rig.in_cloud("AgriCrop")) == 60

    played(tmp_path, story)
