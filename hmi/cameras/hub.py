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

    async def still(self, camera: Camera, fresh_s: float | None) -> Piece | None:
        """Return the newest JPEG; with ``fresh_s`` one of at most this age, looked for if need be.

        A camera that sends by itself cannot be looked at: its newest is what there is, as old as it says.
        """
        if fresh_s is None or camera.source.kind is SourceKind.UPLOAD or self._is_young(camera.newest_jpeg, fresh_s):
            return camera.newest_jpeg
        glance = _Glance(camera.pulled_width or 0)
        camera.join(glance)
        try:
            async with asyncio.timeout(STILL_S):
                return await glance.picture
        except TimeoutError:
            return None
        finally:
            camera.leave(glance)

    def _refusal(self) -> str:
        """Why no further worker may be started."""
        running = sum(camera.worker_pid is not None for camera in self.cameras.values())
        return "" if running < self._most_workers else f"{running} cameras run already, which is the most allowed here"

    def _is_young(self, piece: Piece | None, fresh_s: float) -> bool:
        return piece is not None and self._clock.mono_s() - piece.captured_ms / 1000 <= fresh_s


class _Glance:
    """Looks until the first picture."""

    def __init__(self, width: int) -> None:
        self.wish, self.is_person = Wish(Way.JPEG, width, 2.0), False
        self.picture: asyncio.Future[Piece] = asyncio.get_running_loop().create_future()

    def take(self, piece: Piece) -> None:
        """See ``Watch``."""
        if not self.picture.done():
            self.picture.set_result(piece)
