"""Frames that field cameras send by HTTP: who may, how often, what is kept."""

from __future__ import annotations

import asyncio
import contextlib
import hmac
import logging
from dataclasses import dataclass

from hmi.clock import Clock
from hmi.commands.camera_ports import CameraProcess, CamerasAway, NoPicture, Still
from hmi.commands.camera_source_book import CameraSourceBook, digest_of
from hmi.commands.mission_pictures import draft
from hmi.commands.watermark import as_jpeg
from hmi.domain.camera import SourceKind
from hmi.domain.camera_source import FIELD
from hmi.domain.picture import Moment, Picture, PictureKind
from hmi.domain.picture_header import BadPicture, Header, read_picture
from hmi.store.camera_sources import StoredSource
from hmi.store.database import Database
from hmi.store.picture_files import NewestFrame
from hmi.store.picture_shelf import PictureShelf

BURST = 3.0  # frames that a camera may send at once after a pause
SLACK = 0.8  # a camera's clock is no metronome
LEAST_S = 0.5
MOST_AGE_S = 3600.0
JPEG = "image/jpeg"
NOWHERE = Moment()
log = logging.getLogger(__name__)


class FrameRefused(Exception):
    """A frame that is not taken; ``code`` is ``bad_token``, ``unknown_camera`` or ``too_often``."""

    def __init__(self, code: str, text: str, retry_after_s: float = 0.0) -> None:
        super().__init__(text)
        self.code, self.text, self.retry_after_s = code, text, retry_after_s


@dataclass(slots=True)
class _Camera:
    """How often a camera sent, and when one of its frames was kept."""

    tokens: float = BURST
    at_s: float = 0.0
    kept_s: float = float("-inf")


class FieldFrames:
    """Takes frames; one for a console."""

    def __init__(
        self, sources: CameraSourceBook, shelf: PictureShelf, process: CameraProcess, database: Database, clock: Clock,
        farm_id: str,
    ) -> None:  # fmt: skip
        self._sources, self._shelf, self._process = sources, shelf, process
        self._database, self._clock, self._farm_id = database, clock, farm_id
        self._cameras: dict[str, _Camera] = {}

    async def load(self) -> None:
        """Learn when a frame of each camera was kept last; at start."""
        now, now_s = self._clock.utc(), self._clock.mono_s()
        newest = await self._database.run(self._shelf.records.newest_frames, self._farm_id, FIELD)
        for camera, at in newest.items():
            ago_s = max(0.0, (now - at).total_seconds())
            self._cameras[camera] = _Camera(at_s=now_s, kept_s=now_s - ago_s)

    def admit(self, camera: str, token: str) -> StoredSource:
        """Return the camera that shows this token and may send now, before its frame is read.

        Raises:
            FrameRefused: the token is not this camera's, or it sends too often.
        """
        one = self._sources.stored(FIELD, camera)
        known = one.token_sha256 if one is not None and one.kind is SourceKind.UPLOAD else ""
        if not hmac.compare_digest(digest_of(token), known or digest_of("")) or not token or one is None:
            raise FrameRefused("bad_token", "This is no camera of this farm, or its token is another one.")
        self._spend(camera, one.period_s)
        return one

    def admit_station(self, camera: str, least_s: float) -> StoredSource:
        """Return the camera of an accepted station, which needs no token: the broker has let it in.

        Args:
            least_s: between two of its pictures: those it is triggered for come between the expected ones.

        Raises:
            FrameRefused: there is no such camera, or it sends too often.
        """
        one = self._sources.stored(FIELD, camera)
        if one is None or one.kind is not SourceKind.UPLOAD:
            raise FrameRefused("unknown_camera", "This is no camera that sends its pictures by itself.")
        self._spend(camera, least_s)
        return one

    def _spend(self, camera: str, period_s: float) -> None:
        """Take a frame off what the camera may send now; raises ``FrameRefused``."""
        now_s = self._clock.mono_s()
        state = self._cameras.setdefault(camera, _Camera(at_s=now_s))
        every_s = max(LEAST_S, period_s * SLACK)
        tokens = min(BURST, state.tokens + (now_s - state.at_s) / every_s)
        state.at_s, state.tokens = now_s, tokens
        if tokens < 1.0:
            raise FrameRefused("too_often", f"One frame each {period_s:g} s.", (1.0 - tokens) * every_s)
        state.tokens -= 1.0

    async def take(self, one: StoredSource, data: bytes, age_s: float | None, place: Moment = NOWHERE) -> Header:
        """Take a frame: the newest if it is, one to show, and now and then one to keep.

        Args:
            age_s: how old it was when it was sent, if the camera tells.
            place: where the camera stands, if anybody knows.

        Raises:
            BadPicture: these bytes are no picture.
            PicturesFull, PicturesBusy: it was not kept.
        """
        header = read_picture(data)
        known_s = min(max(age_s or 0.0, 0.0), MOST_AGE_S)
        captured_s = self._clock.mono_s() - known_s
        await self._show(one, header, data, known_s)
        newest = NewestFrame(data, self._clock.utc().timestamp() - known_s, is_dated=age_s is not None)
        await self._shelf.set_newest_frame(one.camera, newest)
        await self._sources.noted_size(one, header.width_px, header.height_px)
        state = self._cameras.setdefault(one.camera, _Camera(at_s=self._clock.mono_s()))
        if one.keep_every_s > 0 and self._clock.mono_s() - state.kept_s >= one.keep_every_s:
            before_s, state.kept_s = state.kept_s, self._clock.mono_s()
            try:
                made = self._draft(one, Still(data, captured_s, is_dated=age_s is not None), place)
                await self._shelf.keep(made, data)
            except BaseException:
                state.kept_s = before_s
                raise
        return header

    async def newest(self, camera: str) -> Still:
        """Return the newest frame of a field camera; raises ``NoPicture``."""
        found, one = await self._shelf.newest_frame(camera), self._sources.stored(FIELD, camera)
        if found is None or one is None or one.kind is not SourceKind.UPLOAD:
            raise NoPicture("no_picture", "This camera has sent nothing yet.")
        age_s = max(0.0, self._clock.utc().timestamp() - found.taken_unix_s)
        return Still(found.data, self._clock.mono_s() - age_s, found.is_dated)

    async def show_again(self) -> None:
        """Tell a new camera process the newest frame of each camera, as old as it is: the next may come in an hour."""
        for one in self._sources.field_cameras():
            if one.kind is SourceKind.UPLOAD:
                with contextlib.suppress(NoPicture, BadPicture):
                    still = await self.newest(one.camera)
                    header = read_picture(still.data)
                    await self._show(one, header, still.data, self._clock.mono_s() - still.captured_s)

    async def _show(self, one: StoredSource, header: Header, data: bytes, age_s: float) -> None:
        """Hand it to the camera process for those who look; keeping it does not wait for that to work."""
        try:
            shown = data if header.media_type == JPEG else await asyncio.to_thread(as_jpeg, data)
            await self._process.frame(FIELD, one.camera, shown, age_s)
        except (CamerasAway, NoPicture, OSError) as error:
            log.debug("a frame of %s is not shown: %s", one.camera, error)

    def _draft(self, one: StoredSource, still: Still, place: Moment) -> Picture:
        return draft(still, PictureKind.FRAME, self._farm_id, FIELD, one.camera, self._clock, place)
