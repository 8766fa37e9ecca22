"""Limits and delays of alarm types, as this farm wants them: with a reason, and for priority 1 by two people."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

from hmi.clock import Clock
from hmi.commands.ports import AuditSink
from hmi.commands.refusal import REASON_MISSING, OrderRefused
from hmi.domain.alarm.catalogue import AlarmType
from hmi.domain.alarm.priority import Priority
from hmi.domain.alarm.tuning import BadTuning, Tuning, bounds, most_on_s, shipped, tuned
from hmi.domain.role import Permission
from hmi.security.authorization import Authorize
from hmi.security.session_info import SessionInfo
from hmi.store.alarm_settings import AlarmSettings
from hmi.store.audit_chain import AuditEntry
from hmi.store.database import Database
from hmi.store.errors import NotFound

SETTING = "limits"
SAME_PERSON, NOTHING_ASKED = "same_person", "nothing_asked"
_Kept = dict[str, dict[str, Any]]  # by code of the type
log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class LimitsParts:
    """What the desk needs.

    Args:
        types: what the supervision goes by; changed in place.
        retune: called when a type in it changed.
    """

    types: dict[str, AlarmType]
    retune: Callable[[], None]
    settings: AlarmSettings
    database: Database
    audit: AuditSink
    authorize: Authorize
    clock: Clock


class AlarmLimitsDesk:
    """Every method raises ``NotSignedIn`` and ``NotAllowed`` without the right, ``NotFound`` for an unknown code."""

    def __init__(self, parts: LimitsParts) -> None:
        self._parts, self._catalogue = parts, dict(parts.types)
        self._set: _Kept = {}
        self._asked: _Kept = {}
        self._lock = asyncio.Lock()

    async def load(self) -> None:
        """Read what was set; what does not fit the catalogue any more is left out, and said in the log."""
        parts = self._parts
        stored = await parts.database.run(parts.settings.get, SETTING) or {}
        self._asked = {code: one for code, one in stored.get("asked", {}).items() if code in self._catalogue}
        for code, one in stored.get("set", {}).items():
            try:
                parts.types[code] = tuned(self._catalogue[code], Tuning(**one["values"]))
            except (KeyError, TypeError, BadTuning) as error:
                log.warning("the limit of %s is left as in the catalogue: %s", code, error)
            else:
                self._set[code] = one
        parts.retune()

    def view(self, session: SessionInfo) -> dict[str, Any]:
        """Return every type with what is shipped, what is set and what waits for a second person."""
        self._parts.authorize(session, Permission.MANAGE_ALARMS)
        return {"types": [self._shown(kind, session) for kind in self._catalogue.values()]}

    async def change(self, session: SessionInfo, code: str, values: Tuning | None, reason: str) -> dict[str, Any]:
        """Set a type, ``None``: as shipped. Of priority 1 it waits for a second person.

        Raises:
            BadTuning, OrderRefused: it cannot be used, or there is no reason; nothing was changed.
        """
        kind = self._kind(session, code)
        if not reason.strip():
            raise OrderRefused(REASON_MISSING, "Say why.")
        to = values or shipped(kind)
        tuned(kind, to)
        async with self._lock:
            wish: dict[str, Any] = {
                "values": asdict(to),
                "reason": reason,
                "by": session.user_name,
                "by_id": session.user_id,
                "at": self._parts.clock.utc().isoformat(),
            }
            if kind.priority is Priority.CRITICAL:
                await self._save(session, self._set, {**self._asked, code: wish})
                self._note(session, "asked", code, reason, wish["values"])
            else:
                await self._take(session, kind, wish, "", self._asked)
        return self.view(session)

    async def agree(self, session: SessionInfo, code: str) -> dict[str, Any]:
        """Let what somebody else asked for come true.

        Raises:
            OrderRefused: nothing is asked, or by this same person.
        """
        kind = self._kind(session, code)
        async with self._lock:
            wish = self._wish(code)
            if wish["by_id"] == session.user_id:
                raise OrderRefused(SAME_PERSON, "You asked for it. Another admin has to agree.")
            await self._take(session, kind, wish, session.user_name, _without(self._asked, code))
        return self.view(session)

    async def drop(self, session: SessionInfo, code: str) -> dict[str, Any]:
        """Take back or decline what was asked for. Raises ``OrderRefused`` if nothing is."""
        self._kind(session, code)
        async with self._lock:
            wish = self._wish(code)
            await self._save(session, self._set, _without(self._asked, code))
            self._note(session, "dropped", code, wish["reason"], wish["values"])
        return self.view(session)

    async def _take(
        self, session: SessionInfo, kind: AlarmType, wish: dict[str, Any], second: str, asked: _Kept
    ) -> None:
        to = Tuning(**wish["values"])
        new = tuned(kind, to)
        kept = _without(self._set, kind.code)
        if to != shipped(kind):
            kept[kind.code] = {**wish, "second": second}
        await self._save(session, kept, asked)
        self._parts.types[kind.code] = new
        self._parts.retune()
        told = {**wish["values"], "asked_by": wish["by"]} if second else wish["values"]
        self._note(session, "changed", kind.code, wish["reason"], told)

    async def _save(self, session: SessionInfo, kept: _Kept, asked: _Kept) -> None:
        """Keep these and go by them; what could not be kept is as before, also in what is saved next."""
        parts, stored = self._parts, {"set": kept, "asked": asked}
        await parts.database.run(parts.settings.put, SETTING, stored, session.user_name, parts.clock.utc())
        self._set, self._asked = kept, asked

    def _kind(self, session: SessionInfo, code: str) -> AlarmType:
        self._parts.authorize(session, Permission.MANAGE_ALARMS)
        if code not in self._catalogue:
            raise NotFound(f"there is no alarm {code!r}")
        return self._catalogue[code]

    def _wish(self, code: str) -> dict[str, Any]:
        if code not in self._asked:
            raise OrderRefused(NOTHING_ASKED, "Nothing is asked for here any more.")
        return self._asked[code]

    def _shown(self, kind: AlarmType, session: SessionInfo) -> dict[str, Any]:
        changed, asked = self._set.get(kind.code), self._asked.get(kind.code)
        limit = kind.limit
        return {
            "code": kind.code,
            "title": kind.title,
            "priority": int(kind.priority),
            "unit": kind.unit,
            "shipped": asdict(shipped(kind)),
            "now": asdict(shipped(self._parts.types[kind.code])),
            "most_on_s": most_on_s(kind),
            "bounds": None if limit is None else list(bounds(limit)),
            "changed": None if changed is None else _told(changed),
            "asked": None if asked is None else {**_told(asked), "is_mine": asked["by_id"] == session.user_id},
        }

    def _note(self, session: SessionInfo, outcome: str, code: str, reason: str, data: dict[str, Any]) -> None:
        entry = AuditEntry(session.farm_id, session.user_name, session.device_name, "alarm_limits", outcome,
                           ref=code, text=reason, data=data)  # fmt: skip
        self._parts.audit.append(entry)


def _without(kept: _Kept, code: str) -> _Kept:
    return {other: one for other, one in kept.items() if other != code}


def _told(one: dict[str, Any]) -> dict[str, Any]:
    return {key: one.get(key, "") for key in ("values", "reason", "by", "second", "at")}
