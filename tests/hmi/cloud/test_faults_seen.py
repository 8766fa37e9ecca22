"""What a person sees of each fault of the cloud, and which alarm is raised where it matters."""

from __future__ import annotations

import asyncio
import json
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from backend_clients.http.retry import RetryPolicy
from backend_clients.ngsi import entity as make
from backend_clients.ngsi.client import NgsiClient
from backend_clients.ngsi.connection import Broker, Call
from backend_clients.ngsi.entity import Entity
from backend_clients.ngsi.identifier import EntityRef
from backend_clients.ngsi.tenant import Tenant
from backend_clients.simulator.context_broker.faults import Faults
from hmi.app.arrival_report import FromRobots
from hmi.app.cloud_report import BEHIND_S, CloudReport
from hmi.app.service_report import broker_findings
from hmi.clock import SystemClock
from hmi.cloud.delays import Delays
from hmi.cloud.link import CloudLink
from hmi.cloud.map_changes import STORM_S
from hmi.cloud.map_subscription import WATCH_S
from hmi.cloud.marker import Marker
from hmi.cloud.outbox import Piece, Rank
from hmi.service_link import LinkState
from hmi.settings import Settings
from tests.hmi.cloud.rig import Rig
from tests.hmi.cloud.test_proposals import NORTH, REF, Farm

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

CONSOLE = EntityRef("urn:ngsi-ld:Headland:hof:console", "Headland")


def report_of(rig: Rig) -> CloudReport:
    """Return what a console with this rig says."""
    settings = Settings(demo=True, data=rig.folder, cloud_url="http://broker.test", cloud_tenant="farm")  # type: ignore[call-arg]
    book = rig.mirror.changes.book if rig.mirror.changes is not None else None
    assert book is not None
    return CloudReport(settings, rig.clock, rig.mirror, rig.backlog, book, Delays(), FromRobots(dict))


def codes(report: CloudReport) -> list[str]:
    """Return the alarms that hold."""
    return [one.code for one in report.findings()]


def record(rig: Rig, name: str) -> None:
    """Let something happen that must be kept."""
    body = {"id": f"urn:ngsi-ld:Alert:hof:{name}", "type": "Alert", "description": name}
    rig.backlog.put(Piece("weeder-01", Rank.ALARM, rig.clock.utc().timestamp(), json.dumps(body)))


async def test_a_slow_broker_is_said_to_be_slow_and_is_an_alarm_once_it_does_not_keep_up(tmp_path: Path) -> None:
    farm = Farm(tmp_path, NORTH)
    rig, report = farm.rig, report_of(farm.rig)
    await rig.run(1)
    rig.road.delay_s = 3.0
    record(rig, "a")
    await rig.run(3)
    shown = report.whole()
    assert (shown["state"], shown["level"], shown["why"]) == ("slow", "watch", "The last answer took 3.0 s.")
    assert codes(report) == [], "it keeps up"
    record(rig, "b")
    rig.clock.advance(BEHIND_S)
    (found,) = report.findings()
    assert (found.code, found.text) == (
        "cloud-behind",
        "1 record waits. The oldest is 5 min old. The last answer took 3.0 s.",
    )
    rig.road.delay_s = 0.0
    await rig.run(3)
    assert (codes(report), report.whole()["state"]) == ([], "ok")
    await rig.close()


async def test_what_waits_in_memory_is_counted_with_its_age_and_size(tmp_path: Path) -> None:
    farm = Farm(tmp_path, NORTH)
    report = report_of(farm.rig)
    await farm.rig.run(1)
    record(farm.rig, "a")
    farm.rig.clock.advance(2.0)
    waiting = report.whole()["waiting"]
    assert (waiting["count"], waiting["oldest_age_s"]) == (1, 2.0)
    assert waiting["bytes"] > 0
    await farm.rig.close()


async def test_another_tenant_is_seen_within_seconds_and_nothing_of_it_is_believed_or_told_for_long(
    tmp_path: Path,
) -> None:
    farm = Farm(tmp_path, NORTH)
    report = report_of(farm.rig)
    ours, kept = farm.subscribe()
    await farm.rig.run(2)
    farm.rig.switch.set(Faults(wrong_tenant="other"))
    kept.ensure_soon()
    assert farm.rig.mirror.changes is not None
    farm.rig.mirror.changes.read_soon()  # as every five minutes: in that moment everything of ours is missing
    await farm.rig.run(1)
    assert farm.book.all() == [], "what another tenant has not is nobody's wish"
    assert report.whole()["state"] == "other_tenant"
    assert (codes(report), report.health()["cloud"]["state"]) == (["cloud-refused"], "degraded")
    assert [one async for one in ours.all()] == [], "and nobody subscribed there"
    farm.rig.switch.set(Faults())
    await farm.rig.run(40)
    assert (report.whole()["state"], codes(report), farm.book.all()) == ("ok", [], [])
    await farm.rig.close()


