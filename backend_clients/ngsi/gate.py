"""Who may post notifications: a broker has no signature, so a secret path and known sources stand for one."""

from __future__ import annotations

import hmac
from collections.abc import Sequence
from ipaddress import IPv4Network, IPv6Address, IPv6Network, ip_address, ip_network

from pydantic import SecretStr

from backend_clients.ngsi.errors import BadInput

LEAST = 24  # characters of a secret; ``secrets.token_urlsafe(24)`` makes 32
Network = IPv4Network | IPv6Network


class Gate:
    """Lets the broker in.

    Args:
        secret: the last part of the path that subscriptions name; only characters that need no encoding.
        sources: addresses or networks that the broker posts from; none means any.

    Raises:
        BadInput: the secret is too short or not fit for a path, or a source is no address.
    """

    def __init__(self, secret: SecretStr, sources: Sequence[str] = ()) -> None:
        text = secret.get_secret_value()
        if len(text) < LEAST or not text.isascii() or not text.replace("-", "").replace("_", "").isalnum():
            raise BadInput(f"the secret path needs {LEAST} letters, digits, - or _ at least")
        self._secret = secret
        try:
            self._networks: tuple[Network, ...] = tuple(ip_network(source) for source in sources)
        except ValueError as error:
            raise BadInput(f"not an address or network: {error}") from error

    def lets_in(self, given: str, source: str) -> bool:
        """Say whether a request with this secret, from this address, is the broker's."""
        is_known = hmac.compare_digest(given.encode("utf-8", "replace"), self._secret.get_secret_value().encode())
        return is_known and self._is_source(source)

    def _is_source(self, text: str) -> bool:
        if not self._networks:
            return True
        try:
            address = ip_address(text)
        except ValueError:
            return False
        if isinstance(address, IPv6Address) and address.ipv4_mapped is not None:
            address = address.ipv4_mapped
        return any(address in network for network in self._networks)
