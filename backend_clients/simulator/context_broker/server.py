"""The broker on a port, within an event loop that runs already."""

from __future__ import annotations

import asyncio
import contextlib
import socket
from collections.abc import AsyncIterator, Iterator, Mapping
from contextlib import asynccontextmanager

import httpx
import uvicorn
from starlette.types import ASGIApp

from backend_clients.simulator.context_broker.application import make_application
from backend_clients.simulator.context_broker.broker import ContextBroker
from backend_clients.simulator.context_broker.faults import FaultSwitch
from hmi.clock import Clock

BACKLOG = 100


class Served:
    """A broker that answers at ``url``."""

    def __init__(self, url: str, broker: ContextBroker, switch: FaultSwitch) -> None:
        self.url, self.broker, self.switch = url, broker, switch


@asynccontextmanager
async def serve(
    host: str = "127.0.0.1",
    port: int = 0,
    *,
    clock: Clock | None = None,
    notify_transport: httpx.AsyncBaseTransport | None = None,
    beside: Mapping[str, ASGIApp] | None = None,
) -> AsyncIterator[Served]:
    """Run a broker on a port until the block ends; port 0 is a free one.

    Args:
        beside: other services of the same port, by path.

    Raises:
        OSError: the port is taken.
    """
    listener = socket.create_server((host, port), backlog=BACKLOG)
    broker, switch = ContextBroker(clock, notify_transport), FaultSwitch()
    config = uvicorn.Config(
        make_application(broker, switch, beside),
        log_config=None,
        log_level="critical",  # a cut answer is a fault on purpose, not one to report
        access_log=False,
        lifespan="on",
        timeout_graceful_shutdown=1,
        server_header=False,
    )
    server = _Server(config)
    serving = asyncio.create_task(server.serve(sockets=[listener]), name="context-broker")
    try:
        await server.listening.wait()
        yield Served(f"http://{host}:{listener.getsockname()[1]}", broker, switch)
    finally:
        server.should_exit = server.force_exit = True
        await serving
        listener.close()


class _Server(uvicorn.Server):
    """uvicorn that leaves signals alone and says when it listens."""

    def __init__(self, config: uvicorn.Config) -> None:
        super().__init__(config)
        self.listening = asyncio.Event()

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup(sockets)
        self.listening.set()

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        yield
