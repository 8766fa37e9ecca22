"""A page with the drawing surface of the map builder, and what a test does on it."""

from __future__ import annotations

import json
import math
from typing import Any

from playwright.sync_api import Page

from tests.components.map_server import NONCE, MapServer
from tests.components.screen_pixels import Colour, from_hex

Position = tuple[float, float]
EAST_M = 111_412.84 * math.cos(math.radians(51.785)) - 93.5 * math.cos(3 * math.radians(51.785))
NORTH_M = 111_132.95 - 559.85 * math.cos(2 * math.radians(51.785))
ORIGIN = (4.2550, 51.7850)

PAGE = """<!doctype html><html lang="en" data-theme="{theme}"><head><meta charset="utf-8"><title>Map builder</title>
<meta name="viewport" content="width=device-width, initial-scale=1">
<link rel="icon" href="data:,">
<link rel="stylesheet" href="/static/css/tokens.css"><link rel="stylesheet" href="/static/css/base.css">
<link rel="stylesheet" href="/static/js/map/map.css">
<link rel="stylesheet" href="/static/js/editor/editor.css">
<link rel="stylesheet" href="/static/vendor/maplibre/maplibre-gl-core.css">
<link rel="stylesheet" href="/page.css"></head><body><main><div id="map" data-testid="map-editor"></div></main>
<script type="module" nonce="{nonce}">
import {{ MapEditor }} from '/static/js/editor/map_editor.js';
const heard = {{ select: [], change: [], measure: [], drawn: [], point: [], notice: [] }};
const hear = (name) => (value) => heard[name].push(structuredClone(value));
const editor = new MapEditor(document.getElementById('map'), {{
  vendorUrl: '/static/vendor/maplibre', ...{options},
  onSelect: hear('select'), onChange: hear('change'), onMeasure: hear('measure'), onDrawn: hear('drawn'),
  onPoint: hear('point'), onNotice: hear('notice'),
}});
Object.assign(window, {{ editor, heard }});
await editor.start();
window.isStarted = true;
</script></body></html>"""


def at_m(east: float, north: float) -> list[float]:
    """Return the position so many metres from the origin, as the draft keeps it."""
    return [round(ORIGIN[0] + east / EAST_M, 8), round(ORIGIN[1] + north / NORTH_M, 8)]


def feature(name: str, kind: str, geometry: str, points: Any, **properties: Any) -> dict[str, Any]:
    """Return a feature; ``points`` are metres from the origin, nested as in GeoJSON, rings closed."""

    def placed(node: Any) -> Any:
        return at_m(*node) if isinstance(node[0], (int, float)) else [placed(child) for child in node]

    return {
        "type": "Feature",
        "id": name,
        "properties": {"id": name, "kind": kind, "name": properties.pop("title", ""), **properties},
        "geometry": {"type": geometry, "coordinates": placed(points)},
    }


def ring(*corners: Position) -> list[Position]:
    """Return a closed ring."""
    return [*corners, corners[0]]


def crowd(parcels: int, corners: int) -> list[dict[str, Any]]:
    """Return round parcels side by side, each with so many corners."""
    side = math.ceil(math.sqrt(parcels))
    made = []
    for number in range(parcels):
        middle = ((number % side) * 90.0, (number // side) * 90.0)
        angles = [2 * math.pi * i / corners for i in range(corners)]
        shape = ring(*((middle[0] + 40 * math.cos(a), middle[1] + 40 * math.sin(a)) for a in angles))
        made.append(feature(f"parcel-{number:08x}", "parcel", "Polygon", [shape], row_bearing_deg=9, headland_m=3))
    return made


class EditorPage:
    """Opens the drawing surface, and draws on it with mouse, keys and fingers."""

    def __init__(self, page: Page, server: MapServer) -> None:
        self.page = page
        self.server = server
        self.problems: list[str] = []
        page.on("pageerror", lambda error: self.problems.append(str(error)))
        page.on("console", lambda m: self.problems.append(m.text) if m.type == "error" else None)
        self._session: Any = None

    def open(self, features: list[dict[str, Any]], *, theme: str = "day", **options: Any) -> None:
        """Open the surface with a draft and wait until it is ready."""
        body = PAGE.format(theme=theme, nonce=NONCE, options=json.dumps(options)).encode()
        self.server.answers["/editor"] = lambda: (200, "text/html; charset=utf-8", body)
        self.page.goto(f"{self.server.origin}/editor")
        self.page.wait_for_function("window.isStarted")
        self.page.evaluate("(features) => editor.setFeatures(features)", features)
        self.settle()

    def call(self, script: str, argument: Any = None) -> Any:
        """Run a line with ``editor`` and ``it``, the argument."""
        return self.page.evaluate(f"(it) => {{ {script} }}", argument)

    def heard(self, name: str) -> list[Any]:
        """Return what the surface said so far."""
        found: list[Any] = self.page.evaluate("(name) => heard[name]", name)
        return found

    def settle(self) -> None:
        """Wait until the map and the drawing on it have been painted."""
        self.page.evaluate(
            """() => new Promise((done) => {
                const { bench } = editor;
                const map = bench.surface.engine.map;
                let left = 3;
                const look = () => {
                    const isIdle = !map || (map.areTilesLoaded() && !map.isMoving() && !bench.bed.later);
                    if (isIdle) left -= 1;
                    if (left <= 0) done();
                    else { bench.repaint(); requestAnimationFrame(look); }
                };
                look();
            })"""
        )

    def token(self, name: str) -> Colour:
        """Return a colour of the theme in force."""
        value: str = self.page.evaluate(
            "(name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim()", name
        )
        return from_hex(value)

    def place(self, position: list[float]) -> Position:
        """Return where a position is on the screen."""
        x, y = self.page.evaluate("(position) => editor.project(position)", position)
        return x, y

    def px(self, east: float, north: float) -> Position:
        """Return where a point in metres is on the screen."""
        return self.place(at_m(east, north))

    def click(self, east: float, north: float, *, is_shifted: bool = False) -> None:
        """Click with the mouse, late enough not to be the second half of a double click."""
        self.page.wait_for_timeout(360)
        self.page.mouse.move(*self.px(east, north))
        if is_shifted:
            self.page.keyboard.down("Shift")
        self.page.mouse.click(*self.px(east, north))
        if is_shifted:
            self.page.keyboard.up("Shift")

    def drag(self, start: Position, end: Position, steps: int = 8) -> None:
        """Drag with the mouse between two places of the screen."""
        self.page.mouse.move(*start)
        self.page.mouse.down()
        self.page.mouse.move(*end, steps=steps)
        self.page.mouse.up()

    def touch(self, kind: str, *places: Position) -> None:
        """Send fingers: ``touchStart``, ``touchMove`` or ``touchEnd`` with all that are down."""
        self._session = self._session or self.page.context.new_cdp_session(self.page)
        points = [{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(places)]
        self._session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    def tap(self, east: float, north: float) -> None:
        """Tap with a finger."""
        self.page.wait_for_timeout(360)
        self.touch("touchStart", self.px(east, north))
        self.touch("touchEnd")
