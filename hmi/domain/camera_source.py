"""Where a camera's pictures come from, and which addresses may be asked for them.

An address that an admin types in is fetched by our own processes, so it must not be a way into what stands behind
them. The form of the URL is judged once (``check_url``); what its host means is judged at each connection, and the
connection goes to the address that was judged (``pin``): a name that changes its meaning in between changes nothing.
Nobody here follows a redirect: whoever fetches must refuse one.
"""

from __future__ import annotations

import ipaddress
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from urllib.parse import quote, urlsplit

from hmi.domain.camera import FIELD_ROBOT, SourceKind

Address = ipaddress.IPv4Address | ipaddress.IPv6Address
Network = ipaddress.IPv4Network | ipaddress.IPv6Network

FIELD = FIELD_ROBOT
URL_CHARS = 300
_NAT64 = ipaddress.ip_network("64:ff9b::/96")
_METADATA = frozenset(
    ipaddress.ip_address(one) for one in ("169.254.169.254", "fd00:ec2::254", "100.100.100.200", "168.63.129.16")
)
_NAME = re.compile(r"[a-z0-9](?:[a-z0-9-]*[a-z0-9])?(?:\.[a-z0-9](?:[a-z0-9-]*[a-z0-9])?)*\.?")
_NUMBER = re.compile(r"(?:0x[0-9a-f]*|[0-9]+)\.?")  # C libraries read 0x7f.1 and 2130706433 as addresses
_SAFE = re.compile(r"[!#-;=?-\[\]_a-z{|}~]*")  # printable ASCII without space, ", \, <, >, ^ and `
_PASSWORD = re.compile(r"(?:^|[&;])[a-z0-9_.-]*(?:pass|pwd|token|secret|api_?key)[a-z0-9_.-]*=", re.IGNORECASE)
_DEFAULT_PORT = {"http": 80, "https": 443, "rtsp": 554, "rtsps": 322}


SCHEMES: dict[SourceKind, tuple[str, ...]] = {
    SourceKind.ROBOT: ("http", "https"),
    SourceKind.RTSP: ("rtsp", "rtsps"),
    SourceKind.WHEP: ("http", "https"),
    SourceKind.MJPEG: ("http", "https"),
    SourceKind.SNAPSHOT: ("http", "https"),
    SourceKind.UPLOAD: (),
}


class SourceRefused(ValueError):
    """An address that is not used; ``code`` for programs, ``text`` one sentence for a person.

    Codes: ``bad_url``, ``scheme``, ``user_info``, ``host``, ``never``, ``loopback``, ``network``, ``no_address``.
    """

    def __init__(self, code: str, text: str) -> None:
        super().__init__(text)
        self.code, self.text = code, text


@dataclass(frozen=True, slots=True)
class Source:
    """Where the pictures of one camera come from; the password never shows in a log."""

    robot: str
    camera: str
    kind: SourceKind = SourceKind.ROBOT
    url: str = ""
    user: str = ""
    password: str = field(default="", repr=False)


@dataclass(frozen=True, slots=True)
class Reach:
    """Where cameras may be.

    Args:
        networks: networks of cameras, from the settings.
        hosts: hosts that are allowed by name: the one the robot is registered with.
        is_loopback_allowed: whether this machine is; demo only. A network inside the loopback range allows it too.
    """

    networks: tuple[Network, ...] = ()
    hosts: frozenset[str] = frozenset()
    is_loopback_allowed: bool = False

    def names(self, host: str) -> bool:
        """Whether a host is allowed whatever private network it is in."""
        return _plain(host) in self.hosts

    def holds(self, address: Address) -> bool:
        """Whether a network of the settings holds an address."""
        return any(address in one for one in self.networks if one.version == address.version)

    def holds_loopback(self, address: Address) -> bool:
        """Whether an address of this machine may be used; ``0.0.0.0/0`` is not meant to say so."""
        return self.is_loopback_allowed or any(
            one.is_loopback and address in one for one in self.networks if one.version == address.version
        )


@dataclass(frozen=True, slots=True)
class Place:
    """A URL whose form was judged. ``target`` is path and query."""

    scheme: str
    host: str
    port: int
    target: str

    @property
    def is_tls(self) -> bool:
        """Whether the connection is encrypted; then present yourself to ``host``, not to the address."""
        return self.scheme in ("https", "rtsps")


def reach_of(networks: Iterable[str], robot_url: str | None, *, is_demo: bool) -> Reach:
    """Return where the cameras of a robot may be; raises ``ValueError`` for a network that is none.

    Args:
        networks: CIDR, from the settings.
        robot_url: the HTTP address the robot is registered with.
    """
    host = ""
    if robot_url:
        try:
            host = urlsplit(robot_url).hostname or ""
        except ValueError:
            host = ""
    return Reach(
        tuple(ipaddress.ip_network(one, strict=False) for one in networks),
        frozenset({_plain(host)} if host else ()),
        is_demo,
    )


