"""Coordinator and sender against a real broker and the simulated weeder."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import ExitStack, asynccontextmanager
from pathlib import Path

import pytest

from hmi.clock import SystemClock
from hmi.domain.command import Acknowledgement, StopOrder
from hmi.domain.robot import Mode, Robot
from hmi.ingest.coordinator import EdgeCoordinator, mqtt_link
from hmi.ingest.sender import EdgeSender
from hmi.store.fleet import FleetStore
from tests.brokers import MOSQUITTO, free_port, start_mosquitto
from tests.contract.wire import ROBOT, TOKEN, Site, running_simulator
from tests.hmi.ingest.wire import Entry

pytestmark = [pytest.mark.broker, pytest.mark.skipif(MOSQUITTO is None, reason="mosquitto is not installed")]
WAIT_S = 15.0


class Wire:
    """A coordinator on a real broker."""

    def __init__(self, url: str, entry: Entry) -> None:
        clock = SystemClock()
        self.clock = clock
        self.store = FleetStore(clock.mono_s)
        self.store.set_registry([entry])
        self.edge = EdgeCoordinator(mqtt_link(url, "test-console"), self.store, clock)
        self.acks: list[Acknowledgement] = []
        self.edge.listeners.on_ack.append(self.acks.append)
        self._changed = asyncio.Event()
        self.store.subscribe(self._changed.set)

    async def until(self, claim: Callable[[Robot], bool]) -> Robot:
        """Return the robot as soon as ``claim`` holds of it."""
        async with asyncio.timeout(WAIT_S):
            while True:
                self._changed.clear()
                robot = self.store.robot(ROBOT)
                if robot is not None and claim(robot):
                    return robot
                await self._changed.wait()


@asynccontextmanager
async def connected(url: str, site: Site | None = None) -> AsyncIterator[Wire]:
    http_url = f"{site.base_url}/{ROBOT}" if site else None
    wire = Wire(url, Entry(ROBOT, http_url=http_url, http_token=TOKEN))
    await wire.edge.start()
    try:
        yield wire
    finally:
        await wire.edge.stop()


async def test_a_simulated_weeder_is_heard_whole_and_its_round_trip_measured(tmp_path: Path) -> None:
    with start_mosquitto(tmp_path) as url, running_simulator(url):
        async with connected(url) as wire:
            robot = await wire.until(
                lambda r: None not in (r.factsheet, r.telemetry, r.state, r.safety, r.link.rtt_s) and r.link.is_online
            )
            assert robot.state is not None
            assert robot.state.mode is Mode.IDLE
            assert robot.link.rtt_s is not None
            assert robot.link.rtt_s < 2
            assert robot.telemetry is not None
            assert wire.clock.mono_s() - robot.telemetry.pose.stamp.source_s < 2
            assert wire.edge.diagnostics()["refused"] == {}


async def test_a_stop_is_acknowledged_on_both_ways_and_latched(tmp_path: Path) -> None:
    with start_mosquitto(tmp_path) as url, running_simulator(url) as site:
        async with connected(url, site) as wire:
            await wire.until(lambda r: r.safety is not None)
            sender = EdgeSender(wire.edge.link, wire.store.address)
            order = StopOrder(ROBOT, "stop-00000001", "Martha Keller", "Tablet 3")
            assert sender.send(order)
            robot = await wire.until(lambda r: r.safety is not None and r.safety.latched)
            assert robot.safety is not None
            assert [p.by for p in robot.safety.presses] == ["Martha Keller"]
            await wire.until(lambda _r: any(a.ref == "stop-00000001" and a.is_accepted for a in wire.acks))
            answer = await sender.stop_by_http(order)
            assert answer is not None
            assert answer.is_accepted
            await sender.close()


async def test_the_broker_may_go_and_come_back_and_nothing_is_queued_meanwhile(tmp_path: Path) -> None:
    port, first = free_port(), ExitStack()
    url = first.enter_context(start_mosquitto(tmp_path, port))
    async with connected(url) as wire:
        await wire.until(lambda r: r.link.is_broker_up)
        await asyncio.to_thread(first.close)
        await wire.until(lambda r: not r.link.is_broker_up)
        sender = EdgeSender(wire.edge.link, wire.store.address)
        assert not sender.send(StopOrder(ROBOT, "stop-00000002", "Martha Keller", "Tablet 3"))
        with start_mosquitto(tmp_path, port):
            await wire.until(lambda r: r.link.is_broker_up)
