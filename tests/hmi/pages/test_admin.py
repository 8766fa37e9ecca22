"""Admin in a browser: what is changed of a registered robot; REST is played by the test."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Page, Route, expect

Look = Callable[..., Page]
ROBOT = {
    "id": "weeder-07",
    "name": "Weeder 07",
    "family": "weeder",
    "http_url": "http://10.0.0.17:8090",
    "has_http_token": True,
    "contact_name": "Jonas Weber",
    "contact_phone": "+49 151 0000",
    "is_unattended_allowed": False,
}


class Registry:
    """The registry as the screen sees it."""

    def __init__(self, page: Page) -> None:
        self.robot: dict[str, Any] = dict(ROBOT)
        self.refusal: dict[str, Any] | None = None
        self.asked: list[dict[str, Any]] = []
        page.route("**/api/v1/robots", lambda route: self.reply(route, {"robots": [self.robot]}))
        page.route("**/api/v1/robots/weeder-07", self.change)

    @staticmethod
    def reply(route: Route, body: Any, status: int = 200) -> None:
        """Answer with JSON."""
        route.fulfill(status=status, content_type="application/json", body=json.dumps(body))

    def change(self, route: Route) -> None:
        """Take a change, or refuse it."""
        self.asked.append(json.loads(route.request.post_data or "{}"))
        if self.refusal:
            return self.reply(route, self.refusal, 422)
        self.robot |= {key: value for key, value in self.asked[-1].items() if key != "http_token"}
        return self.reply(route, self.robot)


@pytest.fixture
def admin(look: Look) -> tuple[Page, Registry]:
    """Open the sheet of one robot."""
    page = look("/fleet", role="admin")
    registry = Registry(page)
    page.get_by_test_id("nav-admin").click()
    page.get_by_test_id("robot-change-weeder-07").click()
    return page, registry


def test_only_what_was_changed_is_sent_and_a_token_is_never_shown(admin: tuple[Page, Registry]) -> None:
    page, registry = admin
    expect(page.get_by_test_id("robot-edit-http-token")).to_have_value("")
    page.get_by_test_id("robot-edit-name").fill("Weeder Seven")
    page.get_by_test_id("robot-edit-contact-phone").fill("")
    page.get_by_test_id("robot-edit-keep-out-m").fill("25")
    page.get_by_test_id("robot-edit-unattended").check()
    page.get_by_test_id("robot-edit-save").click()
    expect(page.get_by_test_id("robot-row-weeder-07")).to_contain_text("Weeder Seven")
    expect(page.get_by_test_id("robot-row-weeder-07")).to_contain_text("yes")
    assert registry.asked == [
        {"name": "Weeder Seven", "contact_phone": None, "keep_out_m": 25, "is_unattended_allowed": True}
    ]


@pytest.mark.long
def test_what_is_wrong_stands_at_its_field_and_nothing_typed_is_lost(admin: tuple[Page, Registry]) -> None:
    page, registry = admin
    registry.refusal = {"code": "invalid", "field": "http_url", "text": "use http://host:port/path"}
    page.get_by_test_id("robot-edit-http-url").fill("10.0.0.7")
    page.get_by_test_id("robot-edit-save").click()
    expect(page.get_by_test_id("robot-edit-http-url")).to_have_attribute("aria-invalid", "true")
    expect(page.locator("#robot-wrong-http_url")).to_have_text("Not saved: use http://host:port/path")
    expect(page.get_by_test_id("robot-edit-http-url")).to_have_value("10.0.0.7")
    registry.refusal = {"code": "stop_list_not_written", "text": "STOP could not be told."}
    page.get_by_test_id("robot-edit-save").click()
    expect(page.get_by_test_id("robot-edit-error")).to_have_text("Not saved: STOP could not be told.")
    expect(page.locator("#robot-wrong-http_url")).to_have_text("")


@pytest.mark.long
def test_a_token_is_taken_away_only_by_saying_so(admin: tuple[Page, Registry]) -> None:
    page, registry = admin
    page.get_by_test_id("robot-edit-no-token").check()
    page.get_by_test_id("robot-edit-http-token").fill("new")
    page.get_by_test_id("robot-edit-save").click()
    expect(page.locator("#robot-wrong-http_token")).to_contain_text("not both")
    page.get_by_test_id("robot-edit-http-token").fill("")
    page.get_by_test_id("robot-edit-save").click()
    expect(page.get_by_test_id("robot-edit")).to_have_count(0)
    assert registry.asked == [{"http_token": None}]
