"""What the camera process serves, once its zygote is on the way."""

from __future__ import annotations

import asyncio
import logging
import os
import socket

from hmi.cameras.control import CameraParts, control_app
from hmi.cameras.door import Note, shared_secret, write_note
from hmi.cameras.hub import Hub
from hmi.cameras.page_socket import PageSockets
from hmi.cameras.ring import Rings
from hmi.cameras.whep import WhepDesk
from hmi.cameras.worker_process import zygote_is_ready
from hmi.clock import SystemClock
from hmi.settings import Settings, port_range
from hmi.side_server import loopback_server

SEND_BUFFER_BYTES = 256 * 1024  # a page that does not keep up shall not have seconds of pictures in the kernel
MOST_PAGES = 200
log = logging.getLogger("headland.cameras")


async def serve(settings: Settings) -> None:
    """Serve until a signal."""
    clock, secret = SystemClock(), shared_secret(settings.data)
    hub = Hub(clock, settings.camera_video_width, settings.camera_workers)
    ports = port_range(settings.camera_udp_ports)
    whep = WhepDesk(settings.camera_viewers if ports is None else min(settings.camera_viewers, len(ports)))
    pages, rings = PageSockets(hub, whep, clock, MOST_PAGES), Rings(clock)
    parts = CameraParts(hub, pages, whep, rings, clock, settings.data)
    listener, server = loopback_server(control_app(parts, secret))
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER_BYTES)
    await asyncio.to_thread(zygote_is_ready)
    write_note(settings.data, Note(os.getpid(), listener.getsockname()[1]))
    log.info("the camera process listens")
    try:
        await server.serve(sockets=[listener])
    finally:
        await whep.end()
        await hub.end()
