"""The farm in the cloud: newest state first, nothing that must be kept is lost, and every fault has a name."""

from __future__ import annotations

import asyncio
import json
import ssl
from collections.abc import Awaitable, Callable
from dataclasses import replace
from datetime import timedelta
from pathlib import Path

import httpx
import pytest

from backend_clients.simulator.context_broker.faults import Faults
from hmi.cloud.outbox import Rank
from hmi.domain.event import RobotEvent
from hmi.domain.mission import MissionStatus
from hmi.fiware.farm_map import map_entities
from hmi.fiware.urn import moment
from hmi.mapping.feature import MapFeature
from hmi.presenters.cloud import WORDS
from hmi.service_link import ANSWERS, LinkState
from hmi.store.missions import Mission
from tests.hmi.cloud.rig import Rig
from tests.hmi.fiware.robots import a_robot

Story = Callable[[Rig], Awaitable[None]]
Breaks = Callable[[httpx.Request], Exception | httpx.Response]


def played(folder: Path, story: Story, **how: object) -> None:
    """Run a story with a rig of its own."""

    async def run() -> None:
        rig = Rig(folder, **how)  # type: ignore[arg-type]
        await story(rig)
        await rig.close()

    asyncio.run(run())


def robot_at(rig: Rig, robot_id: str, lat_deg: float, *, held_s: float = 0.0) -> None:
    """Let a robot tell a place that was true ``held_s`` ago."""
    now_s = rig.clock.mono_s()
    robot = a_robot(robot_id, at_s=now_s - held_s)
    assert robot.telemetry is not None
    stamp = replace(robot.telemetry.pose.stamp, received_s=now_s)
    pose = replace(robot.telemetry.pose, lat_deg=lat_deg, stamp=stamp)
    rig.fleet.put(replace(robot, telemetry=replace(robot.telemetry, pose=pose)))


def event(rig: Rig, number: int, robot_id: str = "weeder-01") -> None:
    """Let something happen on a robot."""
    what = RobotEvent(robot_id, f"b-{number}", "treatment", "weed", f"No. {number}", {"n": number},
                      at_utc=rig.clock.utc())  # fmt: skip
    rig.news.see_event(what)


def mission(rig: Rig, status: MissionStatus) -> Mission:
    """Return a mission in this status now."""
    now = rig.clock.utc()
    return Mission("m1", "hof", "North", "North", status, "ab" * 32, "Martha", now - timedelta(hours=1), now,
                   robot_id="weeder-01", field_id="n", statistics={"time_s": 1800.0})  # fmt: skip


def test_robots_missions_and_the_map_are_in_the_cloud_within_a_round(tmp_path: Path) -> None:
    async def story(rig: Rig) -> None:
        square = {"type": "Polygon", "coordinates": [[[10.0, 50.0], [10.001, 50.0], [10.001, 50.001], [10.0, 50.0]]]}
        rig.whole = map_entities([MapFeature("n", "parcel", "North", square, {"crop": "Maize"})], "hof", "Hof")[0]
        robot_at(rig, "weeder-01", 50.0)
        rig.news.see_mission(mission(rig, MissionStatus.RUNNING))
        event(rig, 1)
        await rig.run(0.5)
        assert rig.link.link.state is LinkState.OK
        assert set(await rig.in_cloud("AgriParcel")) == {"urn:ngsi-ld:AgriParcel:hof:n"}
        found = await rig.in_cloud("StateMessage")
        assert found["urn:ngsi-ld:StateMessage:hof:weeder-01"]["location"]["coordinates"][1] == 50.0
        operations = await rig.in_cloud("AgriParcelOperation")
        assert operations["urn:ngsi-ld:AgriParcelOperation:hof:m1"]["status"] == "ongoing"
        assert [one["textValue"] for one in (await rig.in_cloud("DeviceMeasurement")).values()] == ["No. 1"]
        assert rig.backlog.total == 0

    played(tmp_path, story)


