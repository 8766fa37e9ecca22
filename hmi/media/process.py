"""The media process: broker connection, control port, viser, and the note that says where they listen."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import os
import secrets

from backend_clients.edge.mqtt import MqttLink
from hmi.clock import SystemClock
from hmi.media.control import control_app
from hmi.media.door import Note, shared_secret, write_note
from hmi.media.ear import Ear
from hmi.media.intake import SUBSCRIPTIONS, Intake
from hmi.media.models import FOLDER, ModelShelf
from hmi.media.studio import Studio
from hmi.settings import Settings
from hmi.side_server import loopback_server

NICE = 5  # the console and STOP come first
log = logging.getLogger("headland.media")


def run_media(settings: Settings) -> None:
    """Serve until SIGTERM or SIGINT; blocks. ``HEADLAND_DATA/run/media.json`` says where, from the moment it does."""
    logging.basicConfig(level=logging.INFO, format="%(asctime)s %(levelname)s %(name)s %(message)s")
    for noisy in ("websockets", "websockets.server", "trimesh"):
        logging.getLogger(noisy).setLevel(logging.ERROR)
    with contextlib.suppress(OSError):
        os.nice(NICE)
    with contextlib.suppress(KeyboardInterrupt):
        asyncio.run(_serve(settings))


async def _serve(settings: Settings) -> None:
    clock, secret = SystemClock(), shared_secret(settings.data)
    intake = Intake(clock)
    link = MqttLink(
        settings.broker_url,
        f"headland-media-{secrets.token_hex(6)}",
        on_message=intake.take,
        ca_file=str(settings.broker_ca) if settings.broker_ca else None,
    )
    studio = Studio(intake, settings.data / FOLDER, secret, clock, Ear(link, SUBSCRIPTIONS))
    listener, server = loopback_server(control_app(studio, ModelShelf(settings.data), secret))
    link.start()
    studio.start()
    write_note(settings.data, Note(os.getpid(), listener.getsockname()[1], studio.viser_port))
    log.info("the media process listens")
    try:
        await server.serve(sockets=[listener])
    finally:
        await studio.stop()
        await asyncio.to_thread(link.stop)
