"""Which pages may talk to the console, and under which names it answers."""

from __future__ import annotations

import ipaddress
import re
from collections.abc import Iterable
from urllib.parse import urlsplit

_DEFAULT_PORTS = {"http": 80, "https": 443}
_HTTP_OF = {"http": "http", "https": "https", "ws": "http", "wss": "https"}
_NAME = re.compile(r"[a-z0-9]([a-z0-9_-]{0,62}[a-z0-9])?(\.[a-z0-9]([a-z0-9_-]{0,62}[a-z0-9])?)*")
# Names that no public DNS gives away, so that a stranger's domain cannot be pointed at the console (DNS rebinding).
_LOCAL_ENDINGS = (".local", ".localhost", ".lan", ".home", ".internal", ".home.arpa")


class Origins:
    """Judges ``Origin`` and ``Host`` headers.

    Args:
        allowed: further origins, e.g. ``https://farm.example`` of a reverse proxy; their hosts are known names too.
        hosts: further names the console answers to.

    Raises:
        ValueError: an entry of ``allowed`` is no origin.
    """

    def __init__(self, allowed: Iterable[str] = (), hosts: Iterable[str] = ()) -> None:
        self._allowed = {_required(origin) for origin in allowed}
        names = {urlsplit(origin).hostname or "" for origin in self._allowed}
        self._hosts = names | {host.casefold() for host in hosts}

    def is_known_host(self, host: str) -> bool:
        """Say whether ``Host`` names this console: an address, a name without a dot, a local or a configured one."""
        name = _host_name(host)
        if name is None:
            return False
        return _is_address(name) or "." not in name or name.endswith(_LOCAL_ENDINGS) or name in self._hosts

    def is_allowed(self, origin: str | None, scheme: str, host: str) -> bool:
        """Say whether a page of ``origin`` may talk to us as ``scheme://host`` (http, https, ws or wss)."""
        given = normal_origin(origin)
        if given is None:
            return False
        return given == normal_origin(f"{_HTTP_OF.get(scheme, scheme)}://{host}") or given in self._allowed


def normal_origin(origin: str | None) -> str | None:
    """Return an origin in small letters without default port; ``None`` for ``null`` and everything malformed."""
    if not origin or len(origin) > 300:
        return None
    try:
        parts = urlsplit(origin)
        port = parts.port
    except ValueError:
        return None
    is_bare = not (parts.path or parts.query or parts.fragment or "@" in parts.netloc)
    if parts.scheme not in _DEFAULT_PORTS or not is_bare or _host_name(parts.netloc) is None:
        return None
    name = parts.hostname or ""
    shown = f"[{name}]" if ":" in name else name
    return f"{parts.scheme}://{shown}" + ("" if port in (None, _DEFAULT_PORTS[parts.scheme]) else f":{port}")


def is_loopback(host: str) -> bool:
    """Say whether ``Host`` names the machine itself, which browsers trust without TLS."""
    name = _host_name(host) or ""
    if _is_address(name):
        return ipaddress.ip_address(name).is_loopback
    return name == "localhost" or name.endswith(".localhost")


def _host_name(host: str) -> str | None:
    """Return the name in ``name``, ``name:port`` or ``[v6]:port``; ``None`` if it is none of them."""
    if len(host) > 255 or not host.isascii():
        return None
    host = host.casefold()
    match = re.fullmatch(r"(\[(?P<v6>[0-9a-f:.]+)\]|(?P<name>[^:\[\]]+))(:(?P<port>[0-9]{1,5}))?", host)
    if match is None or int(match["port"] or 0) > 65_535:
        return None
    if match["v6"] is not None:
        return match["v6"] if _is_address(match["v6"]) else None
    name = match["name"].removesuffix(".")
    return name if _NAME.fullmatch(name) else None


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def _required(origin: str) -> str:
    normal = normal_origin(origin.rstrip("/"))
    if normal is None:
        raise ValueError(f"allowed_origins: {origin!r} is no origin such as https://farm.example")
    return normal
