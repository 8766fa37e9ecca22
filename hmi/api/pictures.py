"""Kept pictures and clips, see docs/cameras.md."""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Path, Query, Response
from starlette.responses import FileResponse

from hmi.api.access import SignedIn
from hmi.api.body import Body, Reason
from hmi.api.errors import ApiError
from hmi.commands.camera_ports import CamerasAway, NoPicture
from hmi.commands.picture_book import PictureBook
from hmi.domain.picture import Picture, PictureKind
from hmi.store.picture_files import ENDINGS
from hmi.store.picture_shelf import ShelfHealth
from hmi.store.pictures import PictureFilter

PictureId = Annotated[str, Path(pattern=r"^[0-9a-f]{32}\z")]
CameraRobot = Annotated[str, Path(pattern=r"^[a-z0-9][a-z0-9_-]{0,63}\z")]
CameraId = Annotated[str, Path(pattern=r"^[a-z0-9][a-z0-9_-]{0,63}\z")]
Short = Annotated[str, Query(max_length=64)]
When = Annotated[datetime | None, Query(description="ISO 8601 with zone")]
Most = Annotated[int, Query(ge=1, le=500)]
KEPT = "private, max-age=604800, immutable"  # a picture never changes under its id
AWAY = "The camera process does not answer. It comes back by itself; try again in a moment."
GONE = "The file of this picture is gone from the server."
NameOf = Callable[[str], str]


class SnapshotBody(Body):
    """Why a picture is kept, in a person's words."""

    note: Reason = ""


class PictureChange(Body):
    """What can be changed of a kept picture; what is left out stays as it is."""

    note: Reason | None = None
    is_kept: bool | None = None


def picture_routes(book: PictureBook, name_of: NameOf) -> APIRouter:
    """Return the routes of kept pictures."""
    router = APIRouter(tags=["pictures"])
    _add_list(router, book, name_of)
    _add_one(router, book, name_of)
    return router


def _add_list(router: APIRouter, book: PictureBook, name_of: NameOf) -> None:
    @router.post("/cameras/{robot}/{camera}/snapshot", status_code=201, summary="Keep what a camera shows now")
    async def snapshot(robot: CameraRobot, camera: CameraId, body: SnapshotBody, session: SignedIn) -> dict[str, Any]:
        try:
            return picture_json(await book.snapshot(session, robot, camera, body.note), name_of)
        except NoPicture as error:
            raise ApiError(404 if error.code == "unknown_camera" else 409, error.code, error.text) from error
        except CamerasAway as error:
            raise ApiError(503, "cameras_down", AWAY) from error

    @router.get("/pictures", summary="Kept pictures and clips, newest first")
    async def pictures(
        session: SignedIn, robot: Short = "", camera: Short = "", mission: Short = "",
        cause: Annotated[str, Query(max_length=200)] = "",
        kind: Annotated[list[Literal["snapshot", "clip", "mission", "frame"]] | None, Query()] = None,
        since: Annotated[When, Query(alias="from")] = None, until: Annotated[When, Query(alias="to")] = None,
        kept: bool | None = None, limit: Most = 60,
        before: Annotated[str, Query(max_length=80, description="`next` of the page before")] = "",
    ) -> dict[str, Any]:  # fmt: skip
        kinds = tuple(PictureKind(one) for one in kind or ())
        wanted = PictureFilter(robot, camera, kinds, mission, cause, _aware(since, "from"), _aware(until, "to"), kept,
                               _cursor(before))  # fmt: skip
        found = await book.listed(session, wanted, limit)
        last = found.pictures[-1] if found.has_more else None
        return {
            "pictures": [picture_json(one, name_of) for one in found.pictures],
            "next": None if last is None else f"{_utc(last.captured_at)}~{last.id}",
            "room": room_json(book.room()),
        }


