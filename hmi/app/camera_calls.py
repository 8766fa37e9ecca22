"""The camera process as keeping pictures needs it, over its HTTP; see docs/protocols/cameras.md."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Protocol

import httpx
import msgspec

from hmi.app.camera_link import CamerasDown
from hmi.app.cameras import CLIPS, CameraDesk
from hmi.commands.camera_ports import CamerasAway, Clip, NoPicture, Still

CAPTURED, DATED = "X-Headland-Captured", "X-Headland-Dated"
RING_FPS, RING_WIDTH_PX = 5, 640  # enough to see what happened; a camera that is watched is kept as it is watched
STILL_S, CLIP_S, SHORT_S = 5.0, 30.0, 3.0
_TEXTS = {
    "unknown_camera": "There is no such camera.",
    "no_picture": "The camera shows no picture now.",
    "nothing_kept": "Nothing was recorded.",
    "disk_full": "The disk of the server has no room.",
}


class Ask(Protocol):
    """Sends a request to the camera process wherever it listens now."""

    async def __call__(self, method: str, path: str, content: bytes | None, limit_s: float) -> httpx.Response:
        """Return the answer, whatever its status; raises ``CamerasAway``."""
        ...


class CameraCalls:
    """See ``hmi.commands.camera_ports.CameraProcess``.

    Args:
        is_open: whether any page shows pictures; while none does, nobody is asked who looks.
    """

    def __init__(self, ask: Ask, is_open: Callable[[], bool] = lambda: True) -> None:
        self._ask, self._is_open = ask, is_open

    async def still(self, robot_id: str, camera: str, fresh_s: float | None, *, is_full: bool = False) -> Still:
        """Return the newest picture."""
        path = f"/cameras/{robot_id}/{camera}/still"
        if fresh_s is None:
            reply = _good(await self._ask("GET", path, None, STILL_S))
        else:
            reply = await self._opened(f"{path}?fresh_s={fresh_s:g}{'&full=true' if is_full else ''}")
        try:
            captured_s = float(reply.headers[CAPTURED]) / 1000.0
            return Still(reply.content, captured_s, is_dated=reply.headers.get(DATED) != "0")
        except (KeyError, ValueError) as error:
            raise CamerasAway("it told no capture time") from error

    async def _opened(self, path: str) -> httpx.Response:
        """Ask twice: on a busy machine a camera that nobody looked at takes longer to open than one answer waits."""
        try:
            return _good(await self._ask("GET", path, None, STILL_S))
        except NoPicture as error:
            if error.code != "no_picture":
                raise
        return _good(await self._ask("GET", path, None, STILL_S))

    async def record(self, cameras: Sequence[tuple[str, str]]) -> None:
        """Say which cameras keep their last minute."""
        wanted = [{"robot": r, "camera": c, "fps": RING_FPS, "width": RING_WIDTH_PX} for r, c in cameras]
        _good(await self._ask("PUT", "/recording", msgspec.json.encode({"cameras": wanted}), SHORT_S))

    async def watched(self) -> list[tuple[str, str]]:
        """Return the cameras somebody looks at."""
        if not self._is_open():
            return []
        found = _told(_good(await self._ask("GET", "/cameras", None, SHORT_S))).get("cameras")
        cameras = [one for one in found if isinstance(one, dict)] if isinstance(found, list) else []
        return [(str(one.get("robot")), str(one.get("camera"))) for one in cameras if one.get("viewers")]

    async def clip(self, robot_id: str, camera: str, from_s: float, to_s: float, path: Path) -> Clip:
        """Have a clip written."""
        body = {
            "robot": robot_id,
            "camera": camera,
            "from": from_s * 1000.0,
            "to": to_s * 1000.0,
            "path": str(path),
        }
        reply = _good(await self._ask("POST", CLIPS, msgspec.json.encode(body), CLIP_S))
        told = _told(reply)
        try:
            return Clip(float(told["from"]) / 1000.0, float(told["to"]) / 1000.0, int(told["width_px"]),
                        int(told["height_px"]), told.get("has_gap") is True,
                        told.get("is_dated") is not False, told.get("has_before") is True)  # fmt: skip
        except (KeyError, TypeError, ValueError) as error:
            raise CamerasAway("its answer is not understood") from error

    async def frame(self, robot_id: str, camera: str, data: bytes, age_s: float) -> None:
        """Hand over a frame."""
        path = f"/cameras/{robot_id}/{camera}/frame?age_ms={age_s * 1000:.0f}"
        _good(await self._ask("POST", path, data, SHORT_S))


def camera_calls(desk: CameraDesk) -> CameraCalls:
    """Return the calls over the console's link to the camera process."""

    async def ask(method: str, path: str, content: bytes | None, limit_s: float) -> httpx.Response:
        try:
            return await desk.call(method, path, content, limit_s)
        except CamerasDown as down:
            raise CamerasAway(str(down)) from down

    return CameraCalls(ask, lambda: desk.is_open)


def _good(reply: httpx.Response) -> httpx.Response:
    if reply.is_success:
        return reply
    if reply.status_code >= 500 and reply.status_code != 507:
        raise CamerasAway(f"it answered {reply.status_code}")
    told = _told(reply)
    code = str(told.get("code") or ("no_picture" if reply.status_code == 404 else "refused"))
    raise NoPicture(code, str(told.get("text") or _TEXTS.get(code, "The camera process refused.")))


def _told(reply: httpx.Response) -> dict[str, Any]:
    try:
        told = msgspec.json.decode(reply.content)
    except msgspec.DecodeError:
        return {}
    return told if isinstance(told, dict) else {}
