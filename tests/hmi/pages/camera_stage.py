"""Cameras on stage: a list, the socket of a page with JPEG pictures, and what a test lets go wrong.

The pictures carry the time code of docs/protocols/cameras.md. Direct pictures are refused, as where UDP is closed.
"""

from __future__ import annotations

import asyncio
import contextlib
import io
import struct
from collections.abc import Callable
from typing import Any

from fastapi import APIRouter, Request, Response, WebSocket, WebSocketDisconnect
from fastapi.responses import JSONResponse
from PIL import Image, ImageDraw

HEAD = struct.Struct("<4sBBHdIHH")
CAMERAS: dict[str, dict[str, Any]] = {
    "weeder-07/front": {"label": "Front", "view": "front", "has_lamp": True},
    "weeder-07/rear": {"label": "Rear", "view": "rear"},
    "weeder-01/front": {"label": "Front", "view": "front"},
    "planter-02/head": {"label": "Head", "view": "head", "has_trigger": True},
}
USUAL = {
    "kind": "colour", "width_px": 640, "height_px": 480, "ptz": None, "has_lamp": False, "has_trigger": False,
    "state": "live", "reason": "", "restarts": 0, "viewers": 1, "fps": 15.0, "period_s": 0.067, "kbit_s": 900.0,
    "captured": None, "is_dated": True, "source": "robot",
}  # fmt: skip


class CameraStage:
    """``wish``: ``cameras`` (changes by name), ``none``, ``down``, ``frozen`` (names), ``lag_ms``, ``status``.

    ``setting``: lamp and zoom as the robot says.
    """

    def __init__(self, now_s: Callable[[], float]) -> None:
        self._now_s = now_s
        self.reset()
        self.sockets: set[WebSocket] = set()

    def reset(self) -> None:
        """Begin anew."""
        self.wish: dict[str, Any] = {}
        self.watched: dict[str, dict[str, Any]] = {}
        self.asked: list[str] = []
        self.pictures: list[dict[str, Any]] = []

    def now_ms(self) -> float:
        """Return the console's monotonic clock."""
        return self._now_s() * 1000

    def cameras(self, robot: str | None = None) -> list[dict[str, Any]]:
        """Return what ``GET /cameras`` lists."""
        found = []
        for name, own in {} if self.wish.get("none") else CAMERAS.items():
            robot_id, camera = name.split("/")
            change = self.wish.get("cameras", {}).get(name, {})
            if robot in (None, robot_id):
                found.append({**USUAL, "robot": robot_id, "camera": camera, **own, **change})
        return found

    def camera(self, name: str) -> dict[str, Any]:
        """Return one of them."""
        return next(one for one in self.cameras() if f"{one['robot']}/{one['camera']}" == name)

    def is_flowing(self, name: str) -> bool:
        """Say whether this camera gives pictures now."""
        return name not in self.wish.get("frozen", []) and self.camera(name)["state"] == "live"

    async def serve(self, socket: WebSocket) -> None:
        """Serve one page until it leaves."""
        await socket.accept()
        if self.wish.get("down"):
            await socket.close(4503)
            return
        self.sockets.add(socket)
        streams: dict[int, asyncio.Task[None]] = {}
        await socket.send_json({"k": "hello", "watcher": "w" * 16, "m": self.now_ms()})
        try:
            while True:
                await self._take(socket, await socket.receive_json(), streams)
        except (WebSocketDisconnect, RuntimeError):
            pass
        finally:
            self.sockets.discard(socket)
            for n in list(streams):
                self._end(n, streams)

    async def _take(self, socket: WebSocket, frame: dict[str, Any], streams: dict[int, asyncio.Task[None]]) -> None:
        n = frame.get("n", 0)
        if frame["k"] in ("watch", "drop"):
            self._end(n, streams)
        if frame["k"] == "watch":
            self.watched[f"{n}"] = frame
            streams[n] = asyncio.create_task(self._pictures(socket, n, frame), name=f"stage-camera-{n}")
        elif frame["k"] == "ping":
            await socket.send_json({"k": "pong", "m": frame["m"], "at": self.now_ms()})

    def _end(self, n: int, streams: dict[int, asyncio.Task[None]]) -> None:
        self.watched.pop(f"{n}", None)
        if n in streams:
            streams.pop(n).cancel()

    async def _pictures(self, socket: WebSocket, n: int, frame: dict[str, Any]) -> None:
        name, seq, said = f"{frame['robot']}/{frame['camera']}", 0, None
        period_s = 0.5 if frame["way"] == "still" else 1 / min(15, frame["fps"])
        with contextlib.suppress(WebSocketDisconnect, RuntimeError):
            while True:
                if self.camera(name) != said:
                    said = self.camera(name)
                    await socket.send_json({"k": "state", "n": n, "camera": said})
                if self.is_flowing(name) and frame["way"] != "times":
                    captured, seq = self.now_ms() - 80.0 - self.wish.get("lag_ms", 0), seq + 1
                    flags = 1 if said["is_dated"] else 0
                    head = HEAD.pack(b"HLC1", n, flags, 640, captured, seq, 480, 0)
                    await socket.send_bytes(head + picture(name, captured))
                await asyncio.sleep(period_s)


