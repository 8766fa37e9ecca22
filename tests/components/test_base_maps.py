"""What lies under the live map, in Chromium: a photo at its place, and a word where there is none."""

from __future__ import annotations

import io
import math
import time
from collections.abc import Iterator

import pytest
from PIL import Image
from playwright.sync_api import Browser, Page, ViewportSize, expect

from tests.components import map_field
from tests.components.map_page import BODY, ROBOT, MapPage
from tests.components.map_server import MapServer

pytestmark = pytest.mark.browser

LIST = "/api/v1/base-maps"
SIZE: ViewportSize = {"width": 720, "height": 520}
ZOOM = 18
TILES_S = 10.0
RED, BLUE = (210, 40, 40), (40, 40, 210)


@pytest.fixture(scope="module")
def map_server() -> Iterator[MapServer]:
    server = MapServer()
    yield server
    server.close()


def tile_of(lon: float, lat: float) -> tuple[int, int]:
    """Return the tile that holds a position."""
    y = 0.5 - math.log(math.tan(math.pi / 4 + math.radians(lat) / 2)) / (2 * math.pi)
    return int((lon + 180) / 360 * 2**ZOOM), int(y * 2**ZOOM)


def centre_of(x: int, y: int) -> tuple[float, float]:
    """Return the position in the middle of a tile."""
    lat = math.degrees(2 * math.atan(math.exp((0.5 - (y + 0.5) / 2**ZOOM) * 2 * math.pi)) - math.pi / 2)
    return (x + 0.5) / 2**ZOOM * 360 - 180, lat


def colour_of(x: int, y: int) -> tuple[int, int, int]:
    """Return the colour of a tile of the chessboard that is served as a photo."""
    return RED if (x + y) % 2 else BLUE


def serve_photo(server: MapServer, status: int = 200, reach_deg: float = 0.02) -> tuple[int, int]:
    """Serve a photo whose tiles are a chessboard; returns the tile under the robot."""
    server.json("/api/v1/features", map_field.farm())
    server.json(f"/api/v1/robots/{ROBOT}/mission.geojson", map_field.mission())
    lon, lat, _ = map_field.row_point(37, 0.4)
    middle = tile_of(lon, lat)
    one = {
        "id": "photo1", "name": "Spring flight", "kind": "photo", "schema": "", "credit": "© Drone", "tile_px": 256,
        "bounds": [lon - reach_deg, lat - reach_deg, lon + reach_deg, lat + reach_deg], "min_zoom": ZOOM,
        "max_zoom": ZOOM, "is_there": True, "size_bytes": 1, "by": "P", "added_utc": "2026-05-01T00:00:00Z",
    }  # fmt: skip
    server.json(LIST, {"maps": [one], "online": None, "work": [], "room": {}})
    for x in range(middle[0] - 6, middle[0] + 7):
        for y in range(middle[1] - 6, middle[1] + 7):
            out = io.BytesIO()
            Image.new("RGB", (256, 256), colour_of(x, y)).save(out, "PNG")
            body = out.getvalue() if status == 200 else b"{}"  # a picture is a picture, whatever the status says
            server.answers[f"{LIST}/photo1/{ZOOM}/{x}/{y}"] = lambda body=body: (status, "image/png", body)  # type: ignore[misc]
    return middle


def chosen(page: Page, server: MapServer, base: str = "photo1") -> MapPage:
    """Return a map whose browser remembers a base map."""
    page.set_viewport_size(SIZE)
    page.add_init_script(f"localStorage.setItem('headland.map.base', '{base}')")
    return MapPage(page, server)


def beside_a_field(the_map: MapPage) -> None:
    """Put a robot without a mission in the field: its rows would cover the photo."""
    lon, lat, heading = map_field.row_point(37, 0.4)
    the_map.put(id={"id": ROBOT, "name": "Weeder 01", "family": "weeder"}, body=BODY)
    the_map.pose(lon, lat, heading)
    the_map.settle()


def check_chessboard(the_map: MapPage, middle: tuple[int, int]) -> None:
    """Look at the middle of the tiles on the screen: red or blue, washed out but told apart."""
    the_map.page.wait_for_function("map.base?.drawn && !map.base.note")
    wrong, until_s = odd_tiles(the_map, middle), time.monotonic() + TILES_S  # tiles come after the first picture
    while wrong and time.monotonic() < until_s:
        wrong = odd_tiles(the_map, middle)
    assert not wrong


