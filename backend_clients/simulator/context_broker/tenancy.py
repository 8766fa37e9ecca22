"""Which tenant and which service paths a request speaks of."""

from __future__ import annotations

import re
from dataclasses import dataclass

from starlette.datastructures import Headers

from backend_clients.simulator.context_broker.refusal import bad_request

MAX_TENANT = 50
MAX_LEVELS = 10
MAX_LEVEL = 50
MAX_PATHS = 10


@dataclass(frozen=True, slots=True)
class Scope:
    """A tenant, and the service paths as the header gave them; no paths means no header."""

    tenant: str
    paths: tuple[str, ...]

    def sees(self, path: str) -> bool:
        """Say whether a read sees an entity at ``path``; without a header it sees all."""
        return not self.paths or any(_covers(pattern, path) for pattern in self.paths)

    def write_path(self) -> str:
        """Return where a write goes; without a header it is the root."""
        if len(self.paths) > 1:
            raise bad_request("more than one service path in context update request")
        path = self.paths[0] if self.paths else "/"
        if "#" in path:
            raise bad_request("Bad Character in Service-Path")
        return path

    def for_writing(self) -> Scope:
        """Return the scope that sees only where a write goes."""
        return Scope(self.tenant, (self.write_path(),))


def scope_of(headers: Headers) -> Scope:
    """Return the scope of a request, or refuse its headers."""
    given = headers.get("fiware-servicepath", "")
    parts = [part.strip() for part in given.split(",")] if given else []
    if len(parts) > MAX_PATHS:
        raise bad_request("too many service paths - a maximum of ten service paths is allowed")
    return Scope(_tenant(headers.get("fiware-service", "")), tuple(_path(part) for part in parts))


def _tenant(given: str) -> str:
    if len(given) > MAX_TENANT:
        raise bad_request("bad length - a tenant name can be max 50 characters long")
    if not re.fullmatch(r"[A-Za-z0-9_]*", given):
        raise bad_request("bad character in tenant name - only underscore and alphanumeric characters are allowed")
    return given.lower()


def _path(given: str) -> str:
    if not given.startswith("/"):
        raise bad_request("Only /absolute/ Service Paths allowed [a service path must begin with /]")
    levels = given.rstrip("/").split("/")[1:]
    if len(levels) > MAX_LEVELS:
        raise bad_request("too many components in ServicePath")
    for place, level in enumerate(levels):
        if not level:
            raise bad_request("empty component in ServicePath")
        if len(level) > MAX_LEVEL:
            raise bad_request("component-name too long in ServicePath")
        is_last_hash = level == "#" and place == len(levels) - 1
        if not is_last_hash and not re.fullmatch(r"[A-Za-z0-9_]+", level):
            raise bad_request("a component of ServicePath contains an illegal character")
    return "/" + "/".join(levels)


def _covers(pattern: str, path: str) -> bool:
    if not pattern.endswith("#"):
        return pattern == path
    above = pattern[:-1].rstrip("/")
    return path == above or path.startswith(above + "/") or not above
