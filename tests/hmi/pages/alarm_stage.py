"""Alarms on the stage: entries that a test sets, and the answers of their REST."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from fastapi import APIRouter, Request
from fastapi.responses import JSONResponse, PlainTextResponse

TYPE = {
    "title": "No data link",
    "cause": "Nothing was heard of the robot for 3.5 s.",
    "consequence": "You do not see what it does.",
    "steps": ["Look before you walk up to it", "Check the radio at the field"],
    "who": "operator",
    "follows_from": [],
    "has_diagnosis": True,
}
STATISTICS: dict[str, Any] = {
    "last_10min": 6, "unacknowledged": 2, "oldest_unacknowledged_s": 9, "standing_24h": 0, "shelved": 0,
    "next_return": None, "mix_7d": {"1": 0.01, "2": 0.03, "3": 0.13, "4": 0.83}, "answer_median_s": 38.0,
    "top": [{"code": "rtk-float", "title": "Position not exact", "count": 41},
            {"code": "link-lost", "title": "No data link", "count": 12}],
    "raised_7d": 82, "stale": 0, "chattering": 0, "per_operator_hour": 4.2, "flood_share": 0.004,
}  # fmt: skip
CHECK = {
    "steps": [
        {"text": "Is the broker reached?", "found": "Yes, 4 ms.", "ok": True},
        {"text": "Was it heard in the last minute?", "found": "No, 12 s ago.", "ok": False},
        {"text": "Does its HTTP answer?", "found": "No address is known.", "ok": None},
    ],
    "conclusion": "The robot's radio is silent, others are heard.",
}
HEALTH = {"waiting": 0, "sent": 0, "failed": 0, "dropped": 0, "last_error": "", "last_sent": None}
PEOPLE = {"operator": "Martha Keller", "supervisor": "Anna Ostermeier", "admin": "Jonas Weber"}


def entry(alarm_id: str, now_s: float, **changes: Any) -> dict[str, Any]:
    """Return an alarm as the lane carries it; ``ago_s`` says how long ago it was raised."""
    code, source = alarm_id.split(".")[:2]
    ago_s = changes.pop("ago_s", 9.0)
    usual = {
        "code": code, "source": source, "detail": "", "name": source.replace("-", " ").title(),
        "title": "No data link", "text": "Nothing heard for 9 s.", "priority": 2, "state": "unacknowledged",
        "raised": round((time.time() - ago_s) * 1000), "t": round((now_s - ago_s) * 1000, 1), "returned": None,
        "seen_by": "", "seen_at": None, "who": "operator", "latching": False, "first": alarm_id, "place": 1,
        "group": 1, "shelf": None, "out_of_service": None, "occurrences": 1, "chattering": False, "escalated": None,
    }  # fmt: skip
    return {**usual, **changes}


class AlarmStage:
    """The alarms on stage; what the hub asks of a supervision."""

    def __init__(self, now_s: Callable[[], float], tell: Callable[[dict[str, Any]], None]) -> None:
        self._now_s, self._tell = now_s, tell
        self.clear()
        self._revisions: dict[str, int] = {}
        self.revision = 0

    def clear(self) -> None:
        """Begin with none."""
        for alarm_id in list(getattr(self, "entries", {})):
            self.put(alarm_id, None)
        self.entries: dict[str, dict[str, Any]] = {}
        self.flood: dict[str, Any] | None = None
        self.old_s = 0.0
        self.refusal = ""
        self.journal: list[dict[str, Any]] = []
        self.channels: list[dict[str, Any]] = []
        self.saved = 0  # how often the channels were

    def put(self, alarm_id: str, one: dict[str, Any] | None) -> None:
        """Set an entry, ``None`` when it is normal again."""
        self.revision += 1
        self._revisions[alarm_id] = self.revision
        if one is None:
            self.entries.pop(alarm_id, None)
        else:
            self.entries[alarm_id] = one

    def entries_since(self, revision: int) -> dict[str, dict[str, Any] | None]:
        """Return what changed after a revision."""
        return {i: self.entries.get(i) for i, changed in self._revisions.items() if changed > revision}

    def summary(self) -> dict[str, Any]:
        """Return counts, flood and when the supervision last looked."""
        return {
            "counts": {str(level): self._count(level) for level in (1, 2, 3, 4)},
            "flood": self.flood,
            "checked": round((self._now_s() - self.old_s) * 1000),
        }

    def _count(self, level: int) -> list[int]:
        active = [
            one
            for one in self.entries.values()
            if one["priority"] == level and one["state"] in ("unacknowledged", "acknowledged", "returned", "latched")
        ]
        return [len(active), sum(one["state"] in ("unacknowledged", "returned") for one in active)]

    def wish(self, wish: dict[str, Any]) -> None:
        """Do what a test asks: ``put`` entries, ``drop`` ids, ``tell`` an event, or set flood, age or refusal."""
        if wish.pop("anew", False):
            self.clear()
        for alarm_id, changes in wish.pop("put", {}).items():
            self.put(alarm_id, entry(alarm_id, self._now_s(), **changes))
        for alarm_id in wish.pop("drop", []):
            self.put(alarm_id, None)
        for event in wish.pop("tell", []):
            self._tell({"kind": "alarm", **event})
        for name, value in wish.items():
            setattr(self, name, value)

    def act(self, alarm_id: str, verb: str, body: dict[str, Any], by: str) -> dict[str, Any]:
        """Move an alarm on, as the console would."""
        one = self.entries.get(alarm_id)
        if one is None or self.refusal:
            return {"code": "refused", "text": self.refusal or "It is normal again."}
        now_ms = round(time.time() * 1000)
        changes: dict[str, dict[str, Any] | None] = {
            "acknowledge": {"state": "acknowledged", "seen_by": by, "seen_at": now_ms},
            "clear": None,
            "shelve": {
                "state": "shelved",
                "shelf": {"by": by, "reason": body.get("reason", ""), "until": now_ms + 3_600_000},
            },
            "unshelve": {"state": "unacknowledged", "shelf": None},
            "out-of-service": {
                "state": "out_of_service",
                "out_of_service": {"by": by, "reason": body.get("reason", ""), "at": now_ms},
            },
            "in-service": {"state": "unacknowledged", "out_of_service": None},
        }
        change = changes[verb]
        self.put(alarm_id, None if change is None or one["state"] == "returned" else {**one, **change})
        return {"code": "ok", "text": ""}


def router(stage: AlarmStage, note: Callable[[dict[str, Any]], None]) -> APIRouter:
    """Return the REST of alarms and the door for tests; ``note`` hears every order."""
    routes = APIRouter()

    def who(request: Request) -> str:
        role = request.cookies.get("stage", "")
        return PEOPLE.get(role, role)

    @routes.post("/stage-alarms")
    async def wish(request: Request) -> dict[str, Any]:
        stage.wish(await request.json())
        return {}

    @routes.get("/api/v1/alarms")
    async def alarms() -> dict[str, Any]:
        return {"alarms": [{"id": i, **one} for i, one in stage.entries.items()]}

    @routes.get("/api/v1/alarms/catalogue")
    async def catalogue() -> dict[str, Any]:
        return {"types": [{"code": "link-lost", "priority": 2, **TYPE}]}

    @routes.get("/api/v1/alarms/statistics")
    async def statistics() -> dict[str, Any]:
        now_ms = round(time.time() * 1000)
        bars = [{"at": now_ms - (47 - i) * 600_000, "count": (12 if i == 40 else i % 7 == 0)} for i in range(48)]
        return {**STATISTICS, "per_10min": bars}

    @routes.get("/api/v1/alarms/journal")
    async def journal() -> dict[str, Any]:
        last = stage.journal[0]["at"] if stage.journal else None
        return {"lines": stage.journal, "next_before": None, "last_raised": last}

    @routes.get("/api/v1/alarms/journal.csv")
    async def table() -> PlainTextResponse:
        return PlainTextResponse("at,alarm\n")

    @routes.get("/api/v1/alarms/notifications")
    async def notifications() -> dict[str, Any]:
        return {
            "revision": stage.saved,
            "channels": [{**one, "health": HEALTH} for one in stage.channels],
            "escalate_after_s": {"1": 60, "2": 300, "3": 1800, "4": None},
            "private_allowed": False,
            "hosts": [],
        }

    @routes.put("/api/v1/alarms/notifications")
    async def change(request: Request) -> Any:
        body = await request.json()
        note({"method": "PUT", "path": "alarms/notifications", **body})
        if body["revision"] != stage.saved:
            return JSONResponse({"code": "changed", "text": "Somebody changed it meanwhile."}, 409)
        if body["channels"] is not None:
            stage.channels = [{**one, "secret": "kept"} for one in body["channels"]]
        stage.saved += 1
        return await notifications()

    @routes.post("/api/v1/alarms/notifications/{channel}/test")
    async def try_channel(channel: str) -> dict[str, Any]:
        return {"ok": False, "text": "The other side answered 403."}

    @routes.get("/api/v1/alarms/{alarm_id}")
    async def one(alarm_id: str) -> JSONResponse:
        found = stage.entries.get(alarm_id)
        if found is None:
            return JSONResponse({"code": "not_found", "text": "No such alarm."}, 404)
        sequence = [
            {"at": found["raised"] - 1110, "kind": "link", "text": "Radio signal lost", "is_alarm": False,
             "is_first": False},
            {"at": found["raised"], "kind": "alarm", "text": found["title"], "is_alarm": True, "is_first": True},
        ]  # fmt: skip
        contact = {"name": "Jonas Weber", "phone": "+49 151 0000"}
        known = {"seen_before": 3, "contact": contact, "responsible": "Martha Keller"}
        return JSONResponse({"alarm": found, "type": TYPE, "sequence": sequence, **known})

    @routes.post("/api/v1/alarms/acknowledge")
    async def several(request: Request) -> dict[str, Any]:
        body = await request.json()
        note({"method": "POST", "path": "alarms/acknowledge", **body})
        return {"results": [{"id": i, **stage.act(i, "acknowledge", {}, who(request))} for i in body["ids"]]}

    @routes.post("/api/v1/alarms/{alarm_id}/{verb}")
    async def act(alarm_id: str, verb: str, request: Request) -> JSONResponse:
        body = await request.json() if await request.body() else {}
        note({"method": "POST", "path": f"alarms/{alarm_id}/{verb}", **body})
        if verb == "diagnose":
            return JSONResponse(CHECK)
        answer = stage.act(alarm_id, verb, body, who(request))
        return JSONResponse(answer, 200 if answer["code"] == "ok" else 409)

    return routes