def odd_tiles(the_map: MapPage, middle: tuple[int, int]) -> dict[tuple[int, int], object]:
    """Return the tiles whose middle has not their colour, with what it has."""
    the_map.settle()
    pixels = the_map.pixels()
    found: dict[tuple[int, int], object] = {}
    seen = 0
    for right in (-2, -1, 0, 1, 2):
        for down in (-1, 0, 1):
            tile = middle[0] + right, middle[1] + down
            x, y = the_map.place(*centre_of(*tile))
            if not (20 < x < SIZE["width"] - 100 and 20 < y < SIZE["height"] - 60) or math.hypot(x - 360, y - 260) < 60:
                continue
            red, _, blue = pixels.at(x, y)[:3]
            if not ((red > blue + 25) if colour_of(*tile) == RED else (blue > red + 25)):
                found[tile] = pixels.at(x, y)
            seen += 1
    assert seen >= 3
    return found


def test_a_photo_lies_at_its_place_under_the_field_without_webgl(plain_browser: Browser, map_server: MapServer) -> None:
    middle = serve_photo(map_server)
    page = plain_browser.new_page()
    the_map = chosen(page, map_server)
    the_map.open()
    beside_a_field(the_map)
    check_chessboard(the_map, middle)
    assert the_map.state()["engine"] == "canvas"
    expect(page.get_by_test_id("map-credit")).to_have_text("© Drone")
    page.get_by_test_id("map-layers").click()
    page.get_by_test_id("map-base-plain").check()
    expect(page.get_by_test_id("map-credit")).to_be_hidden()
    assert page.evaluate("localStorage.getItem('headland.map.base')") == ""
    page.close()


@pytest.mark.long
def test_a_photo_lies_at_its_place_under_the_field(page: Page, map_server: MapServer) -> None:
    middle = serve_photo(map_server)
    the_map = chosen(page, map_server)
    the_map.open()
    beside_a_field(the_map)
    check_chessboard(the_map, middle)
    assert the_map.state()["engine"] == "gl"
    assert not the_map.problems
    assert all(url.startswith(map_server.origin) or url.startswith(("data:", "blob:")) for url in the_map.urls)


def test_a_photo_that_does_not_load_says_so_and_plain_ground_stays(
    plain_browser: Browser, map_server: MapServer
) -> None:
    serve_photo(map_server, status=503)
    page = plain_browser.new_page()
    the_map = chosen(page, map_server)
    the_map.open()
    beside_a_field(the_map)
    notice = page.get_by_test_id("map-notice")
    expect(notice).to_contain_text("Photo did not load. Showing plain ground.")
    ground = the_map.token("--hl-m-ground")
    assert the_map.pixels().at(30, 30)[:3] in (ground[:3], the_map.token("--hl-m-parcel")[:3])
    serve_photo(map_server)
    page.evaluate("map.base.retry()")
    expect(notice).not_to_contain_text("did not load")
    page.close()


@pytest.mark.long
def test_a_failing_photo_says_so_with_webgl_too(page: Page, map_server: MapServer) -> None:
    serve_photo(map_server, status=503)
    the_map = chosen(page, map_server)
    the_map.open()
    beside_a_field(the_map)
    expect(page.get_by_test_id("map-notice")).to_contain_text("Photo did not load. Showing plain ground.")


@pytest.mark.long
@pytest.mark.parametrize(
    ("base", "reach_deg", "words"),
    [("photo1", 0.0002, "covers only part"), ("gone", 0.02, "not there any more")],
)
def test_what_a_photo_does_not_cover_is_said(
    plain_browser: Browser, map_server: MapServer, base: str, reach_deg: float, words: str
) -> None:
    serve_photo(map_server, reach_deg=reach_deg)
    page = plain_browser.new_page()
    the_map = chosen(page, map_server, base)
    the_map.open()
    beside_a_field(the_map)
    expect(page.get_by_test_id("map-notice")).to_contain_text(words)
    page.close()


@pytest.mark.long
def test_a_list_that_does_not_load_is_said_on_map_and_menu(plain_browser: Browser, map_server: MapServer) -> None:
    serve_photo(map_server)
    map_server.json(LIST, {"code": "down"}, status=503)
    page = plain_browser.new_page()
    the_map = chosen(page, map_server)
    the_map.open()
    beside_a_field(the_map)
    expect(page.get_by_test_id("map-notice")).to_contain_text("Base map did not load. Showing plain ground.")
    page.get_by_test_id("map-layers").click()
    expect(page.get_by_test_id("map-base")).to_contain_text("did not load")
    page.close()
