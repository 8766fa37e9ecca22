"""The farm's map: published versions and the draft that becomes the next; see ``docs/protocols/map.md``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from datetime import datetime
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Path, Query, Request, Response
from fastapi.responses import JSONResponse
from pydantic import Field

from hmi.api.access import SignedIn, Watcher
from hmi.api.body import Body, Id, Line, Ref
from hmi.api.errors import ApiError, answer
from hmi.commands.map_book import MapBlocked, MapBook, MapShrinks
from hmi.commands.map_exchange import MapExchange, Waiting
from hmi.domain.map_log import ChangedMeanwhile, FeatureChange, MapFeatures, next_redo, next_undo
from hmi.map_files.errors import BadMapFile
from hmi.map_files.exported import MapFile
from hmi.map_files.imported import MapItem
from hmi.mapping.errors import BadFeature, OperationRefused
from hmi.mapping.feature import MapFeature
from hmi.mapping.measures import area_m2
from hmi.security.session_info import SessionInfo
from hmi.store.maps import MapDraft, MapLocked, MapOutdated, MapVersion

LOG_SHOWN = 50
MOST_CHANGES = 5000
FileName = Annotated[str, Query(min_length=1, max_length=200)]
ImportId = Annotated[str, Path(max_length=32)]
Format = Annotated[Literal["geojson", "kml", "kmz", "shapefile", "isoxml", "gpx", "fiware"], Query()]
VersionNumber = Annotated[int, Path(ge=1, le=1_000_000)]


class OpenBody(Body):
    """Begin or go on with the draft."""

    take: Annotated[bool, Field(description="take it from who edits it; supervisors only")] = False


class ChangeBody(Body):
    """One feature before and after, GeoJSON; ``null`` is absent."""

    id: Id
    before: dict[str, Any] | None
    after: dict[str, Any] | None


class TransactionBody(Body):
    """What one gesture changed."""

    id: Ref
    label: Annotated[str, Field(min_length=1, max_length=200)]
    changes: Annotated[list[ChangeBody], Field(min_length=1, max_length=MOST_CHANGES)]


class OperationBody(Body):
    """An operation of the table in ``docs/protocols/map.md``."""

    id: Ref
    op: Annotated[str, Field(max_length=40)]
    features: Annotated[list[Id], Field(min_length=1, max_length=MOST_CHANGES)]
    args: Annotated[dict[str, Any], Field(default_factory=dict)]


class TakeBody(Body):
    """Which items of an import to take, and as what."""

    id: Ref
    items: Annotated[list[int], Field(min_length=1, max_length=MOST_CHANGES)]
    kinds: Annotated[dict[str, Annotated[str, Field(max_length=24)]], Field(default_factory=dict)]


class PublishBody(Body):
    """What the new version is about."""

    note: Line = ""
    is_shrinking_ok: bool = False


def map_routes(book: MapBook, exchange: MapExchange) -> APIRouter:
    """Return the routes of the map."""
    router = APIRouter(tags=["map"])
    _add_reading(router, book)
    _add_editing(router, book)
    _add_versions(router, book)
    _add_files(router, exchange)
    return router


def _add_reading(router: APIRouter, book: MapBook) -> None:
    @router.get("/map", summary="The published map, and the draft if there is one")
    async def whole(session: Watcher) -> dict[str, Any]:
        version, features = await book.published(session)
        draft = await book.draft(session)
        shown = None if draft is None else draft_json(draft, session)
        return {**version_json(version), "features": collection(features), "draft": shown}

    @router.get("/map/draft/checks", summary="What is wrong with the draft, or with the published map")
    async def checks(session: Watcher) -> dict[str, Any]:
        found = await book.findings(session)
        levels = [one.level for one in found]
        return {"findings": [one.as_json() for one in found], "blocks": levels.count(2), "looks": levels.count(3)}

    @router.get("/map/draft/diff", summary="What the draft changes")
    async def diff(session: Watcher) -> dict[str, Any]:
        base, found = await book.differences(session)
        rows = [{"id": d.id, "name": d.name, "kind": d.kind, "what": d.what, "text": d.text} for d in found]
        return {"base_version": base, "differences": rows}


def _add_editing(router: APIRouter, book: MapBook) -> None:
    @router.post("/map/draft", summary="Begin a draft or go on with it")
    async def begin(body: OpenBody, session: SignedIn) -> Any:
        return await _tried(lambda: book.open(session, is_taking=body.take), lambda d: draft_json(d, session))

    @router.post("/map/draft/transactions", summary="Change the draft")
    async def change(body: TransactionBody, session: SignedIn) -> Any:
        changes = [FeatureChange(one.id, one.before, one.after) for one in body.changes]
        return await _tried(lambda: book.change(session, body.id, body.label, changes), lambda r: _step(r, session))

    @router.post("/map/draft/operations", summary="Change the draft by an operation")
    async def operate(body: OperationBody, session: SignedIn) -> Any:
        work = book.operate(session, body.id, body.op, body.features, body.args)
        return await _tried(lambda: work, lambda r: _step(r, session))

    @router.post("/map/draft/undo", summary="Take the newest change back")
    async def undo(session: SignedIn) -> Any:
        return await _tried(lambda: book.undo(session), lambda r: _step(r, session))

    @router.post("/map/draft/redo", summary="Make again what was taken back")
    async def redo(session: SignedIn) -> Any:
        return await _tried(lambda: book.redo(session), lambda r: _step(r, session))

    @router.delete("/map/draft", status_code=204, summary="Throw the draft away")
    async def discard(session: SignedIn) -> None:
        await _tried(lambda: book.discard(session), lambda _: None)


def _add_versions(router: APIRouter, book: MapBook) -> None:
    @router.post("/map/draft/publish", summary="Make the draft what everybody sees")
    async def publish(body: PublishBody, session: SignedIn) -> Any:
        work = book.publish(session, " ".join(body.note.split()), is_shrinking_ok=body.is_shrinking_ok)
        return await _tried(lambda: work, version_json)

    @router.get("/map/versions", summary="All versions, newest first")
    async def versions(session: Watcher) -> dict[str, Any]:
        return {"versions": [version_json(one) for one in await book.versions(session)]}

    @router.post("/map/versions/{number}/restore", summary="Make the draft equal to a version")
    async def restore(number: VersionNumber, session: SignedIn) -> Any:
        return await _tried(lambda: book.restore(session, number), lambda d: draft_json(d, session))


def _add_files(router: APIRouter, exchange: MapExchange) -> None:
    @router.post("/map/imports", status_code=201, summary="Read a map file; the body is the file")
    async def read(request: Request, name: FileName, session: SignedIn) -> Any:
        data = await request.body()
        return await _tried(lambda: exchange.read(session, data, name), import_json)

    @router.post("/map/imports/{import_id}/take", summary="Take items of a read file into the draft")
    async def take(import_id: ImportId, body: TakeBody, session: SignedIn) -> Any:
        work = exchange.take(session, import_id, body.id, body.items, body.kinds)
        return await _tried(lambda: work, lambda r: _step(r, session))

    @router.get("/map/export", summary="The map as a file", response_class=Response)
    async def export(format: Format, session: Watcher, of: Literal["published", "draft"] = "published") -> Any:
        return await _tried(lambda: exchange.export(session, format, is_draft=of == "draft"), _download)


def import_json(waiting: Waiting) -> dict[str, Any]:
    """Return a read file with everything a person needs to choose."""
    content = waiting.content
    return {
        "id": waiting.id,
        "name": waiting.name,
        "format": content.format,
        "crs": content.crs,
        "items": [_item(one) for one in content.items],
        "skipped": [{"which": one.which, "why": one.why, "mend": one.mend} for one in content.skipped],
    }


def _item(item: MapItem) -> dict[str, Any]:
    return {
        "n": item.n,
        "name": item.name,
        "kind": item.kind,
        "kinds": list(item.kinds),
        "vertices": item.vertices,
        "area_m2": area_m2(MapFeature("item", item.kind, item.name, item.geometry, {})),
        "geometry": item.geometry,
        "properties": item.properties,
        "problems": list(item.problems),
    }


def _download(file: MapFile) -> Response:
    disposition = f'attachment; filename="{file.file_name}"'
    return Response(file.data, media_type=file.media_type, headers={"Content-Disposition": disposition})


def collection(features: MapFeatures) -> dict[str, Any]:
    """Return features as a GeoJSON FeatureCollection."""
    return {"type": "FeatureCollection", "features": list(features.values())}


def version_json(version: MapVersion) -> dict[str, Any]:
    """Return a version without its features."""
    return {
        "version": version.number,
        "published_utc": _utc(version.published_at),
        "by": version.by,
        "note": version.note,
        "size": version.size,
    }


def state_json(draft: MapDraft, session: SessionInfo) -> dict[str, Any]:
    """Return everything about a draft but its features."""
    undo, redo = next_undo(draft.log), next_redo(draft.log)
    return {
        "base_version": draft.base_version,
        "saved_utc": _utc(draft.saved_at),
        "editor": {"user": draft.editor_id, "name": draft.editor_name},
        "until_utc": _utc(draft.locked_until),
        "is_mine": draft.editor_id == session.user_id,
        "undo": undo.label if undo else None,
        "redo": redo.label if redo else None,
        "log": [
            {"id": one.ref, "label": one.label, "by": one.by, "utc": _utc(one.at), "is_undone": one.is_undone}
            for one in reversed(draft.log[-LOG_SHOWN:])
        ],
    }


def draft_json(draft: MapDraft, session: SessionInfo) -> dict[str, Any]:
    """Return a draft with its features."""
    return {**state_json(draft, session), "features": collection(draft.features)}


def changes_json(changes: Sequence[FeatureChange]) -> list[dict[str, Any]]:
    """Return changes as the editor takes them."""
    return [{"id": one.id, "before": one.before, "after": one.after} for one in changes]


def _step(result: tuple[MapDraft, Sequence[FeatureChange]], session: SessionInfo) -> dict[str, Any]:
    draft, changes = result
    return {"draft": state_json(draft, session), "changes": changes_json(changes)}


async def _tried(work: Callable[[], Any], shown: Callable[[Any], Any]) -> Any:
    """Await the book; its refusals become errors of the request."""
    try:
        return shown(await work())
    except MapLocked as error:
        text = f"{error.by} edits this map until {error.until:%H:%M} UTC. Ask, or wait."
        return _with(423, "locked", text, by=error.by, until_utc=_utc(error.until))
    except ChangedMeanwhile as error:
        text = "The draft is not what was shown here any more. It is loaded again; make the change once more."
        return _with(409, "changed", text, ids=list(error.ids))
    except MapOutdated as error:
        text = f"Version {error.number} was published meanwhile. Discard this draft or restore from it."
        return _with(409, "outdated", text, version=error.number)
    except MapBlocked as error:
        count = len(error.findings)
        text = f"Fix {count} blocking check{'s' if count > 1 else ''} first: {error.findings[0].text}"
        return _with(409, "blocked", text, findings=[one.as_json() for one in error.findings])
    except MapShrinks as error:
        raise ApiError(409, "shrinks", f"{error.text} Publish anyway?") from error
    except (BadFeature, OperationRefused, BadMapFile) as error:
        raise ApiError(422, error.code, error.text) from error


def _with(status: int, code: str, text: str, **more: Any) -> JSONResponse:
    """Return an error in the one shape, with what a program needs to go on."""
    plain = answer(status, code, text)
    return JSONResponse({"code": code, "text": text, "field": None, **more}, plain.status_code)


def _utc(at: datetime | None) -> str | None:
    return None if at is None else at.isoformat(timespec="milliseconds")
