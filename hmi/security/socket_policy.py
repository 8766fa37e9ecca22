"""How the socket of the pages (socket.io) has to be set; ``hmi.app`` puts these values in.

By default it takes any Origin and notices a dead browser after many seconds.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from hmi.security.origins import Origins

PING_INTERVAL_S = 2
PING_TIMEOUT_S = 2
TRANSPORTS = ["websocket"]
"""For ``socket_io_js_transports``: polling by GET carries no Origin, so the request guard refuses it."""


def allowed_origin(origins: Origins) -> Callable[[str | None, dict[str, Any]], bool]:
    """Return what ``eio.cors_allowed_origins`` takes: a judge of ``(origin, environ)``."""

    def judge(origin: str | None, environ: dict[str, Any]) -> bool:
        # engine.io says "http" for every request; the ASGI scope knows better.
        scheme = environ.get("asgi.scope", {}).get("scheme", "http")
        return origins.is_allowed(origin, scheme, str(environ.get("HTTP_HOST", "")))

    return judge
