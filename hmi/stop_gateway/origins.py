"""Which pages may talk to the gateway."""

from __future__ import annotations

import re
from urllib.parse import urlsplit

from hmi.settings import Settings

_DEFAULT_PORTS = {"http": 80, "https": 443}


def origin_pattern(settings: Settings) -> str:
    """Return a regular expression for allowed origins, to be matched whole.

    The console's own origin is any host name with its port: a tablet may know the machine by name, by LAN
    address or as localhost, and the STOP token, not the origin, says who may press.
    """
    own = [rf"{scheme}://(?:[A-Za-z0-9._-]+|\[[0-9A-Fa-f:.]+\]){port}" for scheme, port in _own(settings)]
    further = list(settings.allowed_origins)
    if settings.stop_public_url:
        parts = urlsplit(settings.stop_public_url)
        further.append(f"{parts.scheme}://{parts.netloc}")
    return "|".join([*own, *(re.escape(origin.rstrip("/")) for origin in further)])


def _own(settings: Settings) -> list[tuple[str, str]]:
    # a browser leaves a scheme's usual port out of the origin
    return [
        (scheme, f"(?::{settings.port})?" if settings.port == usual else f":{settings.port}")
        for scheme, usual in _DEFAULT_PORTS.items()
    ]
