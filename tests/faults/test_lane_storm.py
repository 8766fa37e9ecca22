"""Many browsers that come back at once, and browsers that read nothing: the others notice neither."""

from __future__ import annotations

import asyncio
import json
import sys
from asyncio.subprocess import PIPE
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager

import pytest
from websockets.asyncio.client import ClientConnection

from hmi.domain import robot as domain
from hmi.live import lane
from hmi.live.outbox import EVENT_LIMIT
from tests.hmi.live.rig import session
from tests.hmi.live.site import Site, frame, running

BROWSERS, ROUNDS = 300, 2
CHANGES = 500  # of 40 kB each: far more than the buffers between server and browser hold
ROBOTS = tuple(f"weeder-{number:03d}" for number in range(200))
TOPIC = f"robot/{ROBOTS[0]}"


def move_all(site: Site, speed_mps: float) -> None:
    """Let every robot be heard at another speed."""
    now_s = site.ticks.issue().at_s
    stamp = domain.Stamp(now_s, now_s)
    for number, robot in enumerate(ROBOTS):
        pose = domain.Pose(51.0 + number / 1e4, 4.0, 0.0, 0.0, 0.0, speed_mps, 0.0, stamp)
        battery = domain.Battery(soc=speed_mps, remaining_s=None, is_charging=False)
        site.store.put_telemetry(robot, domain.Telemetry(pose, None, battery, None, None, None))
    site.store.announce()


class Calm:
    """Somebody at work meanwhile, whose browser gets its ticks."""

    def __init__(self) -> None:
        self.fresh: asyncio.Queue[bool] = asyncio.Queue()

    async def works_until(self, is_over: Callable[[], bool]) -> None:
        """Take ticks until something is so; then an order with the next one is taken.

        Meanwhile the machine that tests and browsers share may be too slow for some: those orders are refused.
        """
        async with asyncio.timeout(60):
            while not is_over():
                await self.fresh.get()
            while not await self.fresh.get():
                pass

    async def read(self, site: Site, ws: ClientConnection) -> None:
        """Judge each tick at the moment at which it arrives."""
        async for text in ws:
            if (found := json.loads(text))["k"] == "tick":
                self.fresh.put_nowait(site.ticks.is_fresh(found["id"]))


@asynccontextmanager
async def calm_browser(site: Site) -> AsyncIterator[Calm]:
    """Open a lane and read it while the block runs."""
    calm = Calm()
    async with site.open() as ws:
        task = asyncio.create_task(calm.read(site, ws))
        try:
            yield calm
        finally:
            task.cancel()
            await asyncio.gather(task, return_exceptions=True)


async def storm(site: Site, calm: Calm) -> None:
    """Let many browsers come at once, and die once all of them show every robot."""
    browsers = await asyncio.create_subprocess_exec(
        sys.executable, "-m", "tests.faults.browsers", str(site.port), str(BROWSERS), str(len(ROBOTS)),
        stdin=PIPE, stdout=PIPE,
    )  # fmt: skip
    assert browsers.stdin is not None
    assert browsers.stdout is not None
    try:
        said = asyncio.create_task(browsers.stdout.readline())
        await calm.works_until(said.done)
        assert said.result() == f"{BROWSERS}\n".encode()
        assert site.hub.lanes == BROWSERS + 1
        browsers.stdin.close()
        await calm.works_until(lambda: site.hub.lanes == 1)
    finally:
        if browsers.returncode is None:
            browsers.kill()
        await browsers.wait()


@pytest.mark.slow
async def test_three_hundred_browsers_come_back_at_once_and_those_who_work_go_on_working() -> None:
    async with running(ROBOTS) as site, calm_browser(site) as calm:
        move_all(site, 0.4)
        for _ in range(ROUNDS):
            await storm(site, calm)


async def test_a_browser_that_takes_nothing_holds_up_nobody_and_skips_to_the_newest_state() -> None:
    async with running(ROBOTS) as site, calm_browser(site) as calm, site.open(queue=1) as slow:
        await slow.send(f'{{"k":"sub","topics":["{TOPIC}"]}}')
        await frame(slow, "snap")
        for number in range(CHANGES):
            site.hub.set_group(ROBOTS[0], "lease", {"number": number, "text": "x" * 40_000})
            await asyncio.sleep(0)
        deltas, number = 0, -1
        async with asyncio.timeout(60):
            while number < CHANGES - 1:
                found = json.loads(await slow.recv())
                deltas += found["k"] == "delta"
                number = found.get("d", {}).get(TOPIC, {}).get("lease", {}).get("number", number)
        assert deltas < CHANGES
        await calm.works_until(lambda: True)
        slow.transport.abort()


@pytest.mark.slow
async def test_a_browser_that_takes_nothing_at_all_is_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lane, "SEND_LIMIT_S", 1.0)
    async with running(ROBOTS) as site, calm_browser(site) as calm:
        site.gate.open["other"] = session("slow")
        slow = await site.open(cookie="other", queue=1)
        await frame(slow, "tick")
        for _ in range(EVENT_LIMIT):  # 15 MB, and nobody reads them
            site.hub.event({"kind": "flood", "text": "x" * 60_000}, session_id="session-slow")
        await calm.works_until(lambda: site.hub.lanes == 1)
        slow.transport.abort()
