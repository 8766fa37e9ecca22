"""What the camera process is told of thousands of robots, and when the console need not even look."""

from __future__ import annotations

from typing import Any

import httpx
import pytest

from hmi.app.camera_link import CamerasDown
from hmi.app.cameras import CLIPS, CameraDesk
from hmi.domain.camera import Source


class Link:
    """The camera process, there or not; keeps what it is asked."""

    def __init__(self, pid: int | None) -> None:
        self._pid = pid
        self.asked: list[tuple[str, str]] = []

    def pid(self) -> int | None:
        """Return which process is spoken to."""
        return self._pid

    async def ask(self, method: str, path: str, *_rest: Any, **_more: Any) -> httpx.Response:
        """Keep it."""
        if self._pid is None:
            raise CamerasDown("it was not started")
        self.asked.append((method, path))
        return httpx.Response(204)


def desk(link: Link) -> tuple[CameraDesk, list[int]]:
    """Return the console's side, and how often it made the list of all sources."""
    made: list[int] = []

    def own() -> list[Source]:
        made.append(1)
        return []

    return CameraDesk(link, own, None, None, None), made  # type: ignore[arg-type]


async def test_without_a_camera_process_no_list_of_all_cameras_is_made() -> None:
    cameras, made = desk(Link(None))
    for path in (CLIPS, "/cameras"):
        with pytest.raises(CamerasDown):
            await cameras.call("POST", path, b"{}", 1.0)
    assert made == []


async def test_a_thousand_clips_of_a_stop_all_make_no_list_each() -> None:
    link = Link(7)
    cameras, made = desk(link)
    for _ in range(1000):
        await cameras.call("POST", CLIPS, b"{}", 1.0)
    assert made == []
    await cameras.call("PUT", "/recording", b"{}", 1.0)
    assert (len(made), link.asked[-2:]) == (1, [("PUT", "/sources"), ("PUT", "/recording")])
