"""A robot's camera server as the protocol has it: real HTTP on loopback, pictures made once."""

from __future__ import annotations

import io
import json
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from PIL import Image, ImageDraw

TOKEN = "token-of-the-robot"


def jpeg(width: int = 640, height: int = 480, number: int = 0) -> bytes:
    """Return a field with a square that moves."""
    image = Image.new("RGB", (width, height), (92, 118, 61))
    draw = ImageDraw.Draw(image)
    for row in range(6):
        x = width * row // 6
        draw.line((x, height, width // 2 + (x - width // 2) // 4, 0), fill=(52, 90, 30), width=max(1, width // 60))
    side = max(4, width // 16)
    x = number * side // 2 % max(1, width - side)
    draw.rectangle((x, height // 2, x + side, height // 2 + side), fill=(230, 210, 60))
    out = io.BytesIO()
    image.save(out, "JPEG", quality=80)
    return out.getvalue()


class FakeCamera:
    """What the server sends; change the fields while it runs."""

    def __init__(self, width: int = 640, height: int = 480, fps: float = 15.0) -> None:
        self.fps, self.age_ms = fps, 5.0
        self.waited_ms = 0.0  # in the send buffer, after the age was written
        self.waits_longer = 0.0  # by this share of the time between two pictures, with each of them
        self.line_s = 0.0  # that everything it sends is under way
        self.pictures = [jpeg(width, height, number) for number in range(10)]
        self.narrow: list[bytes] | None = None  # for who asks for a width
        self.instead: bytes | None = None
        self.refusal: tuple[int, bytes] | None = None
        self.says_asked = True
        self.is_frozen = False
        self.is_hung = False
        self.is_dripping = False  # line ends while it is frozen
        self.shots = 0
        self.asked: list[dict[str, str]] = []
        self.orders: list[dict[str, Any]] = []
        self.setting: dict[str, Any] | None = {"lamp": True, "zoom": 3.0}
        self.open = 0
        self.url = ""


@contextmanager
def fake_camera(camera: FakeCamera) -> Iterator[FakeCamera]:
    """Serve ``camera`` at ``camera.url`` (the robot's address) until left."""
    server = ThreadingHTTPServer(("127.0.0.1", 0), _handler(camera))
    server.daemon_threads = True
    thread = threading.Thread(target=server.serve_forever, args=(0.05,), daemon=True)
    thread.start()
    camera.url = f"http://127.0.0.1:{server.server_port}/weeder-01"
    try:
        yield camera
    finally:
        server.shutdown()
        server.server_close()


def _handler(camera: FakeCamera) -> type[BaseHTTPRequestHandler]:
    """Return what answers each request to ``camera``."""
    return type("Handler", (_Handler,), {"camera": camera})


class _Handler(BaseHTTPRequestHandler):
    """Answers for one camera; see ``_handler``."""

    camera: FakeCamera
    protocol_version = "HTTP/1.1"

    def log_message(self, *_args: Any) -> None:
        """Be quiet."""

    def do_GET(self) -> None:
        """Answer stream and still."""
        path, _, query = self.path.partition("?")
        self.camera.asked.append(dict(pair.split("=") for pair in query.split("&") if pair) | {"path": path})
        if self.headers.get("Authorization") != f"Bearer {TOKEN}":
            self._answer(401, b"")
        elif self.camera.refusal is not None:
            self._answer(*self.camera.refusal)
        elif path.endswith("/stream"):
            self._stream("width=" in query)
        elif path.endswith("/control"):
            code = 404 if self.camera.setting is None else 200
            self._answer(code, json.dumps(self.camera.setting or {"code": "unknown", "text": "Not told."}).encode())
        else:
            self.camera.shots += not self.camera.is_hung
            self._answer(200, self.camera.pictures[self.camera.shots % len(self.camera.pictures)], "image/jpeg")

    def do_POST(self) -> None:
        """Take an order."""
        length = int(self.headers.get("Content-Length", "0"))
        self.camera.orders.append(json.loads(self.rfile.read(length)))
        self.send_response(204)
        self.end_headers()

    def _answer(self, status: int, body: bytes, kind: str = "application/json") -> None:
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def _stream(self, is_narrow: bool) -> None:
        self.send_response(200)
        self.send_header("Content-Type", "multipart/x-mixed-replace; boundary=frame")
        if self.camera.says_asked:
            self.send_header("X-Asked-Ms", f"{time.time() * 1000:.0f}")
        self.end_headers()
        time.sleep(self.camera.line_s)
        self.close_connection = True
        self.camera.open += 1
        number = 0
        try:
            while self.camera.refusal is None:
                if not self.camera.is_frozen:
                    self._part(number, is_narrow)
                    number += 1
                elif self.camera.is_dripping:
                    self.wfile.write(b"\r\n")
                time.sleep(1.0 / self.camera.fps)
        except OSError:
            return
        finally:
            self.camera.open -= 1

    def _part(self, number: int, is_narrow: bool) -> None:
        pictures = self.camera.narrow if is_narrow and self.camera.narrow else self.camera.pictures
        body = self.camera.instead if self.camera.instead is not None else pictures[number % len(pictures)]
        self.camera.waited_ms += self.camera.waits_longer * 1000 / self.camera.fps
        taken_ms = time.time() * 1000 - self.camera.age_ms - self.camera.waited_ms - self.camera.line_s * 1000
        head = (
            f"--frame\r\nContent-Type: image/jpeg\r\nContent-Length: {len(body)}\r\n"
            f"X-Captured-Ms: {taken_ms:.0f}\r\nX-Age-Ms: {self.camera.age_ms}\r\n\r\n"
        )
        self.wfile.write(head.encode() + body + b"\r\n")
