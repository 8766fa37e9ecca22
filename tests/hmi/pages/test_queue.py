"""The queue on the Missions screen; REST is played by the test."""

from __future__ import annotations

import json
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from typing import Any

import pytest
from playwright.sync_api import Page, Route, expect

from tests.hmi.pages.test_missions import Played, mission

pytestmark = [pytest.mark.browser, pytest.mark.long]
Look = Callable[..., Page]
EASY = {
    "rain_below_mm_h": None, "wind_below_mps": 5.0, "needs_daylight": True, "after_sunrise_s": 0,
    "before_sunset_s": 0, "battery_reserve": 0.15, "battery_min": None, "needs_rtk": True,
}  # fmt: skip


def utc(minutes: float) -> str:
    """Return a time so many minutes from now."""
    return (datetime.now(UTC) + timedelta(minutes=minutes)).isoformat(timespec="milliseconds")


def waits(code: str, text: str) -> dict[str, Any]:
    """Return what an entry waits for."""
    return {"code": code, "text": text, "clears": "", "who": "itself", "clears_utc": None, "since_utc": utc(-9),
            "step": "wait"}  # fmt: skip


def entry(entry_id: str, name: str, status: str = "queued", **changes: Any) -> dict[str, Any]:
    """Return an entry as REST gives it."""
    usual = {
        "id": entry_id, "robot_id": "weeder-07", "mission_id": f"m-{entry_id}", "is_unattended": True,
        "earliest_utc": None, "window_s": 900, "repeat": None, "conditions": EASY, "state": "open", "why": "",
        "added_by": "Pieter Bos", "added_utc": utc(-60), "started_utc": None, "ended_utc": None, "name": name,
        "field_name": "Nordfeld 12", "status": status, "is_supervised": False, "duration_s": 1800,
        "waiting": waits("not_first", "Waits for Wheat 1, before it in the queue."),
    }  # fmt: skip
    return {**usual, **changes}


def robot(robot_id: str, name: str, **changes: Any) -> dict[str, Any]:
    """Return a robot's part of the queue."""
    usual = {"robot_id": robot_id, "name": name, "revision": 4, "is_unattended_allowed": True, "arming": None,
             "disarmed": None, "now": None}  # fmt: skip
    return {**usual, **changes}


class PlayedQueue(Played):
    """REST with a queue."""

    def __init__(self, page: Page, queue: dict[str, Any]) -> None:
        super().__init__(page, [mission("m-1"), mission("m-2", name="Second")])
        self.queue = queue
        self.queue_status = 200
        page.route("**/api/v1/queue**", self.answer_queue)
        page.route("**/api/v1/queue/**", self.answer_queue)

    def answer_queue(self, route: Route) -> None:
        path, method = route.request.url.split("/api/v1/")[1], route.request.method
        if method != "GET":
            self.asked.append((method, path, json.loads(route.request.post_data or "{}")))
        body = self.queue if self.queue_status == 200 else {"code": "failed", "text": "The database is away."}
        if method == "POST" and path == "queue/arm" and self.queue_status == 200:
            body = {"outcome": "accepted", "code": "ok", "text": "Armed until 18:00."}
        route.fulfill(status=self.queue_status, content_type="application/json", body=json.dumps(body))


def whole(**changes: Any) -> dict[str, Any]:
    """Return a queue with something of everything."""
    usual = {
        "now_utc": utc(0), "zone": "Europe/Amsterdam", "frozen": None, "weather": None, "blackouts": [], "ended": [],
        "robots": [robot("weeder-07", "Weeder 07"), robot("weeder-01", "Weeder 01", is_unattended_allowed=False)],
        "entries": [
            entry("a", "Wheat 1", "waiting", waiting=waits("wind", "Waits: wind 6.1 m/s, limit 5.0.")),
            entry("b", "Wheat 2"),
            entry("c", "Wheat 3"),
        ],
    }  # fmt: skip
    return {**usual, **changes}


@pytest.fixture
def show(look: Look) -> Callable[..., tuple[Page, PlayedQueue]]:
    """Open the queue on played REST."""

    def open_queue(queue: dict[str, Any], role: str = "operator", **more: Any) -> tuple[Page, PlayedQueue]:
        page = look("/operate", role=role, size=more.get("size", "landscape"))
        played = PlayedQueue(page, queue)
        played.queue_status = more.get("status", 200)
        page.get_by_test_id("nav-missions").click()
        page.get_by_test_id("missions-tab-queue").click()
        return page, played

    return open_queue


def test_each_robot_says_what_it_waits_for_and_keys_move_missions(
    show: Callable[..., tuple[Page, PlayedQueue]],
) -> None:
    page, played = show(whole())
    expect(page.get_by_test_id("queue-reason-weeder-07")).to_contain_text("Wheat 1: Waits: wind 6.1 m/s, limit 5.0.")
    page.get_by_test_id("queue-bar-c").focus()
    with page.expect_response("**/move"):
        page.keyboard.press("Alt+ArrowLeft")
    assert played.asked == [("POST", "queue/entries/c/move", {"before": "b"})]
    page.get_by_test_id("queue-look-list").click()
    expect(page.get_by_test_id("queue-entry-a")).to_contain_text("Waits: wind 6.1 m/s, limit 5.0.")