@pytest.mark.slow
def test_three_hours_without_the_cloud_lose_no_event_and_no_result_and_the_newest_state_comes_first(
    tmp_path: Path,
) -> None:
    async def story(rig: Rig) -> None:
        await rig.run(1)
        rig.road.broken = lambda request: httpx.ConnectError("no route", request=request)
        for minute in range(180):
            for second in range(0, 60, 20):
                event(rig, 3 * minute + second // 20, f"weeder-{minute % 3:02d}")
            robot_at(rig, "weeder-01", 50.0 + minute * 1e-4)
            if minute == 100:
                rig.news.see_mission(mission(rig, MissionStatus.RUNNING))
            if minute == 170:
                rig.news.see_mission(mission(rig, MissionStatus.DONE))
            await rig.run(60, step_s=20)
        assert rig.link.link.state is LinkState.UNREACHABLE
        assert rig.backlog.waiting.count == 542
        oldest_s = rig.backlog.waiting.oldest_s
        assert oldest_s is not None
        assert rig.clock.utc().timestamp() - oldest_s > 3 * 3600 - 100
        asked = len(rig.road.requests)
        assert asked < 800, "a lost broker is asked with pauses"

        rig.road.broken, rig.road.requests[:] = None, []
        await rig.run(40)
        bodies = [json.loads(one.content) for one in rig.road.requests if one.url.path == "/v2/op/update"]
        assert [one["type"] for one in bodies[0]["entities"]] == ["StateMessage"]
        assert bodies[0]["entities"][0]["location"]["value"]["coordinates"][1] == pytest.approx(50.0179)
        assert sum(len(body["entities"]) for body in bodies if body["entities"][0]["type"] == "StateMessage") == 1
        events = await rig.in_cloud("DeviceMeasurement")
        assert len(events) == 540
        operations = await rig.in_cloud("AgriParcelOperation")
        assert operations["urn:ngsi-ld:AgriParcelOperation:hof:m1"]["result"] == "ok"
        assert (rig.backlog.total, rig.backlog.waiting.lost, rig.mirror.counts.refused) == (0, 0, 0)
        sent = [one["textValue"]["value"] for body in bodies for one in body["entities"]
                if one["type"] == "DeviceMeasurement" and "weeder-00" in one["id"]]  # fmt: skip
        assert sent == sorted(sent, key=lambda text: int(text.split()[1])), "order per robot"

    played(tmp_path, story)


def test_what_waits_outlives_the_console(tmp_path: Path) -> None:
    async def run() -> None:
        first = Rig(tmp_path)
        await first.run(1)
        first.road.broken = lambda request: httpx.ConnectError("no route", request=request)
        event(first, 1)
        await first.run(1)
        event(first, 2)  # not on disk yet when the console is asked to end
        await first.close()
        second = Rig(tmp_path, clock=first.clock, broker=first.broker)
        await second.run(2)
        assert len(await second.in_cloud("DeviceMeasurement")) == 2
        await second.close()

    asyncio.run(run())


def test_a_mission_that_changed_twice_meanwhile_ends_as_it_is_now(tmp_path: Path) -> None:
    async def story(rig: Rig) -> None:
        for status in (MissionStatus.RUNNING, MissionStatus.PAUSED, MissionStatus.RUNNING, MissionStatus.FAILED):
            rig.clock.advance(1)
            rig.news.see_mission(mission(rig, status))
            rig.news.see_mission(mission(rig, status))  # progress only: not told again
        assert rig.backlog.total == 4
        await rig.run(2)
        found = await rig.in_cloud("AgriParcelOperation")
        assert found["urn:ngsi-ld:AgriParcelOperation:hof:m1"]["result"] == "failed"

    played(tmp_path, story)


def test_events_arrive_whatever_characters_a_robot_has_in_their_ids(tmp_path: Path) -> None:
    names = [
        "8f2c-0001",
        "boot 7 (row=3)",
        "boot 7 (row=4)",
        "~20 boot",
        "<&?/#\"'>;",
        "Z\u00fcge \u2603 " * 6,
        "\u2603" * 64,
    ]

    async def story(rig: Rig) -> None:
        for name in names:
            rig.news.see_event(RobotEvent("weeder-01", name, "mode", "auto", name, {}, at_utc=rig.clock.utc(),
                                          mission_id="m1"))  # fmt: skip
        await rig.run(2)
        found = await rig.in_cloud("DeviceMeasurement")
        assert sorted(one["textValue"] for one in found.values()) == sorted(names)
        assert "urn:ngsi-ld:DeviceMeasurement:hof:weeder-01:8f2c-0001" in found
        assert {one["headland"]["mission"] for one in found.values()} == {"m1"}
        assert rig.mirror.counts.refused == 0

    played(tmp_path, story)


OPERATION = "urn:ngsi-ld:AgriParcelOperation:hof:m1"


def test_a_mission_that_runs_again_has_no_result_of_its_last_life_and_says_since_when(tmp_path: Path) -> None:
    async def story(rig: Rig) -> None:
        for status in (MissionStatus.SENT, MissionStatus.RUNNING, MissionStatus.DONE):
            rig.news.see_mission(mission(rig, status))
            await rig.run(2)
        found = (await rig.in_cloud("AgriParcelOperation"))[OPERATION]
        assert (found["result"], found["startedAt"] < found["endedAt"]) == ("ok", True)
        again = mission(rig, MissionStatus.RUNNING)
        rig.news.see_mission(again)
        await rig.run(2)
        found = (await rig.in_cloud("AgriParcelOperation"))[OPERATION]
        assert found["status"] == "ongoing"
        assert not {"result", "endedAt"} & found.keys()
        assert found["startedAt"] == moment(again.updated_at)

    played(tmp_path, story)


def test_what_goes_from_a_mission_is_not_lost_where_the_cloud_fails_between(tmp_path: Path) -> None:
    async def story(rig: Rig) -> None:
        rig.news.see_mission(mission(rig, MissionStatus.DONE))
        await rig.run(2)
        rig.news.see_mission(mission(rig, MissionStatus.RUNNING))
        rig.switch.set(Faults(status=503, methods=("POST",)))
        await rig.run(2)
        assert rig.backlog.total == 1
        rig.switch.set(Faults())
        await rig.run(40)
        found = (await rig.in_cloud("AgriParcelOperation"))[OPERATION]
        assert (found["status"], "result" in found) == ("ongoing", False)

    played(tmp_path, story)


def test_a_mission_that_was_deleted_is_cancelled_in_the_cloud(tmp_path: Path) -> None:
    async def story(rig: Rig) -> None:
        rig.news.see_mission(mission(rig, MissionStatus.DRAFT))
        await rig.run(1)
        rig.news.see_deleted(mission(rig, MissionStatus.DRAFT))
        await rig.run(1)
        found = (await rig.in_cloud("AgriParcelOperation"))[OPERATION]
        assert (found["status"], found["headland"]["status"]) == ("cancelled", "deleted")

    played(tmp_path, story)


def untrusted(request: httpx.Request) -> Exception:
    """Return what httpx raises for a certificate that is not to be trusted."""
    error = httpx.ConnectError("certificate verify failed", request=request)
    error.__cause__ = ssl.SSLCertVerificationError("certificate has expired")
    return error


def timed_out(request: httpx.Request) -> Exception:
    """Return what httpx raises when an answer does not come."""
    return httpx.ReadTimeout("", request=request)


@pytest.mark.parametrize(
    ("fault", "broken", "state"),
    [
        (Faults(status=503), None, LinkState.FAILING),
        (Faults(status=500, takes_effect=True), None, LinkState.FAILING),
        (Faults(status=429), None, LinkState.BUSY),
        (Faults(token="other"), None, LinkState.REFUSED),
        (None, lambda _request: httpx.Response(200, html="<p>Log in</p>"), LinkState.NOT_UNDERSTOOD),
        (None, lambda request: httpx.RemoteProtocolError("cut", request=request), LinkState.UNREACHABLE),
        (None, untrusted, LinkState.UNTRUSTED),
        (None, timed_out, LinkState.SILENT),
        (None, lambda request: httpx.ConnectError("refused", request=request), LinkState.UNREACHABLE),
    ],
)
def test_every_fault_has_a_state_keeps_what_waits_and_ends_by_itself(
    tmp_path: Path, fault: Faults | None, broken: Breaks | None, state: LinkState
) -> None:
    async def story(rig: Rig) -> None:
        await rig.run(1)
        if fault is not None:
            rig.switch.set(fault)
        rig.road.broken = broken
        event(rig, 1)
        robot_at(rig, "weeder-01", 50.0)
        await rig.run(120)
        assert rig.link.link.state is state
        assert rig.link.link.mend
        assert WORDS[state.value].head
        assert rig.backlog.total == 1
        rig.switch.set(Faults())
        rig.road.broken = None
        await rig.run(40)
        assert rig.link.link.state is LinkState.OK
        assert len(await rig.in_cloud("DeviceMeasurement")) == 1
        assert len(await rig.in_cloud("StateMessage")) == 1

    played(tmp_path, story)


def test_every_state_of_the_link_has_words() -> None:
    assert set(WORDS) == {state.value for state in LinkState}
    assert all(WORDS[state.value].level != "bad" for state in ANSWERS)


def test_an_answer_that_was_lost_is_counted_as_perhaps_twice_and_is_once_in_the_cloud(tmp_path: Path) -> None:
    async def story(rig: Rig) -> None:
        await rig.run(1)
        rig.switch.set(Faults(status=504, takes_effect=True, methods=("POST",)))
        event(rig, 1)
        await rig.run(1)
        assert len(await rig.in_cloud("DeviceMeasurement")) == 1
        assert rig.backlog.total == 1
        rig.switch.set(Faults())
        await rig.run(20)
        assert rig.mirror.counts.resent == 1
        assert len(await rig.in_cloud("DeviceMeasurement")) == 1
        assert rig.backlog.total == 0

    played(tmp_path, story)


def test_an_entity_the_broker_never_takes_does_not_hold_up_the_others(tmp_path: Path) -> None:
    async def story(rig: Rig) -> None:
        await rig.run(1)
        rig.switch.set(Faults(max_body=2000))
        for number in range(6):
            event(rig, number)
        large = RobotEvent("weeder-01", "b-large", "treatment", "weed", "large", {"x": "y" * 3000},
                           at_utc=rig.clock.utc())  # fmt: skip
        rig.news.see_event(large)
        event(rig, 7)
        await rig.run(3)
        assert len(await rig.in_cloud("DeviceMeasurement")) == 7
        assert (rig.backlog.total, rig.mirror.counts.refused) == (0, 1)
        assert "413" in rig.mirror.counts.last_refusal
        assert rig.link.link.state is LinkState.OK
        (kept,) = rig.refused.all()
        assert (kept.piece.stream, kept.why[:3]) == ("weeder-01", "413")

    played(tmp_path, story)


@pytest.mark.parametrize(
    ("answer", "state"),
    [
        (httpx.Response(404, text="default backend - 404"), LinkState.NOT_UNDERSTOOD),
        (httpx.Response(400, html="<p>Bad request</p>"), LinkState.NOT_UNDERSTOOD),
        (httpx.Response(408, text=""), LinkState.SILENT),
        (httpx.Response(425, json={"error": "Early", "description": "later"}), LinkState.SILENT),
        (httpx.Response(404, json={"error": "NotFound", "description": "no such route"}), LinkState.NOT_UNDERSTOOD),
    ],
)
def test_what_a_proxy_says_of_all_requests_drops_nothing_that_waits(
    tmp_path: Path, answer: httpx.Response, state: LinkState
) -> None:
    def break_updates(request: httpx.Request) -> httpx.Response:
        return answer if request.url.path == "/v2/op/update" else httpx.Response(200, json={"orion": {}})

    async def story(rig: Rig) -> None:
        await rig.run(1)
        for number in range(300):
            event(rig, number)
        rig.road.broken = break_updates
        rig.road.requests.clear()
        await rig.run(0.5)
        assert rig.link.link.state is state
        assert (rig.backlog.total, rig.mirror.counts.refused, rig.mirror.counts.pieces) == (300, 0, 0)
        rig.road.broken = None
        await rig.run(60)
        assert len(await rig.in_cloud("DeviceMeasurement")) == 300

    played(tmp_path, story)


def test_nothing_goes_to_another_tenant_until_a_person_takes_it(tmp_path: Path) -> None:
    async def story(rig: Rig) -> None:
        robot_at(rig, "weeder-01", 50.0)
        await rig.run(1)
        rig.switch.set(Faults(wrong_tenant="other"))
        await rig.run(62)  # it is looked at each minute
        event(rig, 1)
        robot_at(rig, "weeder-01", 50.1)
        await rig.run(60)
        assert rig.link.link.state is LinkState.OTHER_TENANT
        assert rig.backlog.total == 1
        await rig.link.take_tenant()
        await rig.run(1)
        assert rig.link.link.state is LinkState.OK
        assert rig.backlog.total == 0

    played(tmp_path, story)


def test_two_consoles_do_not_write_over_each_other(tmp_path: Path) -> None:
    async def run() -> None:
        first = Rig(tmp_path / "a")
        await first.run(1)
        second = Rig(tmp_path / "b", clock=first.clock, broker=first.broker)
        robot_at(second, "weeder-01", 50.0)
        await second.run(10)
        assert second.link.link.state is LinkState.OTHER_CONSOLE
        assert await second.in_cloud("StateMessage") == {}
        await first.close()
        await second.close()

    asyncio.run(run())


def test_a_broker_that_forgot_everything_is_told_everything_again(tmp_path: Path) -> None:
    async def run() -> None:
        rig = Rig(tmp_path, is_strict=False)
        rig.whole = map_entities([], "hof", "Hof")[0]
        robot_at(rig, "weeder-01", 50.0)
        await rig.run(1)
        rig.road.broken = lambda request: httpx.ConnectError("refused", request=request)
        await rig.run(10)
        fresh = Rig(tmp_path / "fresh", clock=rig.clock)
        rig.road._inner = fresh.road._inner  # the broker was started anew
        rig.road.broken = None
        await rig.run(100)
        assert len(await fresh.in_cloud("StateMessage")) == 1
        assert len(await fresh.in_cloud("AgriFarm")) == 1
        await rig.close()
        await fresh.close()

    asyncio.run(run())


def test_a_robot_that_stands_is_told_now_and_then_and_one_that_moves_each_round(tmp_path: Path) -> None:
    async def story(rig: Rig) -> None:
        robot_at(rig, "stands", 50.0)
        robot_at(rig, "moves", 50.0)
        await rig.run(1)
        before = rig.mirror.counts.states
        for step in range(1, 41):
            robot_at(rig, "stands", 50.0)
            robot_at(rig, "moves", 50.0 + step * 1e-5)
            await rig.run(0.5)
        assert 40 + 2 <= rig.mirror.counts.states - before <= 40 + 4

    played(tmp_path, story)


def test_delays_count_from_when_it_was_true_on_the_robot(tmp_path: Path) -> None:
    async def story(rig: Rig) -> None:
        await rig.run(1)
        rig.road.delay_s = 0.1
        for step in range(20):
            robot_at(rig, "weeder-01", 50.0 + step * 1e-4, held_s=0.05)
            await rig.run(0.25, step_s=0.25)
        to_console, to_cloud = rig.mirror.to_console.told(), rig.mirror.to_cloud.told()
        assert to_console.p50_s == pytest.approx(0.05)
        assert to_cloud.p50_s == pytest.approx(0.05 + 0.25 + 0.1)
        assert to_cloud.count == 20

    played(tmp_path, story)


def test_a_slow_cloud_is_said_to_be_slow_and_its_clock_is_compared(tmp_path: Path) -> None:
    async def story(rig: Rig) -> None:
        rig.road.delay_s = 3.0
        robot_at(rig, "weeder-01", 50.0)
        await rig.run(1)
        assert rig.link.link.state is LinkState.SLOW

    played(tmp_path, story)


def test_ranks_drop_events_first() -> None:
    assert min(Rank) is Rank.EVENT
    assert max(Rank) is Rank.MISSION
