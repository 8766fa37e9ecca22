"""Planning templates: what is planned again and again, kept under a name."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Path

from hmi.api.access import SignedIn, Watcher
from hmi.api.body import Body, Name
from hmi.api.plan_body import TemplateWish
from hmi.commands.template_book import TemplateBook
from hmi.store.templates import PlanTemplate

TemplateId = Annotated[str, Path(max_length=64)]


class TemplateBody(Body):
    """A template to keep."""

    name: Name
    wish: TemplateWish


class TemplateName(Body):
    """A new name."""

    name: Name


def template_routes(book: TemplateBook) -> APIRouter:
    """Return the routes of planning templates."""
    router = APIRouter(tags=["missions"])

    @router.get("/plan-templates", summary="Planning templates by name")
    async def templates(session: Watcher) -> dict[str, Any]:
        return {"templates": [_row(one) for one in await book.list(session)]}

    @router.post("/plan-templates", status_code=201, summary="Keep choices for planning under a name")
    async def save(body: TemplateBody, session: SignedIn) -> dict[str, Any]:
        return _row(await book.save(session, body.name, body.wish.model_dump(mode="json", exclude_unset=True)))

    @router.patch("/plan-templates/{template_id}", summary="Rename a planning template")
    async def rename(template_id: TemplateId, body: TemplateName, session: SignedIn) -> dict[str, Any]:
        return _row(await book.rename(session, template_id, body.name))

    @router.delete("/plan-templates/{template_id}", status_code=204, summary="Delete a planning template")
    async def delete(template_id: TemplateId, session: SignedIn) -> None:
        await book.delete(session, template_id)

    return router


def _row(template: PlanTemplate) -> dict[str, Any]:
    return {
        "id": template.id,
        "name": template.name,
        "wish": template.wish,
        "created_by": template.created_by,
        "created_utc": template.created_at.isoformat(timespec="milliseconds"),
    }
