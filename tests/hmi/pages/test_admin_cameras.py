"""Admin's cameras in a browser: where pictures come from is set and tested; REST is played by the test."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Page, Route, expect

Look = Callable[..., Page]
ALLOWED = {"networks": ["192.168.7.0/24"], "hosts": ["10.0.0.17"], "this_machine": False}


class Sources:
    """What the screen is told, and what it sent."""

    def __init__(self, page: Page) -> None:
        self.kept: dict[str, dict[str, Any]] = {}
        self.sent: list[dict[str, Any]] = []
        self.refusal: dict[str, Any] | None = None
        robot = {"id": "weeder-07", "name": "Weeder 07", "family": "weeder"}
        page.route("**/api/v1/robots", lambda route: self.reply(route, {"robots": [robot]}))
        page.route("**/api/v1/robots/new", lambda route: self.reply(route, {"robots": []}))
        live = {"robot": "weeder-07", "camera": "front", "label": "Front", "state": "idle", "reason": ""}
        page.route("**/api/v1/cameras", lambda route: self.reply(route, {"cameras": [live]}))
        page.route("**/api/v1/cameras/sources", lambda route: self.reply(route, {"sources": list(self.kept.values())}))
        page.route("**/api/v1/cameras/*/*/source", self.source)
        page.route(
            "**/api/v1/cameras/*/*/source/test", lambda route: self.reply(route, {"ok": True, "text": "It came."})
        )

    @staticmethod
    def reply(route: Route, body: Any, status: int = 200) -> None:
        """Answer with JSON."""
        route.fulfill(status=status, content_type="application/json", body=json.dumps(body))

    def source(self, route: Route) -> None:
        """Answer about one source, and take what is set."""
        robot, camera = route.request.url.split("/")[-3:-1]
        if route.request.method == "GET":
            if robot == "field" and robot + camera not in self.kept:
                return self.reply(route, {"code": "unknown_camera", "text": "There is none."}, 404)
            fresh = {"robot": robot, "camera": camera, "kind": "robot", "allowed": ALLOWED}
            return self.reply(route, self.kept.get(robot + camera, fresh))
        body = json.loads(route.request.post_data or "{}")
        self.sent.append(body)
        if self.refusal:
            return self.reply(route, self.refusal, 422)
        shown = {key: value for key, value in body.items() if key not in ("password", "new_token")}
        made = {
            "label": "",
            "allowed": ALLOWED,
            **shown,
            "robot": robot,
            "camera": camera,
            "has_password": "password" in body,
        }
        self.kept[robot + camera] = made
        upload = {"token": "token-0123", "upload": f"/api/v1/cameras/{robot}/{camera}/frame"}
        return self.reply(route, {**made, **(upload if body["kind"] == "upload" else {})})


@pytest.fixture
def cameras(look: Look) -> tuple[Page, Sources]:
    """Open Admin's cameras."""
    page = look("/fleet", role="admin")
    sources = Sources(page)
    page.get_by_test_id("nav-admin").click()
    expect(page.get_by_role("heading", name="Registered")).to_be_visible()  # its scripts have come
    page.get_by_test_id("admin-tab-cameras").click()
    return page, sources


def test_a_source_is_set_and_tested_and_its_password_never_comes_back(cameras: tuple[Page, Sources]) -> None:
    page, sources = cameras
    expect(page.get_by_test_id("camera-row-weeder-07-front")).to_contain_text("Weeder 07, Front")
    page.get_by_test_id("camera-change-weeder-07-front").click()
    expect(page.get_by_test_id("source")).to_contain_text("Cameras may be at: 10.0.0.17, 192.168.7.0/24.")
    sources.refusal = {"code": "network", "field": "url", "text": "It is in no network of cameras."}
    page.get_by_test_id("source-url").fill("rtsp://192.168.8.20/stream1")
    page.get_by_test_id("source-password").fill("hunter2")
    page.get_by_test_id("source-save").click()
    expect(page.get_by_test_id("source-url")).to_have_attribute("aria-invalid", "true")
    expect(page.get_by_test_id("source-password")).to_have_value("hunter2")
    sources.refusal = None
    page.get_by_test_id("source-url").fill("rtsp://192.168.7.20/stream1")
    page.get_by_test_id("source-save").click()
    expect(page.get_by_test_id("source-told")).to_have_text("Saved. It came.")
    expect(page.get_by_test_id("source-password")).to_have_value("")
    assert sources.sent[-1] == {"kind": "rtsp", "url": "rtsp://192.168.7.20/stream1", "user": "", "password": "hunter2"}
    expect(page.get_by_test_id("camera-row-weeder-07-front")).to_contain_text(
        "RTSP stream, rtsp://192.168.7.20/stream1"
    )


def test_of_a_still_picture_is_said_how_often_it_is_asked_for(cameras: tuple[Page, Sources]) -> None:
    page, sources = cameras
    page.get_by_test_id("camera-change-weeder-07-front").click()
    expect(page.get_by_test_id("source-period-s")).to_be_hidden()
    page.get_by_test_id("source-kind").select_option("snapshot")
    expect(page.get_by_test_id("source-period-s")).to_have_value("0.5")
    page.get_by_test_id("source-url").fill("http://192.168.7.20/still.jpg")
    page.get_by_test_id("source-period-s").fill("2")
    page.get_by_test_id("source-save").click()
    expect(page.get_by_test_id("source-told")).to_have_text("Saved. It came.")
    assert sources.sent[-1] == {"kind": "snapshot", "url": "http://192.168.7.20/still.jpg", "user": "", "period_s": 2}


def test_a_field_camera_shows_its_token_once(cameras: tuple[Page, Sources]) -> None:
    page, sources = cameras
    page.get_by_test_id("camera-add-name").fill("station-2")
    page.get_by_test_id("camera-add").click()
    expect(page.get_by_test_id("source-kind")).to_have_value("upload")
    expect(page.get_by_test_id("source-url")).to_be_hidden()
    page.get_by_test_id("source-save").click()
    expect(page.get_by_test_id("source-token")).to_have_text("token-0123")
    assert sources.sent[-1] == {"kind": "upload", "period_s": 5, "keep_every_s": 900, "new_token": False}
    page.keyboard.press("Escape")
    page.get_by_test_id("camera-change-field-station-2").click()
    expect(page.get_by_test_id("source-kind")).to_be_visible()
    expect(page.get_by_text("token-0123")).to_have_count(0)
