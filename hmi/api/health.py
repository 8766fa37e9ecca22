"""Whether every part of the installation runs; open to everybody, process ids only to this machine."""

from __future__ import annotations

import asyncio
import ipaddress
import json
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fastapi import APIRouter, Request, Response

from hmi.clock import Clock

DATABASE_ASKED_S = 1.0  # a probe a second is enough, however many ask
DATABASE_LIMIT_S = 2.0
_SHOWN = ("state", "url", "restarts", "down_since_utc", "last_down_utc", "last_down")


class KeeperReport:
    """What the process keeper says of the parts, from ``run/keeper.json``; reads blocking, so call it in a thread."""

    def __init__(self, data: Path) -> None:
        self._path = data / "run" / "keeper.json"
        self._known: tuple[tuple[int, int], dict[str, dict[str, Any]]] | None = None

    def parts(self) -> dict[str, dict[str, Any]]:
        """Return part -> its description; empty where no keeper runs."""
        try:
            status = self._path.stat()
            version = (status.st_mtime_ns, status.st_size)
            if self._known is None or self._known[0] != version:
                self._known = version, _read(self._path)
            return self._known[1]
        except ValueError:  # caught while it is written over, on a disk that is full
            return self._known[1] if self._known is not None else {}
        except OSError:
            return {}


@dataclass(frozen=True, slots=True)
class HealthRoutes:
    """What health needs.

    Args:
        broker: state of the console's broker connection (``up`` or anything else) and the broker's address.
        is_database_reachable: blocking probe, called in a thread.
        extra: further parts, name -> description with ``state``.
    """

    version: str
    keeper: KeeperReport
    clock: Clock
    broker: Callable[[], tuple[str, str]]
    is_database_reachable: Callable[[], bool]
    extra: Callable[[], Mapping[str, Mapping[str, Any]]] = dict


class Health:
    """Collects the state of all parts without ever holding up the loop."""

    def __init__(self, parts: HealthRoutes) -> None:
        self._parts = parts
        self._database = "unknown"
        self._asked_s = float("-inf")
        self._probe: asyncio.Task[None] | None = None

    async def report(self, *, with_pids: bool) -> dict[str, Any]:
        """Return status, version and parts."""
        kept = await asyncio.to_thread(self._parts.keeper.parts)
        await self._ask_database()
        state, url = self._parts.broker()
        found: dict[str, dict[str, Any]] = {name: dict(entry) for name, entry in kept.items()}
        found["console"] = {**found.get("console", {}), "state": "ok", "pid": os.getpid()}
        broker = found.get("broker", {})
        found["broker"] = {**broker, "state": "ok" if state == "up" else "down", "url": url}
        found["database"] = {"state": self._database}
        found.update({name: dict(entry) for name, entry in self._parts.extra().items()})
        shown = (*_SHOWN, "pid") if with_pids else _SHOWN
        return {
            "status": _status(found),
            "version": self._parts.version,
            "parts": {n: {k: v for k, v in e.items() if k in shown} for n, e in found.items()},
        }

    async def _ask_database(self) -> None:
        now_s = self._parts.clock.mono_s()
        if self._probe is None and now_s - self._asked_s >= DATABASE_ASKED_S:
            self._asked_s = now_s
            self._probe = asyncio.create_task(self._ask(), name="health-database")
        if self._probe is not None:
            done, _ = await asyncio.wait({self._probe}, timeout=DATABASE_LIMIT_S)
            if not done:
                self._database = "slow"

    async def _ask(self) -> None:
        try:
            is_reachable = await asyncio.to_thread(self._parts.is_database_reachable)
            self._database = "ok" if is_reachable else "down"
        finally:
            self._probe = None


def health_routes(health: Health) -> APIRouter:
    """Return the route of health."""
    router = APIRouter(tags=["health"])

    @router.get("/health", summary="Parts and their states (no login)")
    async def report(request: Request, response: Response) -> dict[str, Any]:
        answer = await health.report(with_pids=is_local(request))
        response.headers["cache-control"] = "no-store"
        if answer["status"] == "failed":
            response.status_code = 503
        return answer

    return router


def is_local(request: Request) -> bool:
    """Say whether the caller is on this machine, and not behind a proxy that is."""
    if request.client is None or "x-forwarded-for" in request.headers or "forwarded" in request.headers:
        return False
    try:
        return ipaddress.ip_address(request.client.host).is_loopback
    except ValueError:
        return False


LATER = ("media", "cameras", "context_broker")


def _status(parts: Mapping[str, Mapping[str, Any]]) -> str:
    states = {name: entry.get("state") for name, entry in parts.items() if not _is_on_its_way(name, entry)}
    if states.get("broker") != "ok" and states.get("stop", "ok") != "ok":
        return "failed"  # neither commands nor STOP reach a robot by the broker
    return "ok" if all(state == "ok" for state in states.values()) else "degraded"


def _is_on_its_way(name: str, entry: Mapping[str, Any]) -> bool:
    """What nobody waits for starts when everything else serves already."""
    return name in LATER and entry.get("state") in ("stopped", "starting") and not entry.get("restarts")


def _read(path: Path) -> dict[str, dict[str, Any]]:
    content = json.loads(path.read_text(encoding="utf-8"))
    parts = content.get("parts") if isinstance(content, dict) else None
    if not isinstance(parts, dict):
        return {}
    return {str(name): entry for name, entry in parts.items() if isinstance(entry, dict)}
