"""The missions screen in a browser; REST is played by the test."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Page, Route, expect

from hmi.domain.mission import MissionStatus
from hmi.planning.mission import plan_candidate, plan_mission
from hmi.planning.mission_map import mission_geojson
from tests.hmi.missions.test_document import wish

Look = Callable[..., Page]
PLANNED = plan_mission(wish())
GEOMETRY = mission_geojson(PLANNED.document)
CANDIDATE = plan_candidate(wish())
PATTERNS = ("shortest", "row_by_row", "skip_rows", "spiral")


def candidate_lines() -> str:
    """Return what the server streams for a wish: the same plan in every row order."""
    drawn = {"state": "planned", "statistics": CANDIDATE.statistics, "drawing": CANDIDATE.drawing}
    lines = [{"state": "planning", "patterns": PATTERNS}, *({"pattern": one, **drawn} for one in PATTERNS)]
    return "".join(json.dumps(line) + "\n" for line in [*lines, {"state": "done"}])


def mission(mission_id: str, status: str = "validated", **changes: Any) -> dict[str, Any]:
    usual = {
        "id": mission_id,
        "name": f"Mission {mission_id}",
        "field_name": "Nordfeld 12",
        "robot_id": "weeder-07",
        "status": status,
        "statistics": PLANNED.statistics,
        "updated_utc": "2026-05-20T14:36:40.900+00:00",
        "log": [
            {"utc": "2026-05-20T14:36:40.900+00:00", "status": status, "by": "Pieter", "why": "Planned.", "data": {}}
        ],
    }
    return {**usual, **changes}


class Played:
    """REST as the screen sees it."""

    def __init__(self, page: Page, missions: list[dict[str, Any]]) -> None:
        self.missions = missions
        self.status = 200
        self.asked: list[tuple[str, str, dict[str, Any]]] = []
        self.refusal: dict[str, Any] | None = None
        page.route("**/api/v1/missions**", self.answer)
        page.route("**/api/v1/fields", self.answer)
        page.route("**/api/v1/robots", self.answer)
        page.route("**/api/v1/robots/*/mission", self.answer)

    def answer(self, route: Route) -> None:
        path = route.request.url.split("/api/v1/")[1]
        method = route.request.method
        if method != "GET":
            self.asked.append((method, path, json.loads(route.request.post_data or "{}")))
        if path == "missions/candidates" and not self.refusal:
            route.fulfill(status=200, content_type="application/x-ndjson", body=candidate_lines())
            return
        status, body = self.reply(method, path)
        route.fulfill(status=status, content_type="application/json", body=json.dumps(body))

    def reply(self, method: str, path: str) -> tuple[int, Any]:
        if self.status != 200:
            return self.status, {"code": "database_unavailable", "text": "The records cannot be used right now."}
        if path == "missions":
            return 200, {"missions": self.missions}
        if path == "fields":
            field = {"id": "field-1", "name": "Nordfeld 12", "properties": {}}
            return 200, {"fields": [field], "homes": []}
        if path == "robots":
            return 200, {"robots": [{"id": "weeder-07", "name": "Weeder 07"}]}
        if "/battery?" in path:
            return 200, {"share": None, "charge": None, "of_robot": None, "text": ""}
        if path.endswith("map.geojson"):
            return 200, GEOMETRY
        if path == "missions/candidates":
            return 422, self.refusal
        if path == "missions/plan":
            self.missions = [mission("m-new", name="New one"), *self.missions]
            return 201, self.missions[0]
        if path.endswith("/mission"):
            return 200, self.refusal or {"outcome": "accepted", "text": "Weeder 07 has it and read it back."}
        if method == "DELETE":
            self.missions = [one for one in self.missions if not path.endswith(one["id"])]
            return 204, None
        return 200, next(one for one in self.missions if path.endswith(one["id"]))


@pytest.fixture
def show(look: Look) -> Callable[..., tuple[Page, Played]]:
    """Open the missions screen on played missions."""

    def open_screen(*missions: dict[str, Any], role: str = "supervisor", **more: Any) -> tuple[Page, Played]:
        page = look("/operate", role=role, size=more.get("size", "landscape"))
        played = Played(page, list(missions))
        played.status = more.get("status", 200)
        page.get_by_test_id("nav-missions").click()
        return page, played

    return open_screen


def test_each_mission_has_a_row_with_its_state(show: Callable[..., tuple[Page, Played]]) -> None:
    page, _ = show(*(mission(f"m-{status.value}", status.value) for status in MissionStatus))
    for status in MissionStatus:
        expect(page.get_by_test_id(f"mission-row-m-{status.value}")).to_have_attribute("data-state", status.value)


def test_the_newest_is_open_with_picture_and_numbers(show: Callable[..., tuple[Page, Played]]) -> None:
    page, _ = show(mission("m-1"), mission("m-2"))
    expect(page.get_by_test_id("mission-name")).to_have_text("Mission m-1")
    expect(page.locator(".h-picture .row")).to_have_count(1)
    length = page.get_by_test_id("plan-stat-length").get_attribute("data-value")
    assert float(length or 0) == pytest.approx(PLANNED.statistics["length_m"])


def test_sending_says_that_nothing_moves(show: Callable[..., tuple[Page, Played]]) -> None:
    page, played = show(mission("m-1"))
    expect(page.locator(".h-mdetail").get_by_text("Sending does not move the robot.")).to_be_visible()
    page.get_by_test_id("plan-send").click()
    expect(page.get_by_test_id("toast")).to_contain_text("It does not move yet.")
    assert played.asked == [("POST", "robots/weeder-07/mission", {"mission_id": "m-1", "way": "direct"})]


def test_a_refused_sending_gives_the_reason(show: Callable[..., tuple[Page, Played]]) -> None:
    page, played = show(mission("m-1"))
    played.refusal = {"outcome": "rejected", "text": "Weeder 07 is running another mission."}
    page.get_by_test_id("plan-send").click()
    expect(page.get_by_test_id("mission-result")).to_have_text("Not sent: Weeder 07 is running another mission.")


def test_a_lost_answer_is_not_said_to_be_not_sent(show: Callable[..., tuple[Page, Played]]) -> None:
    page, played = show(mission("m-1"))
    result = page.get_by_test_id("mission-result")
    for outcome in ("unknown", "timed_out"):
        played.refusal = {"outcome": outcome, "text": f"Its answer was lost ({outcome})."}
        page.get_by_test_id("plan-send").click()
        expect(result).to_have_text(f"Not known whether it arrived: Its answer was lost ({outcome}).")
    page.route("**/api/v1/robots/*/mission", lambda route: route.abort())
    page.get_by_test_id("plan-send").click()
    expect(result).to_have_text("Not known whether it arrived: The server cannot be reached.")
    refusal = {"code": "csrf", "text": "This page is out of date."}
    page.route("**/api/v1/robots/*/mission", lambda route: route.fulfill(status=403, json=refusal))
    page.get_by_test_id("plan-send").click()
    expect(result).to_have_text("Not sent: This page is out of date.")


def test_a_mission_is_previewed_stored_and_sent(show: Callable[..., tuple[Page, Played]]) -> None:
    page, played = show(mission("m-1"))
    page.get_by_test_id("mission-plan").click()
    expect(page.get_by_test_id("plan-send")).to_be_disabled()
    page.get_by_test_id("plan-width").fill("1.5")
    page.get_by_test_id("plan-preview").click()
    expect(page.get_by_test_id("plan-stat-turns")).to_be_visible()
    page.get_by_test_id("plan-send").click()
    expect(page.get_by_test_id("mission-name")).to_have_text("New one")
    paths = [path for _, path, _ in played.asked]
    assert paths == ["missions/candidates", "missions/plan", "robots/weeder-07/mission"]
    assert played.asked[1][2]["width_m"] == 1.5


def test_what_cannot_be_planned_is_said_beside_the_form(show: Callable[..., tuple[Page, Played]]) -> None:
    page, played = show(mission("m-1"))
    played.refusal = {"code": "field_too_small", "text": "The field is smaller than the machine.", "field": "field_id"}
    page.get_by_test_id("mission-plan").click()
    page.get_by_test_id("plan-preview").click()
    expect(page.get_by_test_id("plan-error")).to_have_text("The field is smaller than the machine.")
    expect(page.get_by_test_id("plan-store")).to_be_disabled()


@pytest.mark.long
def test_a_changed_wish_must_be_looked_at_again(show: Callable[..., tuple[Page, Played]]) -> None:
    page, _ = show(mission("m-1"))
    page.get_by_test_id("mission-plan").click()
    page.get_by_test_id("plan-preview").click()
    expect(page.get_by_test_id("plan-store")).to_be_enabled()
    page.get_by_test_id("plan-width").fill("2")
    expect(page.get_by_test_id("plan-store")).to_be_disabled()


@pytest.mark.long
def test_a_wish_survives_a_reload(show: Callable[..., tuple[Page, Played]]) -> None:
    page, _ = show(mission("m-1"))
    page.get_by_test_id("mission-plan").click()
    page.get_by_test_id("plan-width").fill("1.35")
    page.reload()
    page.get_by_test_id("mission-plan").click()
    expect(page.get_by_test_id("plan-width")).to_have_value("1.35")


@pytest.mark.long
def test_a_mission_that_never_ran_can_be_deleted(show: Callable[..., tuple[Page, Played]]) -> None:
    page, played = show(mission("m-1"), mission("m-2"))
    page.get_by_test_id("mission-row-m-2").click()
    expect(page.get_by_test_id("mission-name")).to_have_text("Mission m-2")
    page.get_by_test_id("mission-delete").click()
    page.get_by_test_id("dialog").get_by_text("Delete", exact=True).click()
    expect(page.get_by_test_id("mission-row-m-2")).to_have_count(0)
    assert ("DELETE", "missions/m-2", {}) in played.asked


def test_an_operator_sends_but_does_not_change(show: Callable[..., tuple[Page, Played]]) -> None:
    page, _ = show(mission("m-1"), role="operator")
    expect(page.get_by_test_id("mission-rights")).to_have_text("You can start missions, not change them.")
    expect(page.get_by_test_id("plan-send")).to_be_enabled()
    for hook in ("mission-plan", "mission-copy", "mission-rename", "mission-delete"):
        expect(page.get_by_test_id(hook)).to_be_disabled()


@pytest.mark.long
def test_a_viewer_only_watches(show: Callable[..., tuple[Page, Played]]) -> None:
    page, _ = show(mission("m-1"), role="viewer")
    expect(page.get_by_test_id("mission-rights")).to_have_text(
        "You can watch missions. Sending needs the operator role."
    )
    expect(page.get_by_test_id("plan-send")).to_be_disabled()


@pytest.mark.long
def test_without_missions_it_says_what_to_do(show: Callable[..., tuple[Page, Played]]) -> None:
    page, _ = show()
    expect(page.get_by_test_id("missions-empty")).to_contain_text("No missions yet")


@pytest.mark.long
def test_an_error_gives_a_way_to_try_again(show: Callable[..., tuple[Page, Played]]) -> None:
    page, played = show(mission("m-1"), status=503)
    expect(page.get_by_test_id("missions-error")).to_contain_text("Missions did not load")
    played.status = 200
    page.get_by_test_id("missions-error").get_by_text("Try again").click()
    expect(page.get_by_test_id("mission-row-m-1")).to_be_visible()


@pytest.mark.long
def test_on_a_narrow_screen_list_and_detail_take_turns(show: Callable[..., tuple[Page, Played]]) -> None:
    page, _ = show(mission("m-1"), size="portrait")
    page.get_by_test_id("mission-row-m-1").click()
    expect(page.get_by_test_id("mission-name")).to_be_visible()
    expect(page.get_by_test_id("mission-row-m-1")).not_to_be_visible()
    page.get_by_label("All missions").click()
    expect(page.get_by_test_id("mission-row-m-1")).to_be_visible()


def test_a_hostile_name_stays_text(show: Callable[..., tuple[Page, Played]]) -> None:
    name = "<img src=x onerror=alert(1)>"
    page, _ = show(mission("m-1", name=name))
    expect(page.get_by_test_id("mission-name")).to_have_text(name)
    expect(page.locator(".h-missions img")).to_have_count(0)
