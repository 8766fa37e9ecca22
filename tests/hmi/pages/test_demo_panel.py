"""The demo's sheet: what can happen to a robot, started and ended by a person."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Page, Route, expect

pytestmark = pytest.mark.browser
SITUATIONS = [
    {"id": "rtk-float", "title": "RTK float", "text": "Its position is no longer exact.", "families": ["weeder"]},
    {"id": "crane-limit", "title": "Crane", "text": "The crane reached its limit.", "families": ["planter"]},
    {"id": "sensor-silent", "title": "No radio", "text": "Nothing is heard of it.", "families": ["soil", "weather"]},
]
STATIONS = [{"id": "soil-03", "name": "Soil 3", "kind": "soil"}]


class Farm:
    """The demo's routes of the console."""

    def __init__(self) -> None:
        self.now: dict[str, str] = {}
        self.is_away = False
        self.asked = ""

    def __call__(self, route: Route) -> None:
        """Answer one request."""
        if self.is_away:
            body = {"code": "simulator_away", "text": "The simulator does not answer.", "field": None}
            route.fulfill(status=503, json=body)
            return
        if route.request.method == "POST":
            self.asked = route.request.url.partition("/demo/")[2]
            robot, wanted = route.request.url.split("/")[-2], json.loads(route.request.post_data or "{}")["situation"]
            self.now = {**self.now, robot: wanted} if wanted else {k: v for k, v in self.now.items() if k != robot}
            route.fulfill(json={"robot": robot, "situation": wanted})
            return
        route.fulfill(json={"situations": SITUATIONS, "stations": STATIONS, "now": self.now})


def opened(look: Callable[..., Page], **who: Any) -> tuple[Page, Farm]:
    """Open the sheet on Operate."""
    farm, page = Farm(), look(**who)
    page.route("**/api/v1/demo/**", farm)
    page.get_by_test_id("demo-open").click()
    expect(page.get_by_test_id("demo-panel")).to_be_visible()
    return page, farm


def test_a_situation_is_started_and_ended_for_the_robot_on_the_screen(look: Callable[..., Page]) -> None:
    page, farm = opened(look)
    expect(page.get_by_test_id("demo-robot")).to_have_value("weeder-07")
    expect(page.get_by_test_id("demo-situation-crane-limit")).to_have_count(0)
    button = page.get_by_test_id("demo-play-rtk-float")
    box = button.bounding_box()
    assert box is not None
    assert box["height"] >= 48
    button.click()
    expect(page.get_by_test_id("demo-situation-rtk-float")).to_have_attribute("data-state", "on")
    expect(page.get_by_test_id("demo-note")).to_have_text("Now: RTK float.")
    assert farm.now == {"weeder-07": "rtk-float"}
    button.click()
    expect(page.get_by_test_id("demo-situation-rtk-float")).to_have_attribute("data-state", "off")
    assert farm.now == {}
    page.get_by_test_id("demo-robot").select_option(label="Soil 3")
    expect(page.get_by_test_id("demo-situation-rtk-float")).to_have_count(0)
    page.get_by_test_id("demo-play-sensor-silent").click()
    expect(page.get_by_test_id("demo-note")).to_have_text("Now: No radio.")
    assert farm.asked == "stations/soil-03/situation"
    farm.is_away = True
    expect(page.get_by_test_id("demo-note")).to_have_text("The simulator does not answer.")


@pytest.mark.long
def test_a_viewer_may_look_only_and_the_sheet_never_covers_stop(look: Callable[..., Page]) -> None:
    page, _farm = opened(look, role="viewer", size="portrait")
    expect(page.get_by_test_id("demo-play-rtk-float")).to_be_disabled()
    expect(page.get_by_test_id("demo-note")).to_contain_text("operator role")
    stop, sheet = page.get_by_test_id("stop").bounding_box(), page.get_by_test_id("demo-panel").bounding_box()
    assert stop is not None
    assert sheet is not None
    assert sheet["y"] + sheet["height"] <= stop["y"]
