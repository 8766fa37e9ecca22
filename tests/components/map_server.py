"""Serve a page with the live map, its geometry and a lane that the test moves by hand; loopback only."""

from __future__ import annotations

import json
import mimetypes
import threading
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

STATIC = Path(__file__).resolve().parents[2] / "static"
NONCE = "bWFwLXRlc3Q"
CSP = (
    f"default-src 'self'; img-src 'self' data:; "
    f"script-src 'self' 'nonce-{NONCE}' 'unsafe-eval'; worker-src 'self' blob:; "
    "object-src 'none'; base-uri 'none'; frame-ancestors 'self'"
)

LANE = """
(() => {
  // the part of window.headland the map reads, with the same units; time and state move only when the test says so
  const listeners = new Map(), states = new Map();
  let revision = 0, time = 1000;
  const now = () => time;
  window.headland = {
    on(topic, fn) {
      if (!listeners.has(topic)) listeners.set(topic, new Set());
      listeners.get(topic).add(fn);
      if (states.has(topic)) fn(states.get(topic), topic, null);
      return () => listeners.get(topic).delete(fn);
    },
    state: (topic) => states.get(topic),
    now,
    age: (t) => (t === null || t === undefined ? null : Math.max(0, (now() - t) / 1000)),
    revision: () => revision,
  };
  window.lane = {
    put(topic, groups) {
      revision += 1;
      states.set(topic, { ...states.get(topic), ...groups });
      const names = Object.keys(groups.robots ?? groups); // as lane.js tells lists of robots
      for (const fn of listeners.get(topic) ?? []) fn(states.get(topic), topic, names);
      return revision;
    },
    pose(robot, lon, lat, heading_deg, speed_mps = 0.4) {
      time += 100;
      return this.put(`robot/${robot}`, { pose: { t: now(), lon, lat, heading_deg, speed_mps, accuracy_m: 0.02 } });
    },
    pass(ms) { time += ms; },
  };
})();
"""

PAGE = """<!doctype html><html lang="en" data-theme="{theme}"><head><meta charset="utf-8"><title>Map</title>
<meta name="viewport" content="width=device-width, initial-scale=1">
<link rel="icon" href="data:,">
<link rel="stylesheet" href="/static/css/tokens.css"><link rel="stylesheet" href="/static/css/base.css">
<link rel="stylesheet" href="/static/js/map/map.css">
<link rel="stylesheet" href="/static/vendor/maplibre/maplibre-gl-core.css">
<link rel="stylesheet" href="/page.css"></head><body><main><div id="map" data-testid="map"></div></main>
<script nonce="{nonce}">{lane}</script>
<script type="module" nonce="{nonce}">
import {{ LiveMap, publish }} from '/static/js/map/live_map.js';
const options = {options};
window.selected = [];
const onSelect = (id) => window.selected.push(id);
const vendorUrl = '/static/vendor/maplibre';
const map = new LiveMap(document.getElementById('map'), {{ vendorUrl, ...options, onSelect }});
publish(map);
window.map = map;
await map.start();
window.isStarted = true;
</script></body></html>"""

PAGE_CSS = "html,body{height:100%;margin:0;overflow:hidden}main{position:fixed;inset:0}"


class MapServer:
    """A loopback server; ``answers`` maps paths to functions giving (status, content type, body)."""

    def __init__(self) -> None:
        self.answers: dict[str, Callable[[], tuple[int, str, bytes]]] = {}
        self.requests: list[str] = []
        server = self

        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def do_GET(self) -> None:
                server.requests.append(self.path)
                status, kind, body = server._answer(self.path)
                self.send_response(status)
                self.send_header("Content-Type", kind)
                self.send_header("Content-Length", str(len(body)))
                self.send_header("Content-Security-Policy", CSP)
                self.end_headers()
                self.wfile.write(body)

            def log_message(self, *_args: object) -> None:
                """Keep the test output clean."""

        self._http = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self._http.daemon_threads = True
        self._thread = threading.Thread(target=self._http.serve_forever, name="map-server", daemon=True)
        self._thread.start()
        self.origin = f"http://127.0.0.1:{self._http.server_address[1]}"

    def json(self, path: str, value: Any, status: int = 200) -> None:
        """Answer ``path`` with JSON from now on."""
        body = json.dumps(value).encode()
        self.answers[path] = lambda: (status, "application/json", body)

    def page(self, path: str, *, theme: str = "day", **options: Any) -> str:
        """Serve a page with a map at ``path`` and return its address."""
        body = PAGE.format(theme=theme, nonce=NONCE, lane=LANE, options=json.dumps(options)).encode()
        self.answers[path] = lambda: (200, "text/html; charset=utf-8", body)
        return self.origin + path

    def _answer(self, target: str) -> tuple[int, str, bytes]:
        path = urlsplit(target).path
        if path in self.answers:
            return self.answers[path]()
        if path == "/page.css":
            return 200, "text/css", PAGE_CSS.encode()
        file = (STATIC / path.removeprefix("/static/")).resolve()
        if path.startswith("/static/") and file.is_relative_to(STATIC) and file.is_file():
            kind = "text/javascript" if file.suffix in (".js", ".mjs") else mimetypes.guess_type(file)[0]
            return 200, kind or "application/octet-stream", file.read_bytes()
        return 404, "text/plain", b"no such page"

    def close(self) -> None:
        """End the server and its thread."""
        self._http.shutdown()
        self._http.server_close()
        self._thread.join()
