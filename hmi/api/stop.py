"""The console's second STOP path: by stop token or session, never limited, never waiting for anything."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, Literal, Protocol

from fastapi import APIRouter, Path, Request
from pydantic import ConfigDict, Field

from hmi.api.access import access_of
from hmi.api.body import Body
from hmi.api.errors import not_found
from hmi.domain.stop_token import StopToken

StopRef = Annotated[str, Field(min_length=8, max_length=64)]


class StopBody(Body):
    """A press; repeats with the same id are harmless. Fields a newer page may add never stand in its way."""

    model_config = ConfigDict(strict=True, extra="ignore", frozen=True)
    stop_id: StopRef
    robots: (
        Annotated[list[Annotated[str, Field(min_length=1, max_length=64)]], Field(min_length=1, max_length=1000)]
        | Literal["all"]
    )


class StopSender(Protocol):
    """Sends STOP to robots by every path the console has."""

    def press(self, stop_id: str, robots: Sequence[str] | str, token: StopToken) -> list[dict[str, Any]]:
        """Send to ``robots`` (or ``"all"``) at once; return the steps, see docs/protocols/stop.md."""
        ...

    def steps(self, stop_id: str | None = None) -> list[dict[str, Any]]:
        """Return the steps of one press."""
        ...


def stop_routes(sender: StopSender) -> APIRouter:
    """Return the routes of STOP."""
    router = APIRouter(prefix="/stop", tags=["stop"])

    @router.post("", status_code=202, summary="STOP (bearer: stop token, or a session)")
    async def stop(body: StopBody, request: Request) -> dict[str, Any]:
        token = access_of(request).presser(request)
        robots = body.robots if isinstance(body.robots, str) else list(dict.fromkeys(body.robots))
        return {"stop_id": body.stop_id, "steps": sender.press(body.stop_id, robots, token)}

    @router.get("/{stop_id}", summary="What became of a press")
    async def steps(stop_id: Annotated[str, Path(max_length=64)], request: Request) -> dict[str, Any]:
        access_of(request).presser(request)
        found = sender.steps(stop_id)
        if not found:
            raise not_found("This press is not known here.")
        return {"stop_id": stop_id, "steps": found}

    return router
