"""A broker for each test: the simulated one on a loopback port, or any broker named by ``HEADLAND_TEST_NGSI_URL``.

With another broker, ``HEADLAND_TEST_NGSI_NOTIFY_HOST`` is the address at which it reaches this machine.
"""

from __future__ import annotations

import asyncio
import os
import queue
import secrets
import threading
from collections.abc import AsyncIterator, Callable, Iterator

import pytest

from backend_clients.ngsi.client import NgsiClient
from backend_clients.ngsi.connection import Broker
from backend_clients.ngsi.query import Query
from backend_clients.ngsi.subscriptions import Subscriptions
from backend_clients.ngsi.tenant import Tenant
from backend_clients.simulator.context_broker.server import serve
from tests.contract.ngsi.receiver import Receiver

ELSEWHERE = os.environ.get("HEADLAND_TEST_NGSI_URL", "")
NOTIFY_HOST = os.environ.get("HEADLAND_TEST_NGSI_NOTIFY_HOST", "127.0.0.1")


@pytest.fixture(scope="session")
def broker_url() -> Iterator[str]:
    """Return where the broker is; tests have a tenant each, so one broker serves them all."""
    if ELSEWHERE:
        yield ELSEWHERE
        return
    started: queue.Queue[tuple[str, Callable[[], object]]] = queue.Queue()

    async def run() -> None:
        ending, loop = asyncio.Event(), asyncio.get_running_loop()
        async with serve() as served:
            started.put((served.url, lambda: loop.call_soon_threadsafe(ending.set)))
            await ending.wait()

    thread = threading.Thread(target=asyncio.run, args=(run(),), daemon=True)
    thread.start()
    url, end = started.get(timeout=10)
    yield url
    end()
    thread.join(10)


@pytest.fixture
async def client(broker_url: str) -> AsyncIterator[NgsiClient]:
    """Return a client of a tenant of its own; what it leaves is deleted."""
    tenant = Tenant(f"headland_test_{secrets.token_hex(4)}", "/farm")
    async with NgsiClient(Broker(broker_url, tenant)) as client:
        yield client
        left = [entity async for entity in client.entities(Query())]
        await client.batch("delete", [entity.model_copy(update={"attributes": {}}) for entity in left])


@pytest.fixture
async def subscriptions(client: NgsiClient) -> AsyncIterator[Subscriptions]:
    """Return the subscriptions of this test; what it leaves is deleted."""
    ours = Subscriptions(client.connection, "contract")
    yield ours
    await ours.clean_up(keep=())


@pytest.fixture
async def receiver() -> AsyncIterator[Receiver]:
    """Return what takes notifications."""
    async with Receiver(NOTIFY_HOST) as receiver:
        yield receiver