def picture(name: str, at_ms: float) -> bytes:
    """Return a JPEG of crop rows with the time code."""
    image = Image.new("RGB", (640, 480), (116, 104, 88))
    draw = ImageDraw.Draw(image)
    draw.rectangle((0, 0, 640, 120), fill=(170, 190, 200))
    for row in range(-6, 7):
        draw.line((320 + row * 20, 120, 320 + row * 150, 480), fill=(58, 110, 52), width=14)
    draw.text((20, 440), name, fill=(255, 255, 255))
    for i in range(24):
        bit = (int(at_ms) >> (23 - i)) & 1
        for row, value in ((0, bit), (1, 1 - bit)):
            draw.rectangle((i * 8, row * 8, i * 8 + 7, row * 8 + 7), fill=(255,) * 3 if value else (0,) * 3)
    out = io.BytesIO()
    image.save(out, "JPEG", quality=80)
    return out.getvalue()


def router(stage: CameraStage) -> APIRouter:
    """Return the routes of cameras and those that tests set them by."""
    api = APIRouter()

    @api.post("/stage-cameras")
    async def adjust(request: Request) -> dict[str, Any]:
        wish = await request.json()
        if wish.pop("anew", False):
            stage.reset()
        stage.wish.update(wish)
        if wish.get("down"):
            for socket in list(stage.sockets):
                await socket.close(4503)
        return {}

    @api.get("/stage-cameras")
    async def heard() -> dict[str, Any]:
        return {
            "watched": list(stage.watched.values()),
            "asked": stage.asked,
            "pages": len(stage.sockets),
            "pictures": len(stage.pictures),
        }

    @api.websocket("/cameras/live")
    async def live(socket: WebSocket) -> None:
        await stage.serve(socket)

    @api.get("/api/v1/cameras")
    async def cameras(robot: str | None = None) -> Response:
        if stage.wish.get("status"):
            return JSONResponse({"code": "refused", "text": "Not for you."}, stage.wish["status"])
        if stage.wish.get("down"):
            return JSONResponse({"code": "cameras_down", "text": "The camera process is not running."}, 503)
        return JSONResponse({"cameras": stage.cameras(robot)})

    @api.get("/api/v1/cameras/{robot}/{camera}/control")
    async def setting(robot: str, camera: str) -> dict[str, Any]:
        return {"lamp": None, "zoom": None, **stage.wish.get("setting", {})}

    @api.post("/api/v1/cameras/{robot}/{camera}/{what}")
    async def act(robot: str, camera: str, what: str) -> Response:
        stage.asked.append(f"{robot}/{camera}/{what}")
        if what == "whep":
            return JSONResponse({"code": "no_stream", "text": "This camera has no direct pictures."}, 409)
        if what == "snapshot":
            kept = {"id": f"p-{len(stage.pictures)}", "kind": "snapshot", "robot": robot, "camera": camera}
            kept |= {"robot_name": "Weeder 07", "captured_utc": "2026-05-20T12:36:42.000+00:00", "by": "Martha Keller"}
            kept |= {"lat_deg": 51.75, "lon_deg": 5.75, "file": f"/api/v1/pictures/{kept['id']}/file"}
            stage.pictures.insert(0, kept)
            return JSONResponse(kept, 201)
        return JSONResponse({}, 202)

    @api.get("/api/v1/pictures")
    async def pictures(robot: str = "") -> dict[str, Any]:
        return {"pictures": [one for one in stage.pictures if robot in ("", one["robot"])]}

    @api.patch("/api/v1/pictures/{picture_id}")
    async def change(picture_id: str, request: Request) -> dict[str, Any]:
        one = next(one for one in stage.pictures if one["id"] == picture_id)
        one.update(await request.json())
        return one

    @api.delete("/api/v1/pictures/{picture_id}")
    async def remove(picture_id: str) -> Response:
        stage.pictures = [one for one in stage.pictures if one["id"] != picture_id]
        return Response(status_code=204)

    @api.get("/api/v1/pictures/{picture_id}/file")
    async def file(picture_id: str) -> Response:
        return Response(picture(picture_id, stage.now_ms()), media_type="image/jpeg")

    return api
