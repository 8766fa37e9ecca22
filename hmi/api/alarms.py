"""Alarms: what is wrong, what to do about it, and who has seen it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Path, Query
from pydantic import Field, model_validator

from hmi.api.access import SignedIn, Watcher
from hmi.api.body import Body, Reason
from hmi.clock import Clock
from hmi.commands.alarm_desk import AlarmDesk
from hmi.domain.alarm.alarm import AlarmState
from hmi.domain.alarm.catalogue import catalogue
from hmi.domain.alarm.life import MAX_SHELF
from hmi.domain.alarm.live_alarm import LiveAlarm
from hmi.presenters.alarms import entry, epoch_ms, words
from hmi.store.alarms import AlarmStore

ID = r"^[a-z0-9][a-z0-9._-]{0,180}\z"
AlarmId = Annotated[str, Path(pattern=ID)]
MAX_SHELF_MIN = int(MAX_SHELF.total_seconds() // 60)
_ASIDE = (AlarmState.SHELVED, AlarmState.SUPPRESSED, AlarmState.OUT_OF_SERVICE)


class Ids(Body):
    """Which alarms."""

    ids: Annotated[list[Annotated[str, Field(pattern=ID)]], Field(min_length=1, max_length=500)]


class ShelveBody(Body):
    """How long, and why."""

    minutes: Annotated[int, Field(ge=1, le=MAX_SHELF_MIN)] | None = None
    until_shift_end: bool = False
    reason: Reason

    @model_validator(mode="after")
    def _one_of_both(self) -> ShelveBody:
        if (self.minutes is None) == (not self.until_shift_end):
            raise ValueError("give minutes or until_shift_end, one of them")
        return self


class ReasonBody(Body):
    """Why."""

    reason: Reason


@dataclass(frozen=True, slots=True)
class AlarmRoutes:
    """What the routes need.

    Args:
        name_of: what people call a source.
    """

    store: AlarmStore
    desk: AlarmDesk
    clock: Clock
    name_of: Callable[[str], str]


def alarm_routes(parts: AlarmRoutes) -> APIRouter:
    """Return the routes of live alarms."""
    router = APIRouter(tags=["alarms"])

    def shown(live: LiveAlarm) -> dict[str, Any]:
        return {"id": live.id, **entry(live, parts.name_of(live.alarm.key.source))}

    @router.get("/alarms", summary="Alarms, oldest first")
    async def listed(
        _session: Watcher, state: Literal["active", "shelved", "all"] = "all",
        robot: Annotated[str | None, Query(max_length=64)] = None,
    ) -> dict[str, Any]:  # fmt: skip
        found = [one for one in parts.store.all() if robot in (None, one.alarm.key.source) and _is_in(one, state)]
        return {"alarms": [shown(one) for one in found], "server_time": epoch_ms(parts.clock.utc())}

    @router.get("/alarms/catalogue", summary="Every alarm type there is")
    async def types(_session: Watcher) -> dict[str, Any]:
        return {"types": [words(one) for one in catalogue().values()]}

    @router.post("/alarms/acknowledge", summary="Say that these were seen")
    async def acknowledge_all(body: Ids, session: SignedIn) -> dict[str, Any]:
        done = parts.desk.acknowledge_all(session, body.ids)
        return {"results": [{"id": one.id, "code": one.code, "text": one.text} for one in done]}

    @router.post("/alarms/{alarm_id}/acknowledge", summary="Say that it was seen; moves and resets nothing")
    async def acknowledge(alarm_id: AlarmId, session: SignedIn) -> dict[str, Any]:
        return shown(parts.desk.acknowledge(session, alarm_id))

    @router.post("/alarms/{alarm_id}/clear", summary="End one whose condition is gone")
    async def clear(alarm_id: AlarmId, session: SignedIn) -> dict[str, Any]:
        return shown(parts.desk.clear(session, alarm_id))

    @router.post("/alarms/{alarm_id}/shelve", summary="Put it aside for a while")
    async def shelve(alarm_id: AlarmId, body: ShelveBody, session: SignedIn) -> dict[str, Any]:
        return shown(parts.desk.shelve(session, alarm_id, body.reason, body.minutes))

    @router.post("/alarms/{alarm_id}/unshelve", summary="Bring it back before its time")
    async def unshelve(alarm_id: AlarmId, session: SignedIn) -> dict[str, Any]:
        return shown(parts.desk.unshelve(session, alarm_id))

    @router.post("/alarms/{alarm_id}/out-of-service", summary="Take it out of service")
    async def take_out(alarm_id: AlarmId, body: ReasonBody, session: SignedIn) -> dict[str, Any]:
        return shown(parts.desk.take_out(session, alarm_id, body.reason))

    @router.post("/alarms/{alarm_id}/in-service", summary="Put it back into service")
    async def put_back(alarm_id: AlarmId, session: SignedIn) -> dict[str, Any]:
        return shown(parts.desk.put_back(session, alarm_id))

    return router


def _is_in(live: LiveAlarm, state: str) -> bool:
    is_aside = live.alarm.state in _ASIDE
    return state == "all" or is_aside == (state == "shelved")