def test_days_of_a_blackout_window_stand_beside_each_other_and_the_calendar_fills_the_screen(
    show: Callable[..., tuple[Page, PlayedQueue]],
) -> None:
    page, _ = show(whole(), role="supervisor")
    page.get_by_test_id("queue-blackouts-open").click()
    page.get_by_role("button", name="Add a window").click()
    days = page.get_by_role("group", name="Days on which it begins").get_by_role("button")
    tops = {round((one.bounding_box() or {"y": 0.0})["y"]) for one in days.all()}
    assert (days.count(), len(tops)) == (7, 1)
    page.keyboard.press("Escape")
    page.get_by_test_id("queue-look-calendar").click()
    expect(page.get_by_test_id("queue-calendar")).to_have_css("align-self", "stretch")


def test_dragging_a_bar_before_another_one_moves_it(show: Callable[..., tuple[Page, PlayedQueue]]) -> None:
    page, played = show(whole())
    bar, goal = page.get_by_test_id("queue-bar-c").bounding_box(), page.get_by_test_id("queue-bar-a").bounding_box()
    assert bar is not None
    assert goal is not None
    page.mouse.move(bar["x"] + bar["width"] / 2, bar["y"] + 20)
    page.mouse.down()
    page.mouse.move(goal["x"] + 4, bar["y"] + 20, steps=8)
    with page.expect_response("**/move"):
        page.mouse.up()
    assert played.asked == [("POST", "queue/entries/c/move", {"before": "a"})]
    expect(page.get_by_test_id("queue-entry")).to_have_count(0)


def test_arming_names_the_robot_its_revision_and_the_time(show: Callable[..., tuple[Page, PlayedQueue]]) -> None:
    page, played = show(whole())
    page.get_by_test_id("queue-arm-open").click()
    page.get_by_test_id("queue-hours-2").click()
    expect(page.get_by_test_id("queue-arm")).to_contain_text("Weeder 07 drives off by itself")
    page.get_by_test_id("queue-arm").focus()
    page.keyboard.down("Enter")
    expect(page.get_by_test_id("queue-arm")).to_have_attribute("data-state", "confirmed")
    page.keyboard.up("Enter")
    [(_, path, body)] = [one for one in played.asked if one[1] == "queue/arm"]
    assert path == "queue/arm"
    assert (body["robots"], body["duration_s"]) == ([{"robot_id": "weeder-07", "revision": 4}], 7200)
    assert body["tick"]


def test_what_the_server_refuses_is_not_laid_on_the_robot(show: Callable[..., tuple[Page, PlayedQueue]]) -> None:
    page, played = show(whole())
    page.get_by_test_id("queue-arm-open").click()
    slide = page.get_by_test_id("queue-arm")
    slide.focus()
    played.queue_status = 409
    page.keyboard.down("Enter")
    expect(slide).to_have_attribute("data-state", "refused")
    page.keyboard.up("Enter")
    expect(slide).to_contain_text("Not accepted")
    expect(slide).not_to_contain_text("obot did not")


def test_a_frozen_queue_says_so_and_wants_a_reason_first(show: Callable[..., tuple[Page, PlayedQueue]]) -> None:
    page, _ = show(whole(frozen={"by": "Vera Lang", "utc": utc(-4)}))
    expect(page.get_by_test_id("queue-frozen")).to_contain_text("STOP ALL by Vera Lang")
    expect(page.get_by_test_id("queue-release")).to_contain_text("Tap a reason first.")
    page.get_by_role("button", name="Area is clear").click()
    expect(page.get_by_test_id("queue-release")).not_to_have_attribute("aria-disabled", "true")
    expect(page.get_by_test_id("queue-arm-open")).to_be_disabled()


def test_a_viewer_sees_the_queue_and_cannot_change_it(show: Callable[..., tuple[Page, PlayedQueue]]) -> None:
    page, _ = show(whole(), role="viewer")
    expect(page.get_by_text("Arming needs the operator role.")).to_be_visible()
    page.get_by_test_id("queue-bar-a").click()
    expect(page.get_by_test_id("queue-remove")).to_be_disabled()


def test_an_empty_and_a_failed_queue_say_what_to_do(show: Callable[..., tuple[Page, PlayedQueue]]) -> None:
    page, played = show(whole(entries=[]))
    expect(page.get_by_test_id("queue-empty")).to_contain_text("add it to the queue")
    played.queue_status = 503
    page.get_by_test_id("missions-tab-list").click()
    page.get_by_test_id("missions-tab-queue").click()
    expect(page.get_by_test_id("queue-error")).to_contain_text("The database is away.")


def test_several_missions_answer_each_for_itself(show: Callable[..., tuple[Page, PlayedQueue]]) -> None:
    page, played = show(whole(), role="supervisor")
    page.get_by_test_id("missions-tab-list").click()
    page.get_by_test_id("mission-select").click()
    page.get_by_test_id("mission-pick-m-1").check()
    page.get_by_test_id("mission-pick-m-2").check()
    page.get_by_test_id("bulk-unattended").click()
    expect(page.get_by_test_id("bulk-result-m-2")).to_contain_text("Done")
    assert [path for method, path, _ in played.asked if method == "PATCH"] == ["missions/m-1", "missions/m-2"]
    page.get_by_role("button", name="Close").click()
    page.get_by_test_id("mission-filter-ended").click()
    expect(page.get_by_test_id("mission-row-m-1")).to_have_count(0)
