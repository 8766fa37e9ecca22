"""Kept pictures as people use them: take one, find them, look at them, mark, delete."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from hmi.clock import Clock
from hmi.commands.audit_line import audit_line
from hmi.commands.camera_ports import CameraProcess, NoPicture, Still
from hmi.commands.mission_pictures import draft
from hmi.commands.ports import AuditSink, LaneEvent
from hmi.commands.watermark import mark_of, watermarked
from hmi.domain.camera_source import FIELD
from hmi.domain.picture import Moment, Picture, PictureKind
from hmi.domain.picture_header import BadPicture
from hmi.domain.role import Permission
from hmi.security.authorization import Authorize
from hmi.security.session_info import SessionInfo
from hmi.store.database import Database
from hmi.store.picture_shelf import PictureShelf, ShelfHealth
from hmi.store.pictures import PictureFilter

FRESH_S = 1.0  # what was on the screen when the button was pressed is not older
MOST_AT_ONCE = 4


@dataclass(frozen=True, slots=True)
class PictureParts:
    """What the book is wired to.

    Attributes:
        moment_of: where a robot is and what it does, at a time of the console's monotonic clock.
        place_of: where a field camera stands.
        name_of: what people call a robot.
        newest_frame: what a field camera sent last; raises ``NoPicture``.
        has_watermark: whether person and time are burnt into the pictures that are sent out.
    """

    process: CameraProcess
    shelf: PictureShelf
    database: Database
    authorize: Authorize
    audit: AuditSink
    clock: Clock
    on_event: LaneEvent
    moment_of: Callable[[str, float], Moment]
    place_of: Callable[[str], Moment]
    name_of: Callable[[str], str]
    newest_frame: Callable[[str], Awaitable[Still]]
    has_watermark: bool = False


@dataclass(frozen=True, slots=True)
class Listed:
    """A page of the list; ``has_more`` says that older ones follow."""

    pictures: list[Picture]
    has_more: bool


class PictureBook:
    """Answers everything about kept pictures.

    Raises (every method): ``NotSignedIn``, ``NotAllowed``, ``StoreError`` and what it names itself.
    """

    def __init__(self, parts: PictureParts) -> None:
        self._parts = parts
        self._few = asyncio.Semaphore(MOST_AT_ONCE)

    async def snapshot(self, session: SessionInfo, robot_id: str, camera: str, note: str) -> Picture:
        """Keep what a camera shows now, with where the robot was and what it did.

        Raises:
            NoPicture: the camera shows nothing.
            CamerasAway: the camera process does not answer.
        """
        parts = self._parts
        parts.authorize(session, Permission.KEEP_PICTURES, None if robot_id == FIELD else robot_id)
        still = await self._still(robot_id, camera)
        moment = parts.place_of(camera) if robot_id == FIELD else parts.moment_of(robot_id, still.captured_s)
        try:
            one = draft(still, PictureKind.SNAPSHOT, session.farm_id, robot_id, camera, parts.clock, moment,
                        note=note, by=session.user_name, device=session.device_name)  # fmt: skip
        except BadPicture as error:
            raise NoPicture("no_picture", f"The camera sent no picture that can be kept. {error.text}") from error
        kept = await parts.shelf.keep(one, still.data)
        parts.on_event({"kind": "picture", "what": "kept", "id": kept.id, "robot": robot_id})
        self._note(session, "kept", f"Picture of {parts.name_of(robot_id)}, {camera}.", kept)
        return kept

    async def _still(self, robot_id: str, camera: str) -> Still:
        """Ask the camera process; what a field camera sent by itself is here anyway."""
        if robot_id == FIELD:
            with contextlib.suppress(NoPicture):
                return await self._parts.newest_frame(camera)
        async with self._few:
            return await self._parts.process.still(robot_id, camera, FRESH_S, is_full=True)

    async def listed(self, session: SessionInfo, wanted: PictureFilter, limit: int) -> Listed:
        """Return the newest pictures that fit."""
        self._parts.authorize(session, Permission.WATCH)
        found = await self._parts.database.run(self._parts.shelf.records.some, session.farm_id, wanted, limit + 1)
        return Listed(found[:limit], len(found) > limit)

    async def get(self, session: SessionInfo, picture_id: str) -> Picture:
        """Return one; raises ``NotFound``."""
        self._parts.authorize(session, Permission.WATCH)
        return await self._parts.database.run(self._parts.shelf.records.get, session.farm_id, picture_id)

    async def file(self, session: SessionInfo, picture_id: str) -> tuple[Picture, Path]:
        """Return a picture and where its file is; raises ``NotFound`` and ``FileNotFoundError``."""
        one = await self.get(session, picture_id)
        return one, await self._parts.shelf.path(one)

    async def stamped(self, session: SessionInfo, one: Picture, path: Path) -> bytes | None:
        """Return the picture with person and time burnt in, ``None`` where nobody wants that; raises ``OSError``."""
        if not self._parts.has_watermark or not one.media_type.startswith("image/"):
            return None
        told = mark_of(session.user_name, self._parts.clock.utc())
        async with self._few:
            return await asyncio.to_thread(watermarked, path, told)

    async def change(self, session: SessionInfo, picture_id: str, *, note: str | None, is_kept: bool | None) -> Picture:
        """Change note or mark of a picture.

        Raises:
            NotFound: there is none.
            TooMuchMarked: the marked ones fill their room.
        """
        self._parts.authorize(session, Permission.KEEP_PICTURES)
        one = await self.get(session, picture_id)
        changed = await self._parts.shelf.marked(one, note=note, is_kept=is_kept)
        if is_kept is not None and is_kept != one.is_kept:
            words = "is marked to be kept" if is_kept else "is not marked any more"
            self._note(session, "marked" if is_kept else "unmarked", f"{_named(one)} {words}.", one)
        if note is not None and note != one.note:
            self._note(session, "noted", f"{_named(one)}: {note or 'no note any more'}.", one)
        return changed

    async def remove(self, session: SessionInfo, picture_id: str) -> None:
        """Delete a picture; raises ``NotFound``."""
        self._parts.authorize(session, Permission.MANAGE_CAMERAS)
        one = await self._parts.database.run(self._parts.shelf.records.get, session.farm_id, picture_id)
        await self._parts.shelf.remove(one)
        self._parts.on_event({"kind": "picture", "what": "removed", "id": one.id, "robot": one.robot_id})
        self._note(session, "deleted", f"{_named(one)} deleted.", one, {"sha256": one.sha256, "kind": one.kind.value})

    def room(self) -> ShelfHealth:
        """Return how much room there is; for anybody who may watch."""
        return self._parts.shelf.health()

    def _note(
        self, session: SessionInfo, outcome: str, text: str, one: Picture, data: Mapping[str, object] | None = None
    ) -> None:
        self._parts.audit.append(
            audit_line(session, "picture", outcome, text, ref=one.id, robot_id=one.robot_id, data=data)
        )


def _named(one: Picture) -> str:
    what = "Clip" if one.kind is PictureKind.CLIP else "Picture"
    return f"{what} of {one.robot_id}, {one.camera}, {one.captured_at:%Y-%m-%d %H:%M:%S} UTC"
