"""What keeping pictures needs of the camera process, as one narrow protocol."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol


class CamerasAway(Exception):
    """The camera process does not answer; it comes back by itself."""


class NoPicture(Exception):
    """A camera has no picture, or nothing was recorded; ``code`` as in docs/protocols/cameras.md.

    ``text`` is one sentence for a person.
    """

    def __init__(self, code: str, text: str) -> None:
        super().__init__(text)
        self.code, self.text = code, text


@dataclass(frozen=True, slots=True)
class Still:
    """One JPEG; ``captured_s`` is on the console's monotonic clock: when it came, where its camera tells no time."""

    data: bytes
    captured_s: float
    is_dated: bool = True


@dataclass(frozen=True, slots=True)
class Clip:
    """What is in a clip that was written; times on the console's monotonic clock.

    ``has_before``: its source began in it, and there are pictures of the one before.
    """

    begins_s: float
    ends_s: float
    width_px: int
    height_px: int
    has_gap: bool = False
    is_dated: bool = True
    has_before: bool = False


class CameraProcess(Protocol):
    """The camera process; every method raises ``CamerasAway``."""

    async def still(self, robot_id: str, camera: str, fresh_s: float | None, *, is_full: bool = False) -> Still:
        """Return the newest picture; with ``fresh_s`` the camera is opened until one of that age is there.

        Args:
            is_full: that one is as large as the camera makes it if it comes soon, else as large as it is watched.

        Raises:
            NoPicture: there is none.
        """
        ...

    async def record(self, cameras: Sequence[tuple[str, str]]) -> None:
        """Say which cameras keep their last minute, all of them; each is pulled for as long as it is named."""
        ...

    async def watched(self) -> list[tuple[str, str]]:
        """Return the cameras somebody looks at now; costs nothing while no page is open."""
        ...

    async def clip(self, robot_id: str, camera: str, from_s: float, to_s: float, path: Path) -> Clip:
        """Write what was kept of a camera, of its last source in that time, to a file that does not exist yet.

        Raises:
            NoPicture: nothing was kept.
        """
        ...

    async def frame(self, robot_id: str, camera: str, data: bytes, age_s: float) -> None:
        """Hand over a JPEG that was sent to the console, and how old it is."""
        ...


class NoCameras:
    """A console without a camera process."""

    async def still(self, robot_id: str, camera: str, fresh_s: float | None, *, is_full: bool = False) -> Still:
        """Raise ``CamerasAway``."""
        raise CamerasAway(f"no picture of {robot_id}/{camera}, {fresh_s}, {is_full}")

    async def record(self, cameras: Sequence[tuple[str, str]]) -> None:
        """Do nothing."""

    async def watched(self) -> list[tuple[str, str]]:
        """Return none."""
        return []

    async def clip(self, robot_id: str, camera: str, from_s: float, to_s: float, path: Path) -> Clip:
        """Raise ``CamerasAway``."""
        raise CamerasAway(f"no clip of {robot_id}/{camera}, {from_s} to {to_s}, at {path}")

    async def frame(self, robot_id: str, camera: str, data: bytes, age_s: float) -> None:
        """Do nothing."""
