"""The composition root: the only place that knows everybody."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmi.lean_start import lean_start

if TYPE_CHECKING:
    from hmi.settings import Settings


LEANLY = ("engineio", "httpx", "paho.mqtt.client", "structlog")
"""Libraries imported without what they bring along for others; see ``hmi.lean_start``."""


def run_console(settings: Settings) -> None:
    """Serve the console until SIGTERM or SIGINT.

    Raises:
        StartError: the database cannot be used.
    """
    with lean_start(*LEANLY):
        from hmi.app.server import serve_console

    serve_console(settings)
