"""A live map in a browser page, and what a test asks of it."""

from __future__ import annotations

from typing import Any

from playwright.sync_api import Page

from tests.components import map_field
from tests.components.map_server import MapServer
from tests.components.screen_pixels import Colour, Pixels, from_hex, is_close

ROBOT = "weeder-01"
ROW = 37
BODY = {
    "length_m": 2.4,
    "width_m": 2.8,
    "base_to_front_m": 1.2,
    "keep_out_m": 15,
    "max_speed_mps": 1.6,
}


class MapPage:
    """Opens a map of one robot and moves its lane."""

    def __init__(self, page: Page, server: MapServer) -> None:
        self.page = page
        self.server = server
        self.problems: list[str] = []
        self.urls: list[str] = []
        page.on("request", lambda request: self.urls.append(request.url))
        page.on("pageerror", lambda error: self.problems.append(str(error)))
        page.on("console", lambda m: self.problems.append(m.text) if m.type == "error" else None)

    def open(self, *, theme: str = "day", **options: Any) -> None:
        """Open a map and wait until its engine runs."""
        wanted = {"robotId": ROBOT, **options}
        self.page.goto(self.server.page("/page", theme=theme, **wanted))
        self.page.wait_for_function("window.isStarted && map.intake.farmState !== 'loading'")

    def put(self, topic: str = f"robot/{ROBOT}", **groups: Any) -> None:
        """Send groups of a topic."""
        self.page.evaluate("([topic, groups]) => lane.put(topic, groups)", [topic, groups])

    def describe_robot(self, *, row: int = ROW, sha: str = "a" * 64, status: str = "running") -> None:
        """Say who the robot is and which row it is on."""
        self.put(
            id={"id": ROBOT, "name": "Weeder 01", "family": "weeder"},
            mode={"t": 0, "mode": "auto", "text": "Running"},
            body=BODY,
            mission={"t": 0, "id": "m-1", "status": status, "row": row, "rows": 84, "sha256": sha},
        )
        self.page.wait_for_function("map.intake.missionState === 'loaded'")

    def pose(self, lon: float, lat: float, heading: float = 0.0, speed: float = 0.4) -> None:
        """Report where the robot is, now."""
        self.page.evaluate("(values) => { lane.pose(...values); }", [ROBOT, lon, lat, heading, speed])

    def on_row(self, share: float = 0.4, row: int = ROW) -> tuple[float, float]:
        """Put the robot on a row of the mission; returns (lon, lat)."""
        lon, lat, heading = map_field.row_point(row, share)
        self.describe_robot(row=row)
        self.pose(lon, lat, heading)
        self.settle()
        return lon, lat

    def settle(self) -> None:
        """Wait until a picture was drawn after everything sent so far."""
        self.page.evaluate(
            """() => new Promise((done) => {
                const { engine } = map;
                const first = map.frameNumber;
                const look = () => {
                    const isIdle = engine.kind === 'canvas' || (engine.map.areTilesLoaded() && !engine.map.isMoving());
                    const isDrawn = map.frameNumber > first + 1 && !map.gliding && !map.later;
                    if (isIdle && isDrawn) requestAnimationFrame(done);
                    else { engine.redraw(); setTimeout(look, 50); }
                };
                look();
            })"""
        )

    def hide_names(self) -> None:
        """Take the texts off the map: they lie over what a test looks at."""
        self.page.evaluate("map.shown.labels = false")
        self.settle()

    def state(self) -> dict[str, Any]:
        """Return what the map says about itself."""
        found: dict[str, Any] = self.page.evaluate("headlandMap.state()")
        return found

    def place(self, lon: float, lat: float) -> tuple[float, float]:
        """Return where a point of the ground is drawn, in px of the viewport."""
        x, y = self.page.evaluate("([lon, lat]) => headlandMap.project(lon, lat)", [lon, lat])
        return x, y

    def pixels(self) -> Pixels:
        """Return what is on screen."""
        return Pixels(self.page)

    def token(self, name: str) -> Colour:
        """Return a colour of the theme in force."""
        value: str = self.page.evaluate(
            "(name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim()", name
        )
        return from_hex(value)

    def share_of(self, pixels: Pixels, colour: Colour, points: list[tuple[float, float]], tolerance: int = 24) -> float:
        """Return how many of ``points`` (lon, lat) on screen show ``colour``."""
        seen = [self.place(*point) for point in points]
        seen = [(x, y) for x, y in seen if 0 <= x < pixels.width - 90 and 0 <= y < pixels.height - 40]
        assert len(seen) >= 20, "too few points are on screen to tell"
        return sum(is_close(pixels.at(x, y), colour, tolerance) for x, y in seen) / len(seen)


def along_row(row: int, start: float, end: float, count: int = 120) -> list[tuple[float, float]]:
    """Return points (lon, lat) along a row."""
    shares = [start + (end - start) * i / (count - 1) for i in range(count)]
    return [map_field.row_point(row, share)[:2] for share in shares]
