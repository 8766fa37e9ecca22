"""The gateway's broker connections when something inside paho fails."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from pathlib import Path

from hmi.clock import SystemClock
from hmi.settings import Settings
from hmi.stop_gateway.gateway import Gateway
from tests.hmi.stop_gateway.broker import Broker
from tests.hmi.stop_gateway.running import SECRET

LIMIT_S = 10.0


async def _until(is_so: Callable[[], bool]) -> None:
    async with asyncio.timeout(LIMIT_S):
        while not is_so():  # noqa: ASYNC110 - threads of another library have no event to wait for
            await asyncio.sleep(0.01)


async def test_a_dead_network_thread_is_told_and_started_again(tmp_path: Path, broker: Broker) -> None:
    gateway = Gateway(Settings(data=tmp_path / "data", secret=SECRET, broker_url=broker.url), SystemClock())
    wire = gateway.dispatcher.wire
    wire.start()
    try:
        await _until(lambda: wire.is_up)
        for link in (wire._orders, wire._traffic):
            await asyncio.to_thread(link._client.loop_stop)  # ends the thread and nothing else
        assert wire._orders.is_up  # its socket is still open
        assert not wire.is_up  # but nobody would hear the acknowledgement
        looking = asyncio.create_task(gateway._look())
        await _until(lambda: wire.is_up and wire._traffic.is_up and wire._traffic.is_alive)
        looking.cancel()
        assert wire.faults == 2
    finally:
        await asyncio.to_thread(wire.stop)
