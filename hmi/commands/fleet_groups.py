"""Groups of robots and saved views, for screens and programs; each method asks the person's rights first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from hmi.commands.ports import AuditSink, LaneEvent
from hmi.domain.role import Permission
from hmi.security.authorization import Authorize
from hmi.security.session_info import SessionInfo
from hmi.store.audit_chain import AuditEntry
from hmi.store.database import Database
from hmi.store.fleet_groups import FleetGroup, FleetGroups, FleetView


class FleetGroupBook:
    """Raises (every method): ``NotSignedIn``, ``NotAllowed``, ``StoreError``."""

    def __init__(
        self, groups: FleetGroups, database: Database, audit: AuditSink, authorize: Authorize, on_event: LaneEvent
    ) -> None:
        self._groups, self._database = groups, database
        self._audit, self._authorize, self._on_event = audit, authorize, on_event

    async def groups(self, session: SessionInfo) -> Sequence[FleetGroup]:
        """Return the farm's groups by name."""
        self._authorize(session, Permission.WATCH)
        return await self._database.run(self._groups.groups, session.farm_id)

    async def add(self, session: SessionInfo, name: str, robots: Sequence[str]) -> FleetGroup:
        """Keep a group; raises ``AlreadyExists``."""
        self._authorize(session, Permission.PAUSE)
        made = await self._database.run(self._groups.add_group, session.farm_id, name, robots, session.user_name)
        self._note(session, made, "saved")
        return made

    async def change(self, session: SessionInfo, group_id: str, name: str, robots: Sequence[str]) -> FleetGroup:
        """Replace name and robots of a group; raises ``NotFound``, ``AlreadyExists``."""
        self._authorize(session, Permission.PAUSE)
        made = await self._database.run(
            self._groups.change_group, session.farm_id, group_id, name, robots, session.user_name
        )
        self._note(session, made, "changed")
        return made

    async def remove(self, session: SessionInfo, group_id: str) -> None:
        """Delete a group; raises ``NotFound``."""
        self._authorize(session, Permission.PAUSE)
        gone = await self._database.run(self._groups.remove_group, session.farm_id, group_id)
        self._note(session, gone, "deleted")

    async def views(self, session: SessionInfo) -> Sequence[FleetView]:
        """Return the person's own views by name."""
        self._authorize(session, Permission.WATCH)
        return await self._database.run(self._groups.views, session.farm_id, session.user_id)

    async def save_view(self, session: SessionInfo, name: str, filter_: Mapping[str, Any]) -> FleetView:
        """Keep a view for this person; one of the same name is replaced."""
        self._authorize(session, Permission.WATCH)
        return await self._database.run(
            self._groups.save_view, session.farm_id, session.user_id, name, filter_
        )  # fmt: skip

    async def remove_view(self, session: SessionInfo, view_id: str) -> None:
        """Delete one of the person's own views; raises ``NotFound``."""
        self._authorize(session, Permission.WATCH)
        await self._database.run(self._groups.remove_view, session.farm_id, session.user_id, view_id)

    def _note(self, session: SessionInfo, group: FleetGroup, outcome: str) -> None:
        text = f"Group {group.name} of {len(group.robots)} robots {outcome}."
        self._audit.append(
            AuditEntry(session.farm_id, session.user_name, session.device_name, "fleet", outcome, None, group.id, text)
        )
        self._on_event({"kind": "fleet", "what": "groups", "by": session.user_name})
