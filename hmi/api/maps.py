"""The farm's map: published versions and the draft that becomes the next; see ``docs/protocols/map.md``."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated, Any

from fastapi import APIRouter, Path, Query
from pydantic import Field

from hmi.api.access import SignedIn, Watcher
from hmi.api.body import Body, Id, Line, Ref
from hmi.api.map_answers import collection, draft_json, step_json, tried, utc, version_json
from hmi.api.map_exchange import MOST_CHANGES, add_file_routes
from hmi.commands.map_book import MapBook
from hmi.commands.map_exchange import MapExchange
from hmi.commands.map_review import MapReview
from hmi.domain.ids import ID_PATTERN
from hmi.domain.map_log import FeatureChange
from hmi.mapping.history import Entry

MOST_POINTS = 100_000  # a walk at 10 Hz is that long after almost three hours
VersionNumber = Annotated[int, Path(ge=1, le=1_000_000)]
FeatureId = Annotated[str, Path(pattern=ID_PATTERN)]
RobotId = Annotated[str | None, Query(max_length=64, description="whose width parcels are checked for")]


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


class StepBody(Body):
    """Which step of the log is meant; without one, the next."""

    id: Ref | None = None


NEXT = StepBody()


class TrialBody(Body):
    """An operation to look at before it is done."""

    op: Annotated[str, Field(max_length=40)]
    features: Annotated[list[Id], Field(min_length=1, max_length=MOST_CHANGES)]
    args: Annotated[dict[str, Any], Field(default_factory=dict)]


class PointBody(Body):
    """One position of a receiver."""

    lon: Annotated[float, Field(ge=-180, le=180)]
    lat: Annotated[float, Field(ge=-90, le=90)]
    accuracy_m: Annotated[float, Field(gt=0, le=100_000, description="one standard deviation")]
    at_s: Annotated[float, Field(description="seconds from any start")]


class WalkBody(Body):
    """Positions walked around a field or along a line."""

    points: Annotated[list[PointBody], Field(min_length=1, max_length=MOST_POINTS)]
    is_closed: bool = True
    tolerance_m: Annotated[float, Field(gt=0, le=50)] = 0.1


class PublishBody(Body):
    """What the new version is about."""

    note: Line = ""
    is_shrinking_ok: bool = False
    last_id: Annotated[Ref | None, Field(description="the newest step that was seen; another one is refused")] = None


def map_routes(book: MapBook, review: MapReview, exchange: MapExchange) -> APIRouter:
    """Return the routes of the map."""
    router = APIRouter(tags=["map"])
    _add_reading(router, book)
    _add_editing(router, book)
    _add_versions(router, book)
    _add_review(router, review)
    add_file_routes(router, exchange)
    return router


def _add_reading(router: APIRouter, book: MapBook) -> None:
    @router.get("/map", summary="The published map, and the draft if there is one")
    async def whole(session: Watcher) -> dict[str, Any]:
        version, features = await book.published(session)
        draft = await book.draft(session)
        shown = None if draft is None else draft_json(draft, session)
        return {**version_json(version), "features": collection(features), "draft": shown}

    @router.get("/map/draft/checks", summary="What is wrong with the draft, or with the published map")
    async def checks(session: Watcher, robot: RobotId = None) -> dict[str, Any]:
        found = await book.findings(session, robot)
        levels = [one.level for one in found]
        return {"findings": [one.as_json() for one in found], "blocks": levels.count(2), "looks": levels.count(3)}

    @router.get("/map/draft/diff", summary="What the draft changes")
    async def diff(session: Watcher) -> dict[str, Any]:
        found = await book.differences(session)
        return {
            "base_version": found.base_version,
            "newest_version": found.newest_version,
            "differences": [one.as_json() for one in found.differences],
            "meanwhile": [one.as_json() for one in found.meanwhile],
        }


def _add_editing(router: APIRouter, book: MapBook) -> None:
    @router.post("/map/draft", summary="Begin a draft or go on with it")
    async def begin(body: OpenBody, session: SignedIn) -> Any:
        return await tried(lambda: book.open(session, is_taking=body.take), lambda d: draft_json(d, session))

    @router.post("/map/draft/transactions", summary="Change the draft")
    async def change(body: TransactionBody, session: SignedIn) -> Any:
        changes = [FeatureChange(one.id, one.before, one.after) for one in body.changes]
        return await tried(lambda: book.change(session, body.id, body.label, changes), lambda r: step_json(r, session))

    @router.post("/map/draft/operations", summary="Change the draft by an operation")
    async def operate(body: OperationBody, session: SignedIn) -> Any:
        work = book.operate(session, body.id, body.op, body.features, body.args)
        return await tried(lambda: work, lambda r: step_json(r, session))

    @router.post("/map/draft/undo", summary="Take the newest change back")
    async def undo(session: SignedIn, body: StepBody = NEXT) -> Any:
        return await tried(lambda: book.undo(session, body.id), lambda r: step_json(r, session))

    @router.post("/map/draft/redo", summary="Make again what was taken back")
    async def redo(session: SignedIn, body: StepBody = NEXT) -> Any:
        return await tried(lambda: book.redo(session, body.id), lambda r: step_json(r, session))

    @router.delete("/map/draft", status_code=204, summary="Throw the draft away")
    async def discard(session: SignedIn) -> None:
        await tried(lambda: book.discard(session), lambda _: None)


def _add_versions(router: APIRouter, book: MapBook) -> None:
    @router.post("/map/draft/publish", summary="Make the draft what everybody sees")
    async def publish(body: PublishBody, session: SignedIn) -> Any:
        note = " ".join(body.note.split())
        work = book.publish(session, note, is_shrinking_ok=body.is_shrinking_ok, ref=body.last_id)
        return await tried(lambda: work, version_json)

    @router.get("/map/versions", summary="All versions, newest first")
    async def versions(session: Watcher) -> dict[str, Any]:
        return {"versions": [version_json(one) for one in await book.versions(session)]}

    @router.post("/map/versions/{number}/restore", summary="Make the draft equal to a version")
    async def restore(number: VersionNumber, session: SignedIn) -> Any:
        return await tried(lambda: book.restore(session, number), lambda d: draft_json(d, session))


def _add_review(router: APIRouter, review: MapReview) -> None:
    @router.post("/map/draft/preview", summary="What an operation would do; nothing is changed")
    async def preview(body: TrialBody, session: SignedIn) -> Any:
        work = review.trial(session, body.op, body.features, body.args)
        return await tried(lambda: work, lambda found: found.as_json())

    @router.post("/map/walks", summary="The outline of positions walked; nothing is changed")
    async def walk(body: WalkBody, session: SignedIn) -> Any:
        points = [(one.lon, one.lat, one.accuracy_m, one.at_s) for one in body.points]
        work = review.outline(session, points, is_closed=body.is_closed, tolerance_m=body.tolerance_m)
        return await tried(lambda: work, asdict)

    @router.get("/map/features/{feature_id}/history", summary="What changed about a feature, version by version")
    async def history(feature_id: FeatureId, session: Watcher) -> dict[str, Any]:
        found = await review.history(session, feature_id)
        return {"id": feature_id, "entries": [_entry(one) for one in found]}


def _entry(one: Entry) -> dict[str, Any]:
    return {
        "key": one.key,
        "label": one.label,
        "before": one.before,
        "after": one.after,
        "version": one.version,
        "published_utc": utc(one.at),
        "by": one.by,
        "note": one.note,
        "valid_from": one.valid_from,
    }
