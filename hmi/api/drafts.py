"""Drafts of missions: kept before they can be planned."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter
from pydantic import Field

from hmi.api.access import SignedIn
from hmi.api.body import Body, Name
from hmi.api.missions import MissionId, row, translated
from hmi.api.plan_body import DraftWish
from hmi.commands.draft_book import DraftBook


class DraftBody(Body):
    """A draft to keep."""

    name: Name
    wish: DraftWish


class DraftChange(DraftBody):
    """A draft as it shall be; ``revision`` is that of the draft which was opened."""

    revision: Annotated[int, Field(ge=1)]


def draft_routes(book: DraftBook) -> APIRouter:
    """Return the routes of drafts; everything else of them is as of missions."""
    router = APIRouter(tags=["missions"])

    @router.post("/missions/drafts", status_code=201, summary="Keep a mission that is not planned yet")
    async def keep(body: DraftBody, session: SignedIn) -> dict[str, Any]:
        return row(await book.keep(session, body.name, _wish(body.wish)))

    @router.put("/missions/{mission_id}/draft", summary="Keep other choices of a draft")
    async def save(mission_id: MissionId, body: DraftChange, session: SignedIn) -> dict[str, Any]:
        wish = _wish(body.wish)
        return row(await translated(lambda: book.save(session, mission_id, body.revision, body.name, wish)))

    return router


def _wish(wish: DraftWish) -> dict[str, Any]:
    return wish.model_dump(mode="json", exclude_unset=True, exclude={"name"})
