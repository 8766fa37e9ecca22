"""The link to the cloud over REST: how it is, and the one decision a person has to take."""

from __future__ import annotations

from collections.abc import Awaitable
from typing import Annotated, Any, Protocol

from fastapi import APIRouter, Path

from hmi.api.access import Diagnostician, SignedIn, UserManager, Watcher
from hmi.api.body import Body, Ref
from hmi.api.errors import ApiError
from hmi.api.map_answers import step_json, tried
from hmi.commands.map_proposals import MapProposals
from hmi.security.session_info import SessionInfo

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

    async def send_refused(self, session: SessionInfo) -> None:
        """Send what the cloud refused once more; raises ``CloudRefused``."""
        ...

    async def forget_refused(self, session: SessionInfo) -> None:
        """Forget the records that the cloud refused; raises ``CloudRefused``."""
        ...

    def proposals(self) -> list[dict[str, Any]]:
        """Return what the cloud wants changed on the map."""
        ...


def proposal_routes(desk: CloudDesk, proposals: MapProposals) -> APIRouter:
    """Return the routes of changes that the cloud asks for."""
    router = APIRouter(tags=["map"])

    @router.get("/map/proposals", summary="What the cloud wants changed on the map")
    async def listed(session: Watcher) -> Any:
        def rows(editors: dict[str, str]) -> dict[str, Any]:
            return {"proposals": [{**one, "in_draft_by": editors.get(one["id"], "")} for one in desk.proposals()]}

        return await tried(lambda: proposals.in_draft(session), rows)

    @router.post("/map/proposals/{proposal_id}/take", summary="Put a change from the cloud into your draft")
    async def take(proposal_id: ProposalId, body: TakeBody, session: SignedIn) -> Any:
        return await tried(lambda: proposals.take(session, proposal_id, body.id), lambda r: step_json(r, session))

    @router.post("/map/proposals/{proposal_id}/refuse", status_code=204, summary="Refuse a change from the cloud")
    async def refuse(proposal_id: ProposalId, session: SignedIn) -> None:
        await tried(lambda: proposals.refuse(session, proposal_id), lambda _: None)

    return router


def cloud_routes(desk: CloudDesk) -> APIRouter:
    """Return the routes."""
    router = APIRouter(prefix="/cloud", tags=["cloud"])

    @router.get("", summary="The link to the cloud: state, what waits, delays, counts")
    async def report(session: Diagnostician) -> dict[str, Any]:
        return desk.report()

    async def done(act: Awaitable[None]) -> dict[str, Any]:
        try:
            await act
        except CloudRefused as error:
            raise ApiError(409, "cloud", f"{error}") from error
        return desk.report()

    @router.post("/tenant", summary="Keep this farm in this tenant from now on, whoever did before")
    async def take(session: UserManager) -> dict[str, Any]:
        return await done(desk.take_tenant(session))

    @router.post("/refused/send", summary="Send once more what the cloud refused")
    async def send(session: UserManager) -> dict[str, Any]:
        return await done(desk.send_refused(session))

    @router.delete("/refused", summary="Forget the records that the cloud refused")
    async def forget(session: UserManager) -> dict[str, Any]:
        return await done(desk.forget_refused(session))

    return router
