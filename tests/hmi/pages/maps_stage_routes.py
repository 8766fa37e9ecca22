"""The routes of the stage's map."""

from __future__ import annotations

import asyncio
from dataclasses import asdict
from typing import Any

from fastapi import APIRouter, Request
from fastapi.responses import JSONResponse, PlainTextResponse

from hmi.mapping.walk import WalkPoint, outline
from hmi.security.session_info import SessionInfo
from tests.hmi.pages.maps_stage import HISTORY, MapStage, Refused, Sessions, StageMap, collection, findings


def router(stage: MapStage, sessions: Sessions) -> APIRouter:
    """Return the routes of the map and those with which a test moves it."""
    routes = APIRouter()

    @routes.post("/stage-map")
    async def adjust(request: Request) -> dict[str, Any]:
        stage.set(await request.json())
        return {}

    @routes.get("/stage-map")
    async def heard() -> dict[str, Any]:
        return stage.heard()

    @routes.api_route("/api/v1/map", methods=["GET"])
    @routes.api_route("/api/v1/map/{rest:path}", methods=["GET", "POST", "DELETE"])
    async def map_request(request: Request, rest: str = "") -> Any:
        session = sessions.of_headers(request.headers.raw)
        if session is None:
            return JSONResponse({"code": "not_signed_in", "text": "Sign in first."}, 401)
        body: Any = {}
        if request.method == "POST" and rest != "imports":
            body = await request.json()
        elif rest == "imports":
            body = {"name": request.query_params["name"], "size": len(await request.body())}
        if request.method != "GET":
            stage.map.asked.append({"method": request.method, "path": rest, **body})
        if not rest.endswith("/progress"):  # a server that reads a large file still says how far it is
            await asyncio.sleep(stage.map.slow_s)
        if stage.map.is_down:
            return JSONResponse({"code": "database_unavailable", "text": "The records cannot be used right now."}, 503)
        try:
            return _play(stage.map, request, rest, session, body)
        except Refused as refusal:
            return JSONResponse(refusal.body, refusal.status)

    return routes


def _play(played: StageMap, request: Request, rest: str, session: SessionInfo, body: Any) -> Any:
    """Answer a request to the map by what it is about."""
    about, *more = rest.split("/")
    match about:
        case "" if request.method == "GET":
            found: Any = played.published(session)
        case "draft":
            found = _draft(played, request.method, more, session, body)
        case "proposals":
            found = played.propose(session, more, body)
        case "versions":
            found = _versions(played, more, session)
        case "imports":
            found = _imports(played, request.method, more, session, body)
        case "export":
            found = _export(request, more)
        case "walks":
            points = [WalkPoint(**one) for one in body["points"]]
            found = asdict(outline(points, body["is_closed"], body["tolerance_m"]))
        case "features":
            found = {"id": more[0], "entries": HISTORY}
        case _:
            found = None
    return JSONResponse({"code": "not_found", "text": "Nothing here."}, 404) if found is None else found


def _draft(played: StageMap, method: str, more: list[str], session: SessionInfo, body: Any) -> Any:
    match method, more:
        case "POST", []:
            return played.open(session, is_taking=body["take"])
        case "POST", ["transactions"]:
            return played.change(session, body["id"], body["label"], body["changes"])
        case "POST", ["operations"]:
            return played.operate(session, body)
        case "POST", ["undo" | "redo" as way]:
            return played.walk(session, is_back=way == "undo")
        case "POST", ["publish"]:
            return played.publish(session, body["note"], is_shrinking_ok=body["is_shrinking_ok"])
        case "POST", ["preview"]:
            return played.preview(body)
        case "GET", ["checks"]:
            found = findings(played.held().features)
            blocks = sum(one["level"] == 2 for one in found)
            return {"findings": found, "blocks": blocks, "looks": len(found) - blocks}
        case "GET", ["diff"]:
            return played.difference()
        case "DELETE", []:
            played.draft = None
            return JSONResponse(None, 200)
    return None


def _versions(played: StageMap, more: list[str], session: SessionInfo) -> Any:
    if not more:
        fixed = {"published_utc": "2026-05-12T07:30:00+00:00", "by": "Jonas Weber", "note": played.note}
        size = len(played.features)
        return {"versions": [{"version": n, **fixed, "size": size} for n in range(played.version, 11, -1)]}
    played.open(session, is_taking=False)
    draft = played.mine(session)
    change = {"id": "hangacker", "before": draft.features["hangacker"], "after": None}
    played.change(session, f"restore-{more[0]}", f"Content of v{more[0]}", [change])
    return {**played.state(session), "features": collection(draft.features)}


def _imports(played: StageMap, method: str, more: list[str], session: SessionInfo, body: Any) -> Any:
    match method, more:
        case "POST", []:
            return played.read(body["name"], body["size"])
        case "POST", [_, "take"]:
            return played.take(session, body)
        case "GET", [_, "progress"]:
            return {"share": 0.4, "shapes": 2400}
        case "DELETE", [_]:
            return JSONResponse(None, 200)
    return None


def _export(request: Request, more: list[str]) -> Any:
    kind = request.query_params["format"]
    if more == ["losses"]:
        return {"left_out": ["Home 1", "Hedge"] if kind == "fiware" else [], "cut": []}
    headers = {"content-disposition": f'attachment; filename="farm.{kind}"'}
    return PlainTextResponse(f"{kind} of {request.query_params['of']}", headers=headers)
