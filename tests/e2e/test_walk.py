"""A line of the map is recorded from the positions of a robot that really goes along it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import expect

from tests.e2e.installation import Installation
from tests.e2e.person import Person, wait_for
from tests.e2e.test_kills import ROBOT, let_it_drive

pytestmark = [pytest.mark.browser, pytest.mark.long]
Come = Callable[..., Person]
METRE_DEG = 1 / 111_320


def off_m(a: tuple[float, float], b: tuple[float, float]) -> float:
    """Return how far two places lon, lat are apart, metres."""
    east = (a[0] - b[0]) * math.cos(math.radians(a[1]))
    return math.hypot(east, a[1] - b[1]) / METRE_DEG


def place(planner: Person) -> tuple[float, float]:
    """Return where the console says the robot is, lon, lat."""
    pose: dict[str, Any] = planner.page.evaluate(f"headland.state('robot/{ROBOT}').pose")
    return pose["lon"], pose["lat"]


def test_a_guide_line_is_walked_with_a_robot_at_work(person: Come, calm: Installation) -> None:
    let_it_drive(person("operator"), calm)
    planner = person("planner", has_webgl=True)
    planner.page.goto("/maps")
    planner.hook("editor-edit").click()
    expect(planner.hook("maps")).to_have_attribute("data-state", "draft")
    planner.hook("editor-walk").click()
    planner.hook("walk-what").select_option("rows")
    planner.hook("walk-robot").select_option(ROBOT)
    expect(planner.hook("walk-facts")).to_contain_text("±")
    planner.hook("walk-start").click()
    begun = place(planner)
    wait_for(lambda: planner.value("walk") >= 12, within_s=60, what="a dozen points, half a metre apart")
    ended = place(planner)
    planner.hook("walk-finish").click()
    expect(planner.hook("toast")).to_contain_text("positions")
    draft = planner.page.request.get("/api/v1/map").json()["draft"]
    [line] = [one["geometry"]["coordinates"] for one in draft["features"]["features"] if one["id"].startswith("rows-")]
    assert off_m(line[0], begun) < 1.0
    assert off_m(line[-1], ended) < 2.0
    assert off_m(line[0], line[-1]) > 4.0
    assert planner.covers_of_stop() == []