def _add_one(router: APIRouter, book: PictureBook, name_of: NameOf) -> None:
    @router.get("/pictures/{picture_id}", summary="One picture: where, when, by whom")
    async def picture(picture_id: PictureId, session: SignedIn) -> dict[str, Any]:
        return picture_json(await book.get(session, picture_id), name_of)

    @router.get("/pictures/{picture_id}/file", summary="Its file; ranges work", response_class=Response)
    async def file(picture_id: PictureId, session: SignedIn, *, download: bool = False) -> Response:
        try:
            one, path = await book.file(session, picture_id)
            stamped = await book.stamped(session, one, path)
        except OSError as error:
            raise ApiError(410, "file_gone", GONE) from error
        name = file_name(one)
        how = "attachment" if download else "inline"
        if stamped is not None:
            headers = {"Cache-Control": "no-store", "Content-Disposition": f'{how}; filename="{name}"'}
            return Response(stamped, media_type="image/jpeg", headers=headers)
        headers = {"Cache-Control": KEPT, "ETag": f'"{one.sha256[:32]}"'}
        return FileResponse(
            path, headers=headers, media_type=one.media_type, filename=name, content_disposition_type=how
        )

    @router.patch("/pictures/{picture_id}", summary="Change its note, or mark it to be kept")
    async def change(picture_id: PictureId, body: PictureChange, session: SignedIn) -> dict[str, Any]:
        changed = await book.change(session, picture_id, note=body.note, is_kept=body.is_kept)
        return picture_json(changed, name_of)

    @router.delete("/pictures/{picture_id}", status_code=204, summary="Delete it")
    async def remove(picture_id: PictureId, session: SignedIn) -> None:
        await book.remove(session, picture_id)


def picture_json(one: Picture, name_of: NameOf) -> dict[str, Any]:
    """Return one picture; units are in the names, heading is a compass heading."""
    moment = one.moment
    mission = {"id": moment.mission_id, "name": moment.mission_name, "row": moment.row} if moment.mission_id else None
    return {
        "id": one.id,
        "kind": one.kind.value,
        "robot": one.robot_id,
        "robot_name": name_of(one.robot_id),
        "camera": one.camera,
        "captured_utc": _utc(one.captured_at),
        "added_utc": _utc(one.added_at),
        "age_s": one.age_s,
        "duration_s": one.duration_s,
        "lat_deg": moment.lat_deg,
        "lon_deg": moment.lon_deg,
        "heading_deg": moment.heading_deg,
        "position_age_s": moment.position_age_s,
        "mission": mission,
        "causes": one.cause.split(),
        "text": one.text,
        "note": one.note,
        "by": one.by,
        "device": one.device,
        "media_type": one.media_type,
        "width_px": one.width_px,
        "height_px": one.height_px,
        "size_bytes": one.size_bytes,
        "sha256": one.sha256,
        "is_kept": one.is_kept,
        "file": f"/api/v1/pictures/{one.id}/file",
        "file_name": file_name(one),
    }


def room_json(room: ShelfHealth) -> dict[str, Any]:
    """Return how much room pictures have, and whether anything is kept now."""
    return {
        "is_ok": room.is_ok,
        "text": room.text,
        "used_bytes": room.used_bytes,
        "marked_bytes": room.marked_bytes,
        "most_bytes": room.most_bytes,
        "free_bytes": room.free_bytes,
        "floor_bytes": room.floor_bytes,
    }


def file_name(one: Picture) -> str:
    """Return what a download is called: robot, camera, time; ids have no other characters."""
    return f"{one.robot_id}_{one.camera}_{one.captured_at:%Y-%m-%d_%H-%M-%S}.{ENDINGS[one.media_type]}"


def _cursor(text: str) -> tuple[datetime, str] | None:
    if not text:
        return None
    at, _, picture_id = text.partition("~")
    try:
        return datetime.fromisoformat(at).astimezone(UTC), picture_id
    except (ValueError, OverflowError) as error:
        raise ApiError(422, "invalid", "before: use what `next` of the page before says.", "before") from error


def _aware(value: datetime | None, field: str) -> datetime | None:
    if value is not None and value.tzinfo is None:
        raise ApiError(422, "invalid", f"{field}: give a zone, as in 2026-05-04T10:00:00Z.", field)
    return value


def _utc(value: datetime) -> str:
    return value.astimezone(UTC).isoformat(timespec="milliseconds")
