"""Where a worker may connect to: a name is resolved once, judged, and the address itself is used."""

from __future__ import annotations

import ipaddress
import socket
from collections.abc import Sequence
from dataclasses import dataclass
from urllib.parse import urlsplit, urlunsplit

from hmi.domain.camera import SourceKind
from hmi.domain.camera_source import Reach, SourceRefused, check_address

SCHEMES: dict[SourceKind, dict[str, int]] = {
    SourceKind.ROBOT: {"http": 80, "https": 443},
    SourceKind.MJPEG: {"http": 80, "https": 443},
    SourceKind.SNAPSHOT: {"http": 80, "https": 443},
    SourceKind.WHEP: {"http": 80, "https": 443},
    SourceKind.RTSP: {"rtsp": 554, "rtsps": 322},
}


class BadAddress(Exception):
    """The address may not be opened; the text says why."""


@dataclass(frozen=True, slots=True)
class Target:
    """A URL with the address in place of the name; ``host`` is the name, for ``Host`` and certificates."""

    url: str
    host: str
    hostname: str


def target_of(url: str, kind: SourceKind, nets: Sequence[str]) -> Target:
    """Resolve and judge; raises ``BadAddress``."""
    parts = urlsplit(url)
    ports = SCHEMES.get(kind, {})
    try:
        name, port = parts.hostname, parts.port
    except ValueError as error:
        raise BadAddress("its address is not an address") from error
    if parts.scheme not in ports or not name:
        raise BadAddress(f"its address must begin with {' or '.join(f'{one}://' for one in ports)}")
    address = _address(name, port or ports[parts.scheme], nets)
    shown = f"[{address}]" if ":" in address else address
    place = shown if port is None else f"{shown}:{port}"
    host = parts.netloc.rpartition("@")[2]
    return Target(urlunsplit((parts.scheme, place, parts.path, parts.query, "")), host, name)


def _address(name: str, port: int, nets: Sequence[str]) -> str:
    try:
        found = socket.getaddrinfo(name, port, type=socket.SOCK_STREAM)
    except OSError as error:
        raise BadAddress(f"no machine is called {name}") from error
    addresses = [str(entry[4][0]) for entry in found]
    allowed = [one for one in addresses if is_allowed(one, nets)]
    if not allowed:
        raise BadAddress(f"{addresses[0]} is not an address cameras may have here")
    return allowed[0]


def is_allowed(address: str, nets: Sequence[str]) -> bool:
    """Say whether an address is one machine's, and in ``nets`` if any are named."""
    try:
        place = ipaddress.ip_address(address.partition("%")[0])
    except ValueError:
        return False
    own = Reach(hosts=frozenset({address}), is_loopback_allowed=True)  # the console checked it: the robot itself
    reach = Reach(tuple(ipaddress.ip_network(net, strict=False) for net in nets)) if nets else own
    try:
        check_address(address, place, reach)
    except SourceRefused:
        return False
    return True
