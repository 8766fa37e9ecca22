"""Drafts of missions for screens and programs: kept before they can be planned, for everybody who plans."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hmi.clock import Clock
from hmi.commands.audit_line import audit_line
from hmi.commands.ports import AuditSink
from hmi.domain.ids import new_id
from hmi.domain.mission import MissionStatus
from hmi.domain.role import Permission
from hmi.mapping.attributes import LONGEST_NAME
from hmi.security.authorization import Authorize
from hmi.security.session_info import SessionInfo
from hmi.store.database import Database
from hmi.store.errors import NotFound
from hmi.store.features import Features
from hmi.store.mission_drafts import MissionDrafts, with_wish
from hmi.store.missions import Mission, Missions

KEPT = "Kept as a draft."


class DraftBook:
    """Keeps drafts; renaming, copying and deleting is the mission book's, planning too.

    Raises (every method): ``NotSignedIn``, ``NotAllowed``, ``StoreError``.
    """

    def __init__(
        self,
        missions: Missions,
        features: Features,
        database: Database,
        audit: AuditSink,
        authorize: Authorize,
        clock: Clock,
    ) -> None:
        self._missions, self._features, self._database, self._clock = missions, features, database, clock
        self._drafts = MissionDrafts(missions)
        self._audit, self._authorize = audit, authorize

    async def keep(self, session: SessionInfo, name: str, wish: Mapping[str, Any]) -> Mission:
        """Keep a new draft. ``wish`` is what a planning request carries, as far as it was chosen."""
        self._authorize(session, Permission.EDIT_MISSION, wish.get("robot_id"))
        now = self._clock.utc()
        empty = Mission(
            id=f"m-{new_id()[:12]}",
            farm_id=session.farm_id,
            name=name,
            field_name="",
            status=MissionStatus.DRAFT,
            sha256="",
            created_by=session.user_name,
            created_at=now,
            updated_at=now,
        )
        draft = with_wish(empty, wish, await self._field_name(session.farm_id, wish))
        kept = await self._database.run(self._missions.add, draft, {}, KEPT)
        self._note(session, kept, "kept as a draft")
        return kept

    async def save(
        self, session: SessionInfo, mission_id: str, revision: int, name: str, wish: Mapping[str, Any]
    ) -> Mission:
        """Keep other choices of a draft.

        Raises:
            NotFound: there is no such mission.
            MissionRefused: it is no draft any more, or somebody else saved it since ``revision`` was opened.
        """
        self._authorize(session, Permission.EDIT_MISSION, wish.get("robot_id"))
        field_name = await self._field_name(session.farm_id, wish)
        saved = await self._database.run(
            self._drafts.save, session.farm_id, mission_id, revision, name, wish, field_name, session.user_name
        )
        self._note(session, saved, "saved as a draft")
        return saved

    async def _field_name(self, farm_id: str, wish: Mapping[str, Any]) -> str:
        """Return what people call the field, empty if none was chosen or it is not on the map any more."""
        if not wish.get("field_id"):
            return ""
        try:
            field = await self._database.run(self._features.get, farm_id, wish["field_id"])
        except NotFound:
            return ""
        return field.title[:LONGEST_NAME]

    def _note(self, session: SessionInfo, mission: Mission, outcome: str) -> None:
        text = f"{mission.name} {outcome}."
        self._audit.append(
            audit_line(session, "mission", "draft", text, ref=mission.id, robot_id=mission.robot_id, data={})
        )
