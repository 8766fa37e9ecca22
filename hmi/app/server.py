"""Run the console process: prepare, serve, end."""

from __future__ import annotations

import asyncio
import logging

import structlog
import uvicorn

from hmi.app.console import Console
from hmi.app.web import build_web
from hmi.clock import SystemClock
from hmi.keeper.errors import StartError
from hmi.settings import Settings
from hmi.store.errors import StoreError

GRACE_S = 1  # open websockets get this long when the console ends
MAX_FRAME_BYTES = 1024 * 1024


def serve_console(settings: Settings) -> None:
    """Serve until SIGTERM or SIGINT; blocks.

    Raises:
        StartError: the database cannot be used.
    """
    _configure_logging()
    asyncio.run(_serve(settings))


async def _serve(settings: Settings) -> None:
    try:
        console = await Console.prepare(settings, SystemClock())
    except StoreError as error:
        raise StartError(f"{error}") from error
    config = uvicorn.Config(
        build_web(console),
        host=settings.host,
        port=settings.port,
        log_level="warning",
        access_log=False,
        server_header=False,
        ws_per_message_deflate=False,  # compressing every frame for every browser costs 3.7 to 5.7 times as much
        ws_max_size=MAX_FRAME_BYTES,
        timeout_graceful_shutdown=GRACE_S,
        ssl_certfile=settings.tls_cert,
        ssl_keyfile=settings.tls_key,
    )
    await console.start()
    try:
        await uvicorn.Server(config).serve()
    finally:
        await console.stop()


def _configure_logging() -> None:
    logging.basicConfig(level=logging.INFO, format="%(asctime)s %(levelname)s %(name)s %(message)s")
    # not each call to the cloud and each robot's message
    structlog.configure(wrapper_class=structlog.make_filtering_bound_logger(logging.INFO))
    for noisy in ("httpx", "httpcore", "alembic"):
        logging.getLogger(noisy).setLevel(logging.WARNING)
