"""A page with nothing but the STOP slab, its server, and robots that live in a thread beside the browser's test."""

from __future__ import annotations

import asyncio
import json
import threading
from collections.abc import Coroutine
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any, TypeVar

from components.stop_slab import StopConfig, head_html
from tests.hmi.stop_gateway.fake_robot import FakeRobot

ROOT = Path(__file__).parents[2]
KINDS = {".js": "text/javascript", ".css": "text/css", ".woff2": "font/woff2"}
T = TypeVar("T")

PAGE = """<!doctype html><html lang="en" data-theme="{theme}"><head><meta charset="utf-8">
<meta name="viewport" content="width=device-width"><title>STOP</title>
<link rel="stylesheet" href="/static/css/tokens.css">
<style>@font-face{{font-family:"Inter Variable";src:url(/static/fonts/inter-latin.woff2);font-weight:100 900}}
body{{margin:0;background:var(--hl-bg)}}.dock{{position:fixed;left:0;right:0;bottom:0;height:var(--hl-dock-h);
background:var(--hl-surface);border-top:1px solid var(--hl-line-2);box-sizing:border-box}}
.side{{position:absolute;right:8px;top:80px;width:327px}}</style>{head}</head><body>
<div id="q-app"><div class="dock"></div><div class="side" id="card"></div></div></body></html>"""


class StopPage:
    """Serves the page as the console would; ``steps`` answers its second path, ``None`` for a dead console."""

    def __init__(self, config: StopConfig | None = None) -> None:
        self.config = config or StopConfig()
        self.theme = "day"
        self.second_path: list[dict[str, Any]] | None = None
        self.second_path_presses: list[dict[str, Any]] = []
        page = self

        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def do_GET(self) -> None:
                path = self.path.partition("?")[0]
                if path == "/":
                    self.say(200, "text/html", page.html().encode())
                elif path.startswith("/static/") and (file := ROOT / path[1:]).is_file():
                    self.say(200, KINDS.get(file.suffix, "text/plain"), file.read_bytes())
                else:
                    self.say(404, "text/plain", b"")

            def do_POST(self) -> None:
                body = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
                if self.path != "/api/v1/stop" or page.second_path is None:
                    self.say(503, "application/json", b"{}")
                    return
                page.second_path_presses.append({**body, "authorization": self.headers["Authorization"]})
                steps = [{**step, "stop_id": body["stop_id"]} for step in page.second_path]
                self.say(202, "application/json", json.dumps({"steps": steps}).encode())

            def say(self, status: int, kind: str, body: bytes) -> None:
                self.send_response(status)
                self.send_header("Content-Type", kind)
                self.send_header("Content-Length", str(len(body)))
                self.end_headers()
                self.wfile.write(body)

            def log_message(self, *_: object) -> None:
                """Say nothing."""

        self._server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self._server.daemon_threads = True
        self.port = self._server.server_address[1]
        self.url = f"http://127.0.0.1:{self.port}/"
        threading.Thread(target=self._server.serve_forever, kwargs={"poll_interval": 0.05}, daemon=True).start()

    def html(self) -> str:
        """Return the page."""
        return PAGE.format(theme=self.theme, head=head_html(self.config))

    def close(self) -> None:
        """Stop serving."""
        self._server.shutdown()
        self._server.server_close()


class RobotThread:
    """An event loop in a thread, where robots live while the test drives a browser."""

    def __init__(self, broker_url: str) -> None:
        self._broker_url = broker_url
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()
        self._robots: list[FakeRobot] = []

    def make(self, robot_id: str = "weeder-07", **fields: Any) -> FakeRobot:
        """Switch a robot on."""
        robot = self._run(FakeRobot(robot_id, self._broker_url, **fields).start())
        self._robots.append(robot)
        return robot

    def close(self) -> None:
        """Switch everything off."""
        for robot in self._robots:
            self._run(robot.close())
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(2)
        self._loop.close()

    def _run(self, work: Coroutine[Any, Any, T]) -> T:
        return asyncio.run_coroutine_threadsafe(work, self._loop).result(10)
