"""Map files in and out over REST: read, looked through, taken; written, with what a format cannot carry."""

from __future__ import annotations

import asyncio
from collections.abc import Coroutine
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Path, Query, Request, Response
from fastapi.responses import JSONResponse
from pydantic import Field

from hmi.api.access import SignedIn, Watcher
from hmi.api.body import Body, Ref
from hmi.api.map_answers import step_json, tried
from hmi.commands.map_exchange import MapExchange, Waiting
from hmi.map_files.exported import MapFile
from hmi.map_files.imported import MapItem

MOST_CHANGES = 20_000  # shapes of one file, and of one transaction
GONE_S = 0.5  # how often is asked whether somebody still waits for the answer
FileName = Annotated[str, Query(min_length=1, max_length=200)]
ImportId = Annotated[str, Path(max_length=64)]
ImportRef = Annotated[Ref | None, Query(description="names this import while it is read")]
Format = Annotated[Literal["geojson", "kml", "kmz", "shapefile", "isoxml", "gpx", "fiware"], Query()]
Which = Literal["published", "draft"]


class TakeBody(Body):
    """Which items of an import to take, and as what."""

    id: Ref
    items: Annotated[list[int], Field(min_length=1, max_length=MOST_CHANGES)]
    kinds: Annotated[dict[str, Annotated[str, Field(max_length=24)]], Field(default_factory=dict)]


def add_file_routes(router: APIRouter, exchange: MapExchange) -> None:
    """Add what takes and gives files."""
    _add_imports(router, exchange)

    @router.get("/map/export", summary="The map as a file", response_class=Response)
    async def export(format: Format, session: Watcher, of: Which = "published") -> Any:
        return await tried(lambda: exchange.export(session, format, is_draft=of == "draft"), _download)

    @router.get("/map/export/losses", summary="What a format cannot carry of the map")
    async def losses(format: Format, session: Watcher, of: Which = "published") -> Any:
        return await tried(lambda: exchange.export(session, format, is_draft=of == "draft"), _losses)


def _add_imports(router: APIRouter, exchange: MapExchange) -> None:
    @router.post("/map/imports", status_code=201, summary="Read a map file; the body is the file")
    async def read(
        request: Request, name: FileName, session: SignedIn, ref: ImportRef = None, geometry: bool = True
    ) -> Any:
        data = await request.body()
        work = exchange.read(session, data, name, ref)
        return await tried(lambda: _while_awaited(request, work, has_geometry=geometry), lambda made: made)

    @router.get("/map/imports/{import_id}/progress", summary="How far a file is read")
    async def progress(import_id: ImportId, session: SignedIn) -> Any:
        done = exchange.progress(session, import_id)
        return {"share": round(done.share, 3), "shapes": done.shapes}

    @router.delete("/map/imports/{import_id}", status_code=204, summary="Give an import up")
    async def cancel(import_id: ImportId, session: SignedIn) -> None:
        exchange.cancel(session, import_id)

    @router.post("/map/imports/{import_id}/take", summary="Take items of a read file into the draft")
    async def take(import_id: ImportId, body: TakeBody, session: SignedIn) -> Any:
        work = exchange.take(session, import_id, body.id, body.items, body.kinds)
        return await tried(lambda: work, lambda r: step_json(r, session))


async def _while_awaited(request: Request, work: Coroutine[Any, Any, Waiting], *, has_geometry: bool) -> Response:
    """Give the work up when the browser that asked for it is gone; write thousands of shapes off the event loop."""
    task = asyncio.create_task(work, name="map-import")
    try:
        while not task.done():
            await asyncio.wait({task}, timeout=GONE_S)
            if not task.done() and await request.is_disconnected():
                task.cancel()
                await asyncio.wait({task})
        told = await asyncio.to_thread(import_json, task.result(), has_geometry=has_geometry)
        return await asyncio.to_thread(JSONResponse, told, 201)
    finally:
        task.cancel()


def import_json(waiting: Waiting, *, has_geometry: bool) -> dict[str, Any]:
    """Return a read file with everything a person needs to choose."""
    content = waiting.content
    return {
        "id": waiting.id,
        "name": waiting.name,
        "format": content.format,
        "crs": content.crs,
        "items": [_item(one, has_geometry=has_geometry) for one in content.items],
        "skipped": [{"which": one.which, "why": one.why, "mend": one.mend} for one in content.skipped],
    }


def _item(item: MapItem, *, has_geometry: bool) -> dict[str, Any]:
    told = {
        "n": item.n,
        "name": item.name,
        "kind": item.kind,
        "kinds": list(item.kinds),
        "vertices": item.corners,
        "area_m2": item.area_m2,
        "problems": list(item.problems),
    }
    return told | ({"geometry": item.geometry, "properties": item.properties} if has_geometry else {})


def _download(file: MapFile) -> Response:
    disposition = f'attachment; filename="{file.file_name}"'
    return Response(file.data, media_type=file.media_type, headers={"Content-Disposition": disposition})


def _losses(file: MapFile) -> dict[str, Any]:
    return {"left_out": list(file.left_out), "cut": list(file.cut)}
