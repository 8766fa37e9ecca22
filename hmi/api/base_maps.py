"""Base maps: what lies under the farm's map, see ``docs/base_maps.md``."""

from __future__ import annotations

from collections.abc import AsyncIterator
from dataclasses import dataclass
from pathlib import PurePath
from typing import Annotated, Any

from fastapi import APIRouter, Path, Query, Request, Response
from pydantic import Field
from starlette.requests import ClientDisconnect

from hmi.api.access import SignedIn, Watcher
from hmi.api.body import Body, Line, Name
from hmi.api.errors import ApiError
from hmi.base_maps.errors import BadBaseMap
from hmi.commands.base_map_book import BaseMapBook, Shelf, Tile
from hmi.commands.base_map_work import Work
from hmi.security.session_info import SessionInfo
from hmi.store.base_maps import StoredBaseMap

STATUS = {"busy": 409, "no_room": 409, "already_there": 409, "too_large": 413, "no_disk": 507, "file_gone": 410}
KEPT = "private, max-age=604800, immutable"  # an id never gets other tiles
NOTHING_TO_SEE = bytes.fromhex(  # a transparent PNG of one pixel: browsers take it as a tile, and it is no failure
    "89504e470d0a1a0a0000000d49484452000000010000000108060000001f15c4890000000d49444154789c6360606060000000050001a5f64540"
    "0000000049454e44ae426082"
)
NAME_CHARS = 80
BaseMapId = Annotated[str, Path(pattern=r"^[a-z0-9]{1,32}\z")]
Zoom = Annotated[int, Path(ge=0, le=24)]
Step = Annotated[int, Path(ge=0, lt=2**24)]
FileName = Annotated[str, Query(min_length=1, max_length=200)]


@dataclass(frozen=True, slots=True)
class OnlineMap:
    """Tiles of somebody else, as an admin configured them."""

    url: str
    credit: str
    max_zoom: int


class DescribeBody(Body):
    """What a base map is called, and who must be named beside it."""

    name: Name
    credit: Annotated[Line, Field(max_length=160)] = ""


def base_map_routes(book: BaseMapBook, online: OnlineMap | None) -> APIRouter:
    """Return the routes of base maps."""
    router = APIRouter(tags=["base maps"])
    _add_shelf(router, book, online)
    _add_tiles(router, book)
    return router


def _add_shelf(router: APIRouter, book: BaseMapBook, online: OnlineMap | None) -> None:
    @router.get("/base-maps", summary="All base maps, what is being made, and the room there is")
    async def shelf(session: Watcher) -> dict[str, Any]:
        return shelf_json(await book.shelf(session), session, online)

    @router.post("/base-maps", status_code=202, summary="Upload a GeoTIFF or PMTiles; the body is the file")
    async def upload(request: Request, name: FileName, session: SignedIn) -> Any:
        told = request.headers.get("content-length", "")
        size = int(told) if told.isdigit() else None
        file_name = PurePath(name.replace("\\", "/")).name
        title = " ".join(PurePath(file_name).stem.replace("_", " ").split())
        title = "".join(c for c in title if c.isprintable())[:NAME_CHARS] or "Base map"
        try:
            work = await book.receive(session, file_name, title, size, _chunks(request))
        except BadBaseMap as error:
            raise _refused(error) from error
        except ClientDisconnect as error:
            raise ApiError(400, "cancelled", "The upload was given up.") from error
        return work_json(work, session)

    @router.patch("/base-maps/{base_map_id}", summary="Rename a base map, or say who must be named beside it")
    async def rename(base_map_id: BaseMapId, body: DescribeBody, session: SignedIn) -> Any:
        return map_json(await book.rename(session, base_map_id, body.name, body.credit), is_there=True)

    @router.delete("/base-maps/{base_map_id}", status_code=204, summary="Delete a base map, or give one up")
    async def remove(base_map_id: BaseMapId, session: SignedIn) -> None:
        await book.remove(session, base_map_id)


def _add_tiles(router: APIRouter, book: BaseMapBook) -> None:
    @router.get("/base-maps/{base_map_id}/{z}/{x}/{y}", summary="A tile, web mercator", response_class=Response)
    async def tile(request: Request, base_map_id: BaseMapId, z: Zoom, x: Step, y: Step, session: Watcher) -> Response:
        try:
            found = await book.tile(session, base_map_id, z, x, y)
        except BadBaseMap as error:
            raise _refused(error) from error
        tag = f'"{found.version}-{z}-{x}-{y}"'
        headers = {"Cache-Control": KEPT, "ETag": tag}
        if tag in request.headers.get("if-none-match", ""):
            return Response(status_code=304, headers=headers)
        return _answer(found, headers)


def _answer(found: Tile, headers: dict[str, str]) -> Response:
    if found.data is None:
        if found.media_type.startswith("image/"):
            return Response(NOTHING_TO_SEE, media_type="image/png", headers=headers)
        return Response(status_code=204, headers=headers)
    if found.is_packed:
        headers = {**headers, "Content-Encoding": "gzip"}
    return Response(found.data, media_type=found.media_type, headers=headers)


def shelf_json(shelf: Shelf, session: SessionInfo, online: OnlineMap | None) -> dict[str, Any]:
    """Return everything the chooser and the panel show."""
    return {
        "maps": [map_json(one, is_there=is_there) for one, is_there in shelf.maps],
        "online": None if online is None else {"url": online.url, "credit": online.credit, "max_zoom": online.max_zoom},
        "work": [work_json(one, session) for one in shelf.work],
        "room": {
            "used_bytes": shelf.used_bytes,
            "most_bytes": shelf.farm_bytes,
            "upload_bytes": shelf.upload_bytes,
        },
    }


def map_json(one: StoredBaseMap, *, is_there: bool) -> dict[str, Any]:
    """Return one base map."""
    return {
        "id": one.id,
        "name": one.name,
        "kind": one.kind,
        "bounds": [one.west_deg, one.south_deg, one.east_deg, one.north_deg],
        "min_zoom": one.min_zoom,
        "max_zoom": one.max_zoom,
        "tile_px": one.tile_px,
        "schema": one.schema,
        "credit": one.credit,
        "size_bytes": one.size_bytes,
        "by": one.by,
        "added_utc": one.added_at.isoformat(timespec="milliseconds"),
        "is_there": is_there,
    }


def work_json(work: Work, session: SessionInfo) -> dict[str, Any]:
    """Return one upload on its way."""
    return {
        "id": work.id,
        "file": work.file_name,
        "name": work.name,
        "by": work.by,
        "is_mine": work.user_id == session.user_id,
        "state": work.state,
        "share": round(work.share, 3),
        "size_bytes": work.size_bytes,
        "code": work.code,
        "text": work.text,
    }


async def _chunks(request: Request) -> AsyncIterator[bytes]:
    async for chunk in request.stream():
        if chunk:
            yield chunk


def _refused(error: BadBaseMap) -> ApiError:
    return ApiError(STATUS.get(error.code, 422), error.code, error.text)
