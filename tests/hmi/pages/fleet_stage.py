"""The fleet's REST on stage: groups, views and duty are kept as the console keeps them, orders answer as told."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, Request
from fastapi.responses import JSONResponse

PEOPLE = [
    {"id": "operator", "name": "Martha Keller", "role": "operator"},
    {"id": "supervisor", "name": "Anna Ostermeier", "role": "supervisor"},
]
DAY = {
    "area_m2": 78_400.0,
    "plants": 612,
    "working_s": 40_000,
    "heard_s": 60_000,
    "utilisation": 0.667,
    "interventions": 9,
    "interventions_per_hour": 0.81,
}


class FleetStage:
    """What people kept, and how robots answer: ``outcomes`` by robot, accepted where nothing is said."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Begin anew."""
        self.groups: list[dict[str, Any]] = []
        self.views: list[dict[str, Any]] = []
        self.duty: dict[str, dict[str, Any]] = {}
        self.freed: dict[str, dict[str, Any]] = {}
        self.book: list[dict[str, Any]] = []
        self.walls: list[dict[str, Any]] = []
        self.outcomes: dict[str, dict[str, str]] = {}
        self.orders: list[dict[str, Any]] = []
        self.refusal = ""  # what deleting is answered with

    def answer(self, robots: list[str]) -> dict[str, Any]:
        """Return a result for each robot."""
        good = {"outcome": "accepted", "code": "ok", "text": ""}
        results = [{"robot": robot, **good, **self.outcomes.get(robot, {})} for robot in robots]
        return {"results": results, "accepted": sum(r["outcome"] == "accepted" for r in results), "total": len(results)}

    def give(self, robots: list[str], user: str, name: str, note: str) -> dict[str, Any]:
        """Make somebody responsible."""
        for robot in robots:
            self.freed.pop(robot, None)
            self.duty[robot] = {"user": user, "name": name, "since": 1_779_280_000_000, "note": note, "offer": None}
        return {"duty": {robot: self.duty[robot] for robot in robots}}


def router(stage: FleetStage) -> APIRouter:
    """Return the routes."""
    api = APIRouter()

    @api.post("/stage-fleet")
    async def adjust(request: Request) -> dict[str, Any]:
        body = await request.json()
        if body.pop("anew", False):
            stage.reset()
        for key, value in body.items():
            setattr(stage, key, value)
        return {}

    @api.get("/stage-fleet")
    async def heard() -> dict[str, Any]:
        return {"orders": stage.orders, "groups": stage.groups, "views": stage.views, "duty": stage.duty}

    @api.post("/api/v1/fleet/actions")
    async def act(request: Request) -> dict[str, Any]:
        body = await request.json()
        stage.orders.append(body)
        return stage.answer(body["robots"])

    @api.post("/api/v1/fleet/mission")
    async def mission(request: Request) -> dict[str, Any]:
        body = await request.json()
        stage.orders.append({"action": "mission", **body})
        return stage.answer([one["robot"] for one in body["pairs"]])

    @api.get("/api/v1/missions")
    async def missions() -> dict[str, Any]:
        ready = {"field_name": "Nordfeld 12", "status": "validated"}
        return {"missions": [{"id": "m-9", "name": "M-0409", "robot_id": "weeder-01", **ready}]}

    @api.get("/api/v1/fleet/kpis")
    async def kpis() -> dict[str, Any]:
        return DAY

    _kept(api, stage)
    _duty(api, stage)
    return api


def _kept(api: APIRouter, stage: FleetStage) -> None:
    @api.get("/api/v1/fleet/{kind}")
    async def kept(kind: str) -> dict[str, Any]:
        if kind == "duty":
            return {"duty": stage.duty, "freed": stage.freed, "people": PEOPLE, "book": stage.book}
        return {kind: getattr(stage, kind)}

    @api.post("/api/v1/fleet/groups", status_code=201)
    async def group(request: Request) -> dict[str, Any]:
        made = {"id": f"g-{len(stage.groups)}", "changed_by": "Martha Keller", **await request.json()}
        stage.groups.append(made)
        return made

    @api.post("/api/v1/fleet/views", status_code=201)
    async def view(request: Request) -> dict[str, Any]:
        made = {"id": f"v-{len(stage.views)}", **await request.json()}
        stage.views = [one for one in stage.views if one["name"] != made["name"]] + [made]
        return made

    @api.delete("/api/v1/fleet/{kind}/{entry_id}")
    async def forget(kind: str, entry_id: str) -> Any:
        if stage.refusal:
            return JSONResponse({"code": "refused", "text": stage.refusal}, 409)
        setattr(stage, kind, [one for one in getattr(stage, kind) if one["id"] != entry_id])
        return {}


def _duty(api: APIRouter, stage: FleetStage) -> None:
    @api.post("/api/v1/fleet/duty/handover")
    async def hand_over(request: Request) -> dict[str, Any]:
        body = await request.json()
        to = next(one for one in PEOPLE if one["id"] == body["to_user"])
        if to["id"] == request.cookies.get("stage"):
            return stage.give(body["robots"], to["id"], to["name"], body.get("note", ""))
        by = next(one for one in PEOPLE if one["id"] == request.cookies.get("stage"))
        offer = {
            "to": to["id"], "to_name": to["name"], "by": by["name"], "by_id": by["id"], "at": 1,
            "note": body.get("note", ""),
        }  # fmt: skip
        for robot in body["robots"]:
            held = stage.duty.get(robot, {"user": "", "name": "", "since": None, "note": ""})
            stage.duty[robot] = {**held, "offer": offer}
        return {"duty": {}}

    @api.post("/api/v1/fleet/duty/decline")
    async def decline(request: Request) -> dict[str, Any]:
        for robot in (await request.json())["robots"]:
            stage.duty[robot] = {**stage.duty[robot], "offer": None}
        return {"duty": {}}

    @api.post("/api/v1/fleet/duty/accept")
    async def accept(request: Request) -> dict[str, Any]:
        body = await request.json()
        me = next(one for one in PEOPLE if one["id"] == request.cookies.get("stage"))
        return stage.give(body["robots"], me["id"], me["name"], "")
