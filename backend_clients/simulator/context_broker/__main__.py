"""``python -m backend_clients.simulator.context_broker --port 1026``: a broker until SIGTERM or SIGINT."""

from __future__ import annotations

import argparse
import asyncio
import signal
import sys
from collections.abc import Mapping

from starlette.types import ASGIApp

from backend_clients.simulator.context_broker.server import serve

ORION_PORT = 1026


async def _run(host: str, port: int, beside: Mapping[str, ASGIApp]) -> None:
    stopping = asyncio.Event()
    loop = asyncio.get_running_loop()
    for number in (signal.SIGTERM, signal.SIGINT):
        loop.add_signal_handler(number, stopping.set)
    async with serve(host, port, beside=beside) as served:
        sys.stdout.write(f"context broker (simulated) at {served.url}\n")
        sys.stdout.flush()
        await stopping.wait()


def run(host: str, port: int, beside: Mapping[str, ASGIApp] | None = None) -> None:
    """Run a broker until SIGTERM or SIGINT.

    Args:
        beside: other services of the same process, by path.

    Raises:
        OSError: the port is taken.
    """
    asyncio.run(_run(host, port, beside or {}))


def main() -> int:
    """Run the broker; 2 if the port is taken."""
    parser = argparse.ArgumentParser(prog="context_broker", description=__doc__)
    parser.add_argument("--host", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=ORION_PORT, help="0 is a free one")
    given = parser.parse_args()
    try:
        run(given.host, given.port)
    except OSError as error:
        sys.stderr.write(f"cannot listen on {given.host}:{given.port}: {error}\n")
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