def check_url(kind: SourceKind, url: str, reach: Reach) -> Place:
    """Judge the form of a URL, and its host if that is an address; raises ``SourceRefused``. No DNS is asked."""
    if not url or len(url) > URL_CHARS or not _SAFE.fullmatch(url):
        raise SourceRefused("bad_url", f"This is no address. Use {_example(kind)}.")
    try:
        parts = urlsplit(url)
        port, host = parts.port, (parts.hostname or "").lower()
    except ValueError as error:
        raise SourceRefused("bad_url", f"This is no address. Use {_example(kind)}.") from error
    if parts.scheme not in SCHEMES[kind]:
        raise SourceRefused("scheme", f"A camera of this kind has an address such as {_example(kind)}.")
    if "@" in parts.netloc:
        raise SourceRefused("user_info", "Put no name or password into the address. They have fields of their own.")
    if _PASSWORD.search(parts.query):
        raise SourceRefused("user_info", "Put no password into the address: it would be kept for all to read.")
    if parts.fragment or port == 0:
        raise SourceRefused("bad_url", f"This is no address. Use {_example(kind)}.")
    _check_host(host, reach)
    target = (parts.path or "/") + (f"?{parts.query}" if parts.query else "")
    return Place(parts.scheme, host, port or _DEFAULT_PORT[parts.scheme], target)


def pin(place: Place, addresses: Sequence[str], reach: Reach) -> str:
    """Return the first address that a camera may be at, of all that DNS answered; connect to it and to no other.

    Raises:
        SourceRefused: there is none; for the reason of the first.
    """
    refused = SourceRefused("no_address", f"{place.host} cannot be found.")
    for number, one in enumerate(addresses):
        try:
            address = ipaddress.ip_address(one.split("%")[0])
            check_address(place.host, address, reach)
        except SourceRefused as error:
            refused = error if number == 0 else refused
        except ValueError:
            continue
        else:
            return str(address)
    raise refused


def check_address(host: str, address: Address, reach: Reach) -> None:
    """Return if a camera may be at an address; raises ``SourceRefused``."""
    real = _real(address)
    if real.is_link_local or real.is_multicast or real.is_unspecified or real in _METADATA or _is_broadcast(real):
        leads = "" if _literal(host) is not None else f"{host} leads to {real}. "
        raise SourceRefused("never", f"{leads}No camera may be at {real}.")
    if real.is_loopback:
        if not reach.holds_loopback(real):
            raise SourceRefused("loopback", f"{host} is this machine. Cameras of this machine are for the demo only.")
        return
    if not reach.names(host) and not reach.holds(real):
        raise SourceRefused(
            "network",
            f"{host} is neither the robot nor in a network of cameras. The setting camera_networks allows it.",
        )


def pinned_url(place: Place, address: str, user: str = "", password: str = "") -> str:
    """Return the URL with the judged address instead of the name; with credentials for clients that take them so."""
    shown = f"[{address}]" if ":" in address else address
    login = f"{quote(user, safe='')}:{quote(password, safe='')}@" if user or password else ""
    return f"{place.scheme}://{login}{shown}:{place.port}{place.target}"


def _check_host(host: str, reach: Reach) -> None:
    literal = _literal(host)
    if literal is not None:
        check_address(host, literal, reach)
        return
    if not _NAME.fullmatch(host) or _NUMBER.fullmatch(host.rstrip(".").rsplit(".", 1)[-1]):
        raise SourceRefused("host", "The host must be a name or an address such as 192.0.2.10.")
    if _plain(host) == "localhost" or _plain(host).endswith(".localhost"):
        check_address(host, ipaddress.IPv4Address("127.0.0.1"), reach)


def _real(address: Address) -> Address:
    """Return the IPv4 address that an IPv6 one carries, or the address itself."""
    if isinstance(address, ipaddress.IPv4Address):
        return address
    if address.ipv4_mapped is not None:
        return address.ipv4_mapped
    if address.sixtofour is not None:
        return address.sixtofour
    if address.teredo is not None:
        return address.teredo[1]
    if address in _NAT64 or 1 < int(address) < 1 << 32:  # the second is ::192.0.2.1, of old
        return ipaddress.IPv4Address(int(address) & 0xFFFFFFFF)
    return address


def _is_broadcast(address: Address) -> bool:
    return isinstance(address, ipaddress.IPv4Address) and int(address) == 0xFFFFFFFF


def _literal(host: str) -> Address | None:
    try:
        return None if "%" in host else ipaddress.ip_address(host)  # a zone belongs to link-local addresses
    except ValueError:
        return None


def _plain(host: str) -> str:
    return host.lower().rstrip(".")


def _example(kind: SourceKind) -> str:
    return "rtsp://host/stream" if kind is SourceKind.RTSP else "http://host/path"
