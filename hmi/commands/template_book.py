"""Planning templates for screens and programs: list, save, rename, delete."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from hmi.commands.audit_line import audit_line
from hmi.commands.ports import AuditSink
from hmi.domain.role import Permission
from hmi.security.authorization import Authorize
from hmi.security.session_info import SessionInfo
from hmi.store.database import Database
from hmi.store.templates import PlanTemplate, Templates


class TemplateBook:
    """Answers everything about planning templates; each method asks the person's rights first.

    Raises (every method): ``NotSignedIn``, ``NotAllowed``, ``StoreError``.
    """

    def __init__(self, templates: Templates, database: Database, audit: AuditSink, authorize: Authorize) -> None:
        self._templates, self._database = templates, database
        self._audit, self._authorize = audit, authorize

    async def list(self, session: SessionInfo) -> Sequence[PlanTemplate]:
        """Return the farm's templates by name."""
        self._authorize(session, Permission.WATCH)
        return await self._database.run(self._templates.all, session.farm_id)

    async def save(self, session: SessionInfo, name: str, wish: Mapping[str, Any]) -> PlanTemplate:
        """Keep a wish under a name; raises ``AlreadyExists``."""
        self._authorize(session, Permission.EDIT_MISSION)
        saved = await self._database.run(self._templates.add, session.farm_id, name, wish, session.user_name)
        self._note(session, saved, "saved")
        return saved

    async def rename(self, session: SessionInfo, template_id: str, name: str) -> PlanTemplate:
        """Give a template another name; raises ``NotFound``, ``AlreadyExists``."""
        self._authorize(session, Permission.EDIT_MISSION)
        renamed = await self._database.run(self._templates.rename, session.farm_id, template_id, name)
        self._note(session, renamed, "renamed")
        return renamed

    async def delete(self, session: SessionInfo, template_id: str) -> None:
        """Delete a template; raises ``NotFound``."""
        self._authorize(session, Permission.EDIT_MISSION)
        self._note(session, await self._database.run(self._templates.delete, session.farm_id, template_id), "deleted")

    def _note(self, session: SessionInfo, template: PlanTemplate, outcome: str) -> None:
        self._audit.append(
            audit_line(
                session, "template", outcome, f"Planning template {template.name} {outcome}.", ref=template.id, data={}
            )
        )
