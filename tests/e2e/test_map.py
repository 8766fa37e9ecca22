"""A planner draws a field on the map, publishes it, and a mission is planned on it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import expect

from tests.e2e.installation import Installation
from tests.e2e.person import Person

pytestmark = pytest.mark.browser
Come = Callable[..., Person]
CORNERS = ((0.06, 0.72), (0.16, 0.72), (0.16, 0.88), (0.06, 0.88))  # of the drawing surface, beside the large field

TAP_PAUSE_MS = 400  # a second tap sooner than this would be a double tap


def asked(planner: Person, path: str) -> Any:
    """Return what the console says to the planner's browser."""
    return planner.page.request.get(f"/api/v1{path}").json()


def begin(planner: Person) -> None:
    """Open the map for editing and look at the large field."""
    planner.page.goto("/maps")
    planner.hook("editor-edit").click()
    expect(planner.hook("maps")).to_have_attribute("data-state", "draft")
    planner.hook("feature-row-polder-17").click()
    expect(planner.hook("map-editor")).to_have_attribute("data-state", "ready", timeout=20_000)
    expect(planner.hook("map-editor")).to_have_attribute("data-selected", "polder-17")


def draw_parcel(planner: Person) -> str:
    """Tap the corners of a new parcel; return its id."""
    planner.hook("editor-tool-parcel").click()
    expect(planner.hook("map-editor")).to_have_attribute("data-tool", "parcel")
    box = planner.box("map-editor")
    for x, y in (*CORNERS, CORNERS[0]):
        planner.page.mouse.click(box["x"] + x * box["width"], box["y"] + y * box["height"])
        planner.page.wait_for_timeout(TAP_PAUSE_MS)
    expect(planner.hook("editor-changes")).to_contain_text("Parcel drawn")
    draft = asked(planner, "/map")["draft"]
    [new] = [one["id"] for one in draft["features"]["features"] if one["id"].startswith("parcel-")]
    return str(new)


def test_a_field_is_drawn_undone_redone_published_and_planned_on(person: Come, calm: Installation) -> None:
    planner = person("planner", size="desk", has_webgl=True)
    begin(planner)
    new = draw_parcel(planner)
    planner.hook("editor-undo").click()
    expect(planner.hook("editor-redo")).to_be_enabled()
    assert new not in {one["id"] for one in asked(planner, "/map")["draft"]["features"]["features"]}
    planner.hook("editor-redo").click()
    expect(planner.hook("editor-undo")).to_be_enabled()
    assert planner.covers_of_stop() == []
    before = asked(planner, "/map")["version"]
    planner.hook("editor-publish").click()
    planner.hook("publish-note").fill("A field beside Polder 17")
    planner.hook("publish-go").click()
    expect(planner.hook("maps")).to_have_attribute("data-state", "published")
    assert asked(planner, "/map")["version"] == before + 1
    assert new in {one["id"] for one in asked(planner, "/fields")["fields"]}
    wish = {"field_id": new, "robot_id": "weeder-01", "width_m": 3.0}
    csrf = planner.page.evaluate("HL.config.csrf")
    plan = planner.page.request.post(
        "/api/v1/missions/preview", data=wish, headers={"X-Headland-CSRF": csrf, "Origin": calm.url}
    )
    assert plan.status == 200, plan.text()
    assert plan.json()["statistics"]["rows"] > 5
