"""Where notifications may go: a webhook must not be a way into the network behind the server.

Names are resolved once, every address is judged, and the connection goes to the address that was judged: a name
that changes its meaning in between changes nothing.
"""

from __future__ import annotations

import ipaddress
import socket
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from urllib.parse import urlsplit

from hmi.notifications.errors import BadAddress

Address = ipaddress.IPv4Address | ipaddress.IPv6Address
Resolve = Callable[[str, int], Sequence[str]]
_NAT64 = ipaddress.ip_network("64:ff9b::/96")
_METADATA = frozenset({ipaddress.ip_address("fd00:ec2::254"), ipaddress.ip_address("100.100.100.200")})


@dataclass(frozen=True, slots=True)
class Target:
    """A place that was judged: connect to ``address``, present yourself to ``host``."""

    host: str
    port: int
    address: str


@dataclass(frozen=True, slots=True)
class AddressRules:
    """What is allowed.

    Args:
        hosts: if any are named, only these; a leading dot allows everything below a domain.
        is_private_allowed: whether addresses of this machine and of private networks are.
        resolve: host and port to addresses; blocking.
    """

    hosts: tuple[str, ...] = ()
    is_private_allowed: bool = False
    resolve: Resolve | None = None

    def check_url(self, url: str) -> tuple[str, int]:
        """Return host and port of a URL whose form is allowed; raises ``BadAddress``."""
        try:
            parts = urlsplit(url)
            port = parts.port
        except ValueError as error:
            raise BadAddress("This is no address. Use https://host/path.") from error
        if parts.scheme not in ("http", "https") or not parts.hostname:
            raise BadAddress("Only http and https addresses can be used.")
        if parts.username is not None or parts.password is not None:
            raise BadAddress("Put no name or password into the address; use the secret field.")
        self.check_host(parts.hostname)
        return parts.hostname, port or (443 if parts.scheme == "https" else 80)

    def check_host(self, host: str) -> None:
        """Return if a host is one of those that are allowed; raises ``BadAddress``."""
        name = host.lower().rstrip(".")
        if self.hosts and not any(name == one or (one.startswith(".") and name.endswith(one)) for one in self.hosts):
            raise BadAddress(f"{host} is not in the list of allowed hosts (setting notify_hosts).")
        literal = _literal(name)
        if literal is not None:
            self._check(host, literal)

    def find(self, host: str, port: int) -> Target:
        """Resolve a host and judge what it means; blocks. Raises ``BadAddress``."""
        self.check_host(host)
        try:
            found = (self.resolve or _resolve)(host, port)
        except OSError as error:
            raise BadAddress(f"{host} cannot be found.") from error
        addresses = [ipaddress.ip_address(one.split("%")[0]) for one in found]
        if not addresses:
            raise BadAddress(f"{host} cannot be found.")
        for address in addresses:  # all of them: which one is taken must not be the other side's choice
            self._check(host, address)
        return Target(host, port, str(addresses[0]))

    def _check(self, host: str, address: Address) -> None:
        real = _real(address)
        if real.is_link_local or real.is_multicast or real.is_unspecified or real in _METADATA:
            raise BadAddress(f"{host} leads to {real}, which is never allowed.")
        if not real.is_global and not self.is_private_allowed:
            raise BadAddress(f"{host} leads into a private network. The setting notify_private allows that.")


def _real(address: Address) -> Address:
    """Return the IPv4 address that an IPv6 one carries, or the address itself."""
    if isinstance(address, ipaddress.IPv4Address):
        return address
    if address.ipv4_mapped is not None:
        return address.ipv4_mapped
    if address.sixtofour is not None:
        return address.sixtofour
    if address in _NAT64:
        return ipaddress.IPv4Address(int(address) & 0xFFFFFFFF)
    return address


def _literal(host: str) -> Address | None:
    try:
        return ipaddress.ip_address(host)
    except ValueError:
        return None


def _resolve(host: str, port: int) -> list[str]:
    return [str(one[4][0]) for one in socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)]