async def test_another_tenant_is_noticed_although_nothing_of_the_map_is_read(tmp_path: Path) -> None:
    farm = Farm(tmp_path, NORTH)
    await farm.rig.run(1)
    farm.rig.switch.set(Faults(wrong_tenant="other"))
    await farm.rig.run(16)
    assert farm.rig.link.link.state is LinkState.OTHER_TENANT
    await farm.rig.close()


async def test_a_change_that_another_tenant_has_under_the_same_name_is_not_proposed(tmp_path: Path) -> None:
    farm = Farm(tmp_path, NORTH)
    await farm.rig.run(1)
    farm.rig.switch.set(Faults(wrong_tenant="other"))
    await farm.others.upsert(Entity(ref=REF, attributes={"name": make.text("Somebody else's field")}))
    assert farm.notified({"id": REF.id, "type": REF.type})
    await farm.rig.run(1)
    assert farm.book.all() == []
    await farm.rig.close()


async def test_a_subscription_deleted_on_a_broker_that_lives_is_missed_within_half_a_minute(tmp_path: Path) -> None:
    farm = Farm(tmp_path, NORTH)
    report = report_of(farm.rig)
    ours, _ = farm.subscribe()
    await farm.rig.run(2)
    assert report.whole()["map"]["subscribed"]
    await ours.clean_up(keep=())
    await farm.others.patch(REF, {"name": make.text("While nobody told")})
    farm.rig.road.requests.clear()
    await farm.rig.run(WATCH_S + 1)
    shown = report.whole()["map"]
    assert (shown["subscribed"], shown["subscription_lost"], shown["proposals"]) == (True, 1, 1)
    assert shown["subscription_lost_utc"]
    assert len([one async for one in ours.mine()]) == 1
    assert codes(report) == [], "it is mended, and nothing was missed"
    farm.rig.road.requests.clear()
    await farm.rig.run(4 * WATCH_S, step_s=5)
    asked = [one.url.path for one in farm.rig.road.requests if "subscriptions" in one.url.path]
    assert len(asked) == 4, "one small question each time, never the whole list"
    assert all(len(path.split("/")) == 4 for path in asked)
    await farm.rig.close()


async def test_a_broker_that_does_not_get_through_to_this_console_is_shown_and_is_no_lost_subscription(
    tmp_path: Path,
) -> None:
    farm = Farm(tmp_path, NORTH)
    report = report_of(farm.rig)
    ours, _ = farm.subscribe()
    await farm.rig.run(2)
    await farm.rig.broker.notifier.settle()  # its own word of the map that was just told
    (kept,) = [one async for one in ours.mine()]
    at_broker = farm.rig.broker.store.tenant("farm").subscriptions[kept.id]
    for status, reason, said in (
        ("active", "ConnectError: refused", "ConnectError: refused"),
        ("failed", f"no route to {at_broker.rule.target.url}", "its answer names this console's address"),
    ):
        at_broker.status, at_broker.fails_in_a_row = status, 1
        at_broker.last_failure, at_broker.last_failure_reason = farm.rig.clock.utc(), reason
        await farm.rig.run(12 * WATCH_S, step_s=10)  # over a renewal
        shown = report.whole()["map"]
        assert (shown["untold"], shown["subscription_lost"]) == (said, 0)
    at_broker.status, at_broker.fails_in_a_row = "active", 0
    await farm.rig.run(WATCH_S + 1)
    assert report.whole()["map"]["untold"] == ""
    await farm.rig.close()


async def test_a_storm_is_shown_raises_nothing_and_orders_nothing(tmp_path: Path) -> None:
    farm = Farm(tmp_path, NORTH)
    report = report_of(farm.rig)
    await farm.rig.run(1)
    await farm.others.patch(REF, {"name": make.text("Newest")})
    farm.rig.road.requests.clear()
    kinds = ("AgriParcel", "CommandMessage", "AgriParcelOperation", "StateMessage", "CommandReturnMessage")
    for number in range(1000):
        kind = kinds[number % len(kinds)]
        assert farm.notified({"id": f"urn:ngsi-ld:{kind}:hof:{number}", "type": kind})
    shown = report.whole()["map"]
    assert (shown["is_storm"], shown["notifications"], codes(report)) == (True, 1000, [])
    await farm.rig.run(STORM_S + 2)
    assert not report.whole()["map"]["is_storm"]
    assert [one.after.name for one in farm.book.all() if one.after] == ["Newest"], "nothing of it was missed"
    assert {one.method for one in farm.rig.road.requests} == {"GET"}, "a notification makes nobody write anything"
    await farm.rig.close()


