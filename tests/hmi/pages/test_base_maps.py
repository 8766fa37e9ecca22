"""The panel of base maps on the screen Maps, on a played list; the drawing surface is a stand-in."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import pytest
from playwright.sync_api import Page, Route, expect

from tests.hmi.pages.test_maps import Show
from tests.hmi.pages.test_maps import show as show

pytestmark = [pytest.mark.browser, pytest.mark.long]
PHOTO = {
    "id": "a1", "name": "Spring flight", "kind": "photo", "bounds": [4.25, 51.78, 4.26, 51.785], "min_zoom": 12,
    "max_zoom": 20, "tile_px": 512, "schema": "", "credit": "", "size_bytes": 123_000_000, "by": "Anna",
    "added_utc": "2026-05-01T08:00:00Z", "is_there": True,
}  # fmt: skip
WORK = {
    "id": "b2", "file": "f.tif", "name": "Summer flight", "by": "Anna", "is_mine": True, "state": "working",
    "share": 0.4, "size_bytes": 9, "code": "", "text": "",
}  # fmt: skip
TIFF = {"name": "new.tif", "mimeType": "image/tiff", "buffer": b"II*\0"}


@dataclass
class Shelf:
    """Plays the server's list; ``status`` other than 200 answers nothing else."""

    maps: list[dict[str, Any]] = field(default_factory=list)
    work: list[dict[str, Any]] = field(default_factory=list)
    status: int = 200
    asked: list[tuple[str, str, Any]] = field(default_factory=list)

    def answer(self, route: Route) -> None:
        """Answer one request."""
        request = route.request
        body = request.post_data if request.method == "PATCH" else None
        if request.method != "GET":
            self.asked.append((request.method, request.url.partition("/base-maps")[2], body and json.loads(body)))
        if self.status != 200:
            route.fulfill(status=self.status, json={"code": "x", "text": "It is full."})
        elif request.method == "GET":
            room = {"used_bytes": 123_000_000, "most_bytes": 4_096_000_000, "upload_bytes": 2_048_000_000}
            route.fulfill(json={"maps": self.maps, "work": self.work, "online": None, "room": room})
        elif request.method == "POST":
            self.work.append(WORK)
            route.fulfill(status=202, json=WORK)
        else:
            route.fulfill(status=204)


@pytest.fixture
def panel(show: Show) -> Callable[..., Page]:
    """Open the panel."""

    def open_panel(shelf: Shelf, role: str = "planner") -> Page:
        page = show(role=role)
        page.route("**/api/v1/base-maps**", shelf.answer)
        page.route("**/api/v1/base-maps/*", shelf.answer)
        page.get_by_test_id("editor-layers").click()
        page.get_by_test_id("editor-base-maps").click()
        return page

    return open_panel


def test_maps_are_listed_with_size_and_reach_and_can_be_renamed_and_deleted(panel: Callable[..., Page]) -> None:
    shelf = Shelf([dict(PHOTO)])
    page = panel(shelf)
    row = page.get_by_test_id("base-map-a1")
    expect(row).to_contain_text("0.69 × 0.56 km, 123 MB")
    expect(page.get_by_test_id("base-room")).to_have_text("123 MB of 4.1 GB used")
    page.get_by_test_id("base-rename-a1").click()
    page.get_by_test_id("base-name").fill("April")
    page.get_by_test_id("base-credit").fill("© Drone")
    shelf.maps[0]["name"] = "April"
    page.get_by_test_id("base-save").click()
    expect(row).to_contain_text("April")
    page.get_by_test_id("base-delete-a1").click()
    expect(page.get_by_test_id("base-list")).to_contain_text("Delete April for everybody?")
    shelf.maps.clear()
    page.get_by_test_id("base-delete-yes").click()
    expect(page.get_by_test_id("base-list")).to_contain_text("No base map yet")
    assert shelf.asked == [("PATCH", "/a1", {"name": "April", "credit": "© Drone"}), ("DELETE", "/a1", None)]


def test_an_upload_shows_its_way_and_ends_as_a_map_or_with_the_reason(panel: Callable[..., Page]) -> None:
    shelf = Shelf()
    page = panel(shelf)
    page.get_by_test_id("base-file").set_input_files(TIFF)
    expect(page.get_by_test_id("base-work-b2")).to_contain_text("Preparing 40 %")
    assert shelf.asked == [("POST", "?name=new.tif", None)]
    shelf.work[0] = {**WORK, "state": "failed", "text": "The photo does not say where it lies."}
    expect(page.get_by_test_id("base-work-b2")).to_contain_text("does not say where it lies")
    shelf.work[:] = [WORK]
    expect(page.get_by_test_id("base-cancel-b2")).to_be_visible()
    shelf.work.clear()
    shelf.maps.append({**PHOTO, "id": "b2", "name": "Summer flight"})
    expect(page.get_by_test_id("toast").or_(page.locator(".h-toast")).first).to_contain_text("Summer flight is ready")
    shelf.maps.append(PHOTO)
    expect(page.get_by_test_id("base-map-a1")).to_be_visible()


def test_work_that_a_restart_swallowed_is_said(panel: Callable[..., Page]) -> None:
    shelf = Shelf(work=[WORK])
    page = panel(shelf)
    expect(page.get_by_test_id("base-work-b2")).to_be_visible()
    shelf.work.clear()
    expect(page.get_by_test_id("base-error")).to_contain_text("Summer flight: The server was restarted")


def test_a_wrong_file_and_a_refusal_are_said_at_once(panel: Callable[..., Page]) -> None:
    shelf = Shelf()
    page = panel(shelf)
    expect(page.get_by_test_id("base-list")).to_contain_text("No base map yet")
    page.get_by_test_id("base-file").set_input_files({**TIFF, "name": "photo.jpg"})
    expect(page.get_by_test_id("base-error")).to_contain_text("neither a GeoTIFF (.tif) nor PMTiles")
    shelf.status = 409
    page.get_by_test_id("base-file").set_input_files(TIFF)
    expect(page.get_by_test_id("base-error")).to_contain_text("It is full.")


def test_who_may_not_edit_looks_only_and_a_list_that_fails_offers_to_try_again(panel: Callable[..., Page]) -> None:
    shelf = Shelf([dict(PHOTO)], status=503)
    page = panel(shelf, role="viewer")
    expect(page.get_by_test_id("base-list")).to_contain_text("Base maps did not load")
    shelf.status = 200
    page.get_by_test_id("base-list").get_by_role("button", name="Try again").click()
    expect(page.get_by_test_id("base-map-a1")).to_be_visible()
    expect(page.get_by_test_id("base-add")).to_be_disabled()
    expect(page.get_by_test_id("base-delete-a1")).to_have_count(0)
    expect(page.get_by_test_id("base-maps")).to_contain_text("Needs the planner role")
