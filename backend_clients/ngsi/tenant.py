"""Tenant and service path, as headers."""

from __future__ import annotations

import re
from dataclasses import dataclass

from backend_clients.ngsi.errors import BadInput

MAX_SERVICE = 50
MAX_LEVELS = 10
_SERVICE = re.compile(r"[a-z0-9_]{0,50}", re.ASCII)
_PATH = re.compile(r"/|(/[A-Za-z0-9_]{1,50}){1,10}", re.ASCII)


@dataclass(frozen=True, slots=True)
class Tenant:
    """Where entities live in a broker that serves many.

    Args:
        service: lower case letters, digits and underscores, at most 50; empty is the default tenant.
        path: e.g. ``/farm/north``, at most ten levels. Entities are written there and read there alone.

    Raises:
        BadInput: the broker would refuse it, or fold it into another name.
    """

    service: str = ""
    path: str = "/"

    def __post_init__(self) -> None:
        if not _SERVICE.fullmatch(self.service):
            raise BadInput(f"not a tenant (a-z, 0-9, _, at most {MAX_SERVICE}): {self.service[:80]!r}")
        if not _PATH.fullmatch(self.path):
            raise BadInput(f"not a service path (/level/level, at most {MAX_LEVELS}): {self.path[:80]!r}")

    def headers(self) -> dict[str, str]:
        """Return the headers of every request; the path is always named, since its default differs by method."""
        service = {"Fiware-Service": self.service} if self.service else {}
        return {**service, "Fiware-ServicePath": self.path}
