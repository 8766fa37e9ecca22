"""What somebody who looks for a fault needs: counters, queues, clocks, parts."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from fastapi import APIRouter, Request

from hmi.api.access import Diagnostician
from hmi.api.health import Health, is_local
from hmi.clock import Clock

Sources = Mapping[str, Callable[[], Any]]
"""Name -> what returns a part's counters as JSON values; called on the loop, must not block."""


def diagnostics_routes(health: Health, clock: Clock, sources: Sources) -> APIRouter:
    """Return the route of diagnostics."""
    router = APIRouter(tags=["health"])

    @router.get("/diagnostics", summary="Counters of every part")
    async def diagnostics(request: Request, session: Diagnostician) -> dict[str, Any]:
        told = await health.report(with_pids=is_local(request))
        now = {"utc": clock.utc().isoformat(timespec="milliseconds"), "mono_s": round(clock.mono_s(), 3)}
        return {"health": told, "clock": now, **{name: source() for name, source in sources.items()}}

    return router
