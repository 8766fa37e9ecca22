"""Cuts clips out of what the camera process kept, and puts them on the shelf."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Sequence
from datetime import timedelta

from hmi.clock import Clock
from hmi.commands.camera_ports import CameraProcess, CamerasAway, Clip, NoPicture
from hmi.commands.ports import LaneEvent
from hmi.domain.ids import new_id
from hmi.domain.incident import Incident
from hmi.domain.picture import Picture, PictureKind
from hmi.store.errors import StoreError
from hmi.store.picture_shelf import PictureShelf

VIDEO = "video/mp4"
MOST_AT_ONCE = 2  # a clip is read and written whole; a STOP ALL asks for dozens
END_S = 1.0
MOST_SOURCES = 4  # of one camera within the two minutes of a clip
JUST_BEFORE_S = 0.001
LATE_S = 5.0  # a clip that begins so much later than it should, or ends so much earlier, says it
log = logging.getLogger(__name__)
_QUIET = ("nothing_kept", "unknown_camera", "no_picture")


class ClipKeeper:
    """Cuts in the background; nobody waits for it.

    Args:
        on_event: told of each clip that is kept.
    """

    def __init__(
        self, process: CameraProcess, shelf: PictureShelf, clock: Clock, farm_id: str, on_event: LaneEvent
    ) -> None:
        self._process, self._shelf, self._clock = process, shelf, clock
        self._farm_id, self._on_event = farm_id, on_event
        self._few = asyncio.Semaphore(MOST_AT_ONCE)
        self._tasks: set[asyncio.Task[None]] = set()

    def cut(self, incident: Incident, cameras: Sequence[str]) -> None:
        """Begin to keep a clip of each camera that was recording."""
        for camera in cameras:
            task = asyncio.get_running_loop().create_task(self._cut(incident, camera), name=f"clip-{camera}")
            self._tasks.add(task)
            task.add_done_callback(self._tasks.discard)

    async def close(self) -> None:
        """Wait a moment for what is being cut, then give it up: a console must end within seconds."""
        if self._tasks:
            _done, late = await asyncio.wait(self._tasks, timeout=END_S)
            for task in late:
                task.cancel()
            await asyncio.gather(*late, return_exceptions=True)

    async def _cut(self, incident: Incident, camera: str) -> None:
        name = f"{incident.robot_id}/{camera}"
        try:
            async with self._few:
                await self._keep(incident, camera)
        except NoPicture as error:
            if error.code not in _QUIET:  # a camera that nobody had open has nothing
                log.warning("no clip of %s: %s", name, error.text)
        except CamerasAway:
            log.warning("no clip of %s: the camera process is away", name)
        except StoreError as error:
            log.warning("a clip of %s was not kept: %s", name, error)
        except Exception:  # the end of a task: nobody above would say it
            log.exception("a clip of %s was not kept", name)

    async def _keep(self, incident: Incident, camera: str) -> None:
        """Keep a clip of each source a camera had in that time, the last first: no clip shows two cameras."""
        to_s = incident.ends_s
        for _ in range(MOST_SOURCES):
            clip = await self._kept(incident, camera, to_s)
            if not clip.has_before:
                return
            to_s = clip.begins_s - JUST_BEFORE_S

    async def _kept(self, incident: Incident, camera: str, to_s: float) -> Clip:
        picture_id = new_id()
        path = self._shelf.files.incoming(picture_id, VIDEO)
        try:
            clip = await self._process.clip(incident.robot_id, camera, incident.from_s, to_s, path)
        except BaseException:
            await asyncio.to_thread(path.unlink, missing_ok=True)
            raise
        one = Picture(
            id=picture_id, farm_id=self._farm_id, kind=PictureKind.CLIP, robot_id=incident.robot_id, camera=camera,
            captured_at=incident.began_at + timedelta(seconds=clip.begins_s - incident.began_s),
            added_at=self._clock.utc(), media_type=VIDEO, width_px=clip.width_px, height_px=clip.height_px,
            size_bytes=0, sha256="", moment=incident.moment, duration_s=round(clip.ends_s - clip.begins_s, 3),
            cause=" ".join(incident.causes), text=_text(incident, clip, is_old=to_s < incident.ends_s),
        )  # fmt: skip
        kept = await self._shelf.take(one)
        self._on_event({"kind": "picture", "what": "kept", "id": kept.id, "robot": kept.robot_id})
        return clip


def _text(incident: Incident, clip: Clip, *, is_old: bool) -> str:
    """Return what a clip says of itself; ``is_old``: it is of a source the camera had before."""
    told = [one if one.endswith(".") else f"{one}." for one in incident.texts]
    if clip.has_before:
        told.append(f"The camera's source was changed {_when(incident, clip.begins_s)}: this is the new one.")
    if is_old:
        told.append("This is from the camera's source before it was changed.")
    if clip.begins_s - incident.from_s > LATE_S:
        told.append(f"Recorded from {_when(incident, clip.begins_s)}.")
    if incident.ends_s - clip.ends_s > LATE_S:
        told.append(f"Recorded until {_when(incident, clip.ends_s)}.")
    if clip.has_gap:
        told.append("Pictures are missing in between.")
    if not clip.is_dated:
        told.append("The camera tells no time: times are of arrival.")
    return " ".join(told)


def _when(incident: Incident, at_s: float) -> str:
    before_s = round(incident.began_s - at_s)
    return f"{abs(before_s)} s {'before' if before_s >= 0 else 'after'} it"
