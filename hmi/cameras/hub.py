"""All cameras that exist, by name, and those who keep or ask for single pictures."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from typing import Any

from hmi.cameras.camera import Camera
from hmi.cameras.demand import Way, Wish
from hmi.cameras.jpeg_header import BadPicture, checked_size
from hmi.cameras.picture_wire import Piece
from hmi.clock import Clock
from hmi.domain.camera import Source, SourceKind

STILL_S = 4.0  # so long a still is waited for
FULL_S = 1.5  # and so long for one in full size, while a smaller one is there


class Hub:
    """Cameras by ``robot/camera``.

    Args:
        video_width: wider pictures are made smaller for WebRTC.
        most_workers: cameras that are pulled at once.
    """

    def __init__(self, clock: Clock, video_width: int, most_workers: int = 32) -> None:
        self._clock, self._video_width, self._most_workers = clock, video_width, most_workers
        self.cameras: dict[str, Camera] = {}

    def get(self, robot: str, camera: str) -> Camera | None:
        """Return a camera that exists."""
        return self.cameras.get(f"{robot}/{camera}")

    async def set_sources(self, sources: Sequence[Source]) -> list[Camera]:
        """Take the whole list; return cameras that are no more, already ended."""
        wanted = {source.name: source for source in sources}
        gone = [self.cameras.pop(name) for name in [one for one in self.cameras if one not in wanted]]
        for name, source in wanted.items():
            known = self.cameras.get(name)
            if known is None:
                self.cameras[name] = Camera(source, self._clock, self._video_width, self._refusal)
            elif known.source != source:
                known.change(source)
        for camera in gone:
            await camera.end()
        return gone

    async def end(self) -> None:
        """Let go of every camera."""
        await asyncio.gather(*(camera.end() for camera in self.cameras.values()))

    def describe(self) -> list[dict[str, Any]]:
        """Return all cameras as the protocol has them."""
        return [camera.describe() for camera in self.cameras.values()]

    def upload(self, camera: Camera, data: bytes, age_ms: float = 0.0) -> None:
        """Take a picture its camera sent, so old when it came; raises ``BadPicture``."""
        if not 0 <= age_ms < float("inf"):
            raise BadPicture("its age is none")
        width, height = checked_size(data)
        camera.upload(data, width, height, self._clock.mono_s() * 1000 - age_ms)

    async def still(self, camera: Camera, fresh_s: float | None, *, is_full: bool = False) -> Piece | None:
        """Return the newest JPEG; with ``fresh_s`` one of at most this age, looked for if need be.

        ``None`` as soon as the camera cannot be opened; its ``reason`` says why. With ``is_full`` as large as the
        camera makes it, not as those who watch want it, if that comes soon. A camera that sends by itself cannot be
        looked at: its newest is what there is, as old as it says.
        """
        newest = camera.newest_jpeg
        if fresh_s is None or camera.source.kind is SourceKind.UPLOAD:
            return newest
        young = newest if self._is_young(newest, fresh_s) else None
        if young is not None and not (is_full and _is_small(young, camera)):
            return young
        glance = _Glance(camera, 0 if is_full else camera.pulled_width or 0, young)
        camera.join(glance)
        camera.hearers.add(glance)
        try:
            async with asyncio.timeout(STILL_S if young is None else FULL_S):
                return await glance.picture
        except TimeoutError:
            return glance.small
        finally:
            camera.hearers.discard(glance)
            camera.leave(glance)

    def _refusal(self) -> str:
        """Why no further worker may be started."""
        running = sum(camera.worker_pid is not None for camera in self.cameras.values())
        return "" if running < self._most_workers else f"{running} cameras run already, which is the most allowed here"

    def _is_young(self, piece: Piece | None, fresh_s: float) -> bool:
        return piece is not None and self._clock.mono_s() - piece.captured_ms / 1000 <= fresh_s


def _is_small(piece: Piece, camera: Camera) -> bool:
    """Whether the camera makes larger ones; a robot sends smaller ones while nobody asks for more."""
    is_robot = camera.source.kind is SourceKind.ROBOT
    return piece.wanted_width != 0 or (is_robot and piece.width < camera.source.camera.width_px)


class _Glance:
    """Looks until the first picture, or the first failure.

    Args:
        width: at most so wide, 0 for as large as the camera makes it.
        small: what there is if nothing larger comes.
    """

    def __init__(self, camera: Camera, width: int, small: Piece | None) -> None:
        self.wish, self.is_person = Wish(Way.JPEG, width, 2.0), False
        self.small, self._restarts = small, camera.restarts
        is_robot = camera.source.kind is SourceKind.ROBOT
        self._enough_px = camera.source.camera.width_px if is_robot and not width and camera.pulled_width else 0
        self.picture: asyncio.Future[Piece | None] = asyncio.get_running_loop().create_future()

    def take(self, piece: Piece) -> None:
        """See ``Watch``; the first ones may still be as small as they were asked for before."""
        if piece.width >= self._enough_px or (self.small is not None and piece.width > self.small.width):
            self._end(piece)
        self.small = self.small or piece

    def tell(self, camera: Camera) -> None:
        """See ``Hearer``."""
        if camera.restarts > self._restarts:
            self._end(self.small)

    def _end(self, piece: Piece | None) -> None:
        if not self.picture.done():
            self.picture.set_result(piece)
