"""The camera process: zygote and service import side by side; the note says where it listens once both are there."""

from __future__ import annotations

import asyncio
import contextlib
import logging

from hmi.cameras.udp_ports import loop_maker
from hmi.cameras.worker_process import start_zygote
from hmi.settings import Settings, port_range


def run_cameras(settings: Settings) -> None:
    """Serve until SIGTERM or SIGINT; blocks. ``HEADLAND_DATA/run/cameras.json`` says where, from the moment it does."""
    logging.basicConfig(level=logging.INFO, format="%(asctime)s %(levelname)s %(name)s %(message)s")
    for noisy in ("websockets", "websockets.server", "aioice", "aiortc", "httpx", "uvicorn"):
        logging.getLogger(noisy).setLevel(logging.ERROR)
    start_zygote()
    from hmi.cameras.service import serve

    maker = loop_maker(port_range(settings.camera_udp_ports))
    with contextlib.suppress(KeyboardInterrupt), asyncio.Runner(loop_factory=maker) as runner:
        runner.run(serve(settings))
