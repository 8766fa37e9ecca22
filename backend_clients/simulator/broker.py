"""A small MQTT 3.1.1 broker in a process of its own, for machines without mosquitto.

``python -m backend_clients.simulator.broker --port 1883`` starts amqtt, anonymous, on loopback.
It is meant for demos: good for one to two thousand messages a second.
"""

from __future__ import annotations

import argparse
import asyncio
import logging
import signal
import sys
from collections.abc import Sequence

from amqtt.broker import Broker
from amqtt.contexts import BrokerConfig, ListenerConfig
from amqtt.errors import BrokerError

READY_LINE = "broker is ready"


async def serve(host: str, port: int) -> None:
    """Run the broker until SIGTERM or SIGINT."""
    config = BrokerConfig(
        listeners={"default": ListenerConfig(bind=f"{host}:{port}")},
        plugins={"amqtt.plugins.authentication.AnonymousAuthPlugin": {"allow_anonymous": True}},
    )
    broker = Broker(config)
    stopping = asyncio.Event()
    loop = asyncio.get_running_loop()
    for number in (signal.SIGTERM, signal.SIGINT):
        loop.add_signal_handler(number, stopping.set)
    await broker.start()
    print(READY_LINE, flush=True)  # noqa: T201 - the parent waits for this line
    await stopping.wait()
    try:
        async with asyncio.timeout(0.8):
            await broker.shutdown()
    except TimeoutError:
        pass


def main(arguments: Sequence[str] | None = None) -> None:
    """Parse ``--host`` and ``--port`` and run."""
    parser = argparse.ArgumentParser(description="Start a small MQTT broker (amqtt).")
    parser.add_argument("--host", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=1883)
    options = parser.parse_args(arguments)
    logging.basicConfig(level=logging.ERROR)
    # it prints a traceback for every message a client did not wait for
    logging.getLogger("amqtt").setLevel(logging.CRITICAL)
    try:
        asyncio.run(serve(options.host, options.port))
    except (BrokerError, OSError) as error:
        sys.exit(f"The broker cannot listen on {options.host}:{options.port}: {error}")


if __name__ == "__main__":
    main()