@pytest.mark.parametrize("kind", ["CommandMessage", "AgriParcelOperation", "StateMessage", "CommandReturnMessage"])
async def test_a_notification_of_anything_but_the_map_is_read_and_comes_to_nothing(tmp_path: Path, kind: str) -> None:
    farm = Farm(tmp_path, NORTH)
    report = report_of(farm.rig)
    await farm.rig.run(1)
    order = Entity(ref=EntityRef(f"urn:ngsi-ld:{kind}:hof:x", kind), attributes={"status": make.text("ongoing")})
    await farm.others.upsert(order)
    farm.rig.road.requests.clear()
    assert farm.notified({"id": order.ref.id, "type": kind})
    await farm.rig.run(2)
    assert (farm.book.all(), codes(report)) == ([], [])
    assert {one.method for one in farm.rig.road.requests} == {"GET"}
    await farm.rig.close()


class Line:
    """A road over real sockets whose far end goes away without a word: connections stay, nothing is answered."""

    def __init__(self) -> None:
        self.is_dead = False
        self.taken = 0
        self._open: list[asyncio.StreamWriter] = []
        self._tasks: list[asyncio.Task[None] | None] = []

    async def serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Answer as an empty broker that keeps connections open, as long as the line lives."""
        self._open.append(writer)
        self._tasks.append(asyncio.current_task())
        try:
            while head := await reader.readuntil(b"\r\n\r\n"):
                length = next(
                    (int(line[15:]) for line in head.lower().split(b"\r\n") if line[:15] == b"content-length:"), 0
                )
                await reader.readexactly(length)
                self.taken += 1
                if self.is_dead:
                    continue
                writer.write(_answer(head))
                await writer.drain()
        except (asyncio.IncompleteReadError, ConnectionError):
            pass
        finally:
            writer.close()

    async def close(self) -> None:
        """Let every connection go."""
        for writer in self._open:
            writer.close()
        await asyncio.gather(*(one for one in self._tasks if one is not None))


def _answer(head: bytes) -> bytes:
    path = head.split(b" ", 2)[1]
    if path == b"/version":
        body, status = b'{"orion": {"version": "4.3.0"}}', b"200 OK"
    elif head.startswith(b"POST"):
        return b"HTTP/1.1 204 No Content\r\n\r\n"
    else:
        body, status = (
            b'{"error": "NotFound", "description": "The requested entity has not been found."}',
            b"404 Not Found",
        )
    kind = b"Content-Type: application/json"
    return b"HTTP/1.1 %s\r\n%s\r\nContent-Length: %d\r\n\r\n%s" % (status, kind, len(body), body)


@asynccontextmanager
async def linked(folder: Path) -> AsyncIterator[tuple[Line, CloudLink]]:
    """Give a link over a line of its own."""
    line = Line()
    server = await asyncio.start_server(line.serve, "127.0.0.1", 0)
    url = f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}"
    broker = Broker(url, Tenant("farm"), timeout_s=0.3, retry=RetryPolicy(attempts=1))
    client = NgsiClient(broker)
    link = CloudLink(client, Marker(folder / "console.json", CONSOLE, "Hof", is_strict=False), SystemClock())
    yield line, link
    await client.close()
    await line.close()
    server.close()
    await server.wait_closed()


@pytest.mark.parametrize("is_fresh", [True, False], ids=["a new connection", "a connection that was in use"])
async def test_a_line_that_is_half_open_is_said_to_be_silent_and_comes_back(tmp_path: Path, is_fresh: bool) -> None:
    async with linked(tmp_path) as (line, link):
        if not is_fresh:
            assert await link.is_ready()
        line.is_dead = True
        if is_fresh:
            assert not await link.is_ready()
        else:
            found = await link.deliver([Entity(ref=REF, attributes={"area": make.number(1)})], {})
            assert (found.is_cut, found.is_doubtful, found.done) == (True, True, set())
        assert link.link.state is LinkState.SILENT
        (alarm,) = broker_findings(link.link, 3)
        assert alarm.code == "cloud-away"
        assert alarm.text.endswith(". 3 records wait."), "two sentences, not one"
        line.is_dead = False
        link.link.ask_now()
        assert await link.is_ready(), "the dead connection is not used again"
        assert link.link.state in (LinkState.OK, LinkState.SLOW)


async def test_a_write_into_a_line_that_is_half_open_is_made_once(tmp_path: Path) -> None:
    async with linked(tmp_path) as (line, link):
        assert await link.is_ready()
        before, line.is_dead = line.taken, True
        with pytest.raises(Exception, match="no answer"):
            await link.client.connection.send(Call("POST", "v2/entities", body={"id": "a", "type": "B"}))
        assert line.taken == before + 1, "an order is never put twice"
