"""The link to the cloud over REST: how it is, and the one decision a person has to take."""

from __future__ import annotations

from typing import Annotated, Any, Protocol

from fastapi import APIRouter, Path, Request, Response
from starlette.requests import ClientDisconnect

from hmi.api.access import Diagnostician, SignedIn, UserManager, Watcher
from hmi.api.body import Body, Ref
from hmi.api.errors import ApiError
from hmi.api.map_answers import step_json, tried
from hmi.commands.map_proposals import MapProposals
from hmi.security.session_info import SessionInfo

MOST_BYTES = 1_048_576
ProposalId = Annotated[str, Path(max_length=64)]


class TakeBody(Body):
    """The editor's own id of the step."""

    id: Ref


class CloudRefused(Exception):
    """It cannot be done now; the text says why, for a person."""


class CloudDesk(Protocol):
    """Knows how the link is."""

    def report(self) -> dict[str, Any]:
        """Return everything the panel shows."""
        ...

    async def take_tenant(self, session: SessionInfo) -> None:
        """Keep this farm in this tenant from now on; raises ``CloudRefused``."""
        ...

    def proposals(self) -> list[dict[str, Any]]:
        """Return what the cloud wants changed on the map."""
        ...

    def lets_in(self, secret: str, source: str) -> bool:
        """Say whether a notification with this secret, from this address, is the broker's."""
        ...

    def hint(self, body: bytes, headers: dict[str, str]) -> bool:
        """Take a notification that was let in; ``False`` if it cannot be read or is of another tenant."""
        ...


def proposal_routes(desk: CloudDesk, proposals: MapProposals) -> APIRouter:
    """Return the routes of changes that the cloud asks for, and where the broker posts."""
    router = APIRouter(tags=["map"])

    @router.get("/map/proposals", summary="What the cloud wants changed on the map")
    async def listed(session: Watcher) -> dict[str, Any]:
        return {"proposals": desk.proposals()}

    @router.post("/map/proposals/{proposal_id}/take", summary="Put a change from the cloud into your draft")
    async def take(proposal_id: ProposalId, body: TakeBody, session: SignedIn) -> Any:
        return await tried(lambda: proposals.take(session, proposal_id, body.id), lambda r: step_json(r, session))

    @router.post("/map/proposals/{proposal_id}/refuse", status_code=204, summary="Refuse a change from the cloud")
    async def refuse(proposal_id: ProposalId, session: SignedIn) -> None:
        await tried(lambda: proposals.refuse(session, proposal_id), lambda _: None)

    @router.post("/cloud/notify/{secret}", status_code=204, include_in_schema=False)
    async def notify(secret: str, request: Request) -> Response:
        source = request.client.host if request.client is not None else ""
        if not desk.lets_in(secret, source):
            return Response(status_code=404)  # before anything is read
        body = bytearray()
        try:
            async for part in request.stream():
                body += part
                if len(body) > MOST_BYTES:
                    return Response(status_code=413)
        except ClientDisconnect:
            return Response(status_code=400)
        headers = {key.decode("latin-1").lower(): value.decode("latin-1") for key, value in request.scope["headers"]}
        return Response(status_code=204 if desk.hint(bytes(body), headers) else 400)

    return router


def cloud_routes(desk: CloudDesk) -> APIRouter:
    """Return the routes."""
    router = APIRouter(prefix="/cloud", tags=["cloud"])

    @router.get("", summary="The link to the cloud: state, what waits, delays, counts")
    async def report(session: Diagnostician) -> dict[str, Any]:
        return desk.report()

    @router.post("/tenant", summary="Keep this farm in this tenant from now on, whoever did before")
    async def take(session: UserManager) -> dict[str, Any]:
        try:
            await desk.take_tenant(session)
        except CloudRefused as error:
            raise ApiError(409, "cloud", f"{error}") from error
        return desk.report()

    return router
