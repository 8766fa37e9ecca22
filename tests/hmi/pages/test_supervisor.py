"""The Supervisor screen: what is active and since when, on a chart that stands still; how long, and on what."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from tests.hmi.pages.conftest import TABLETS, Theatre
from tests.hmi.pages.super_stage import NOW
from tests.hmi.pages.test_shell import is_stop_on_top

pytestmark = pytest.mark.browser
Look = Callable[..., Page]
PATH = "/supervisor/planter-02"


@pytest.fixture
def planter(theatre: Theatre) -> Callable[..., None]:
    """Set what the planter does."""
    theatre.play("running")
    theatre.planter(anew=True)
    return theatre.planter


def state(page: Page, name: str) -> Any:
    """Return a state of the drawing."""
    return page.locator(f".s-drawing [data-id='{name}']")


def places(page: Page) -> Any:
    """Return where every box is drawn."""
    return page.evaluate("[...document.querySelectorAll('.s-drawing rect')].map((r) => r.outerHTML)")


def test_active_states_are_filled_with_their_time_and_nothing_jumps_when_the_robot_moves_on(
    look: Look, planter: Callable[..., None]
) -> None:
    page = look(PATH)
    expect(state(page, "on-ground")).to_have_class("s-state on over")
    expect(state(page, "on-ground").locator(".time")).to_have_text(re.compile(r"^[23]:\d\d, normal 7 s$"))
    expect(state(page, "hold").locator(".time")).to_contain_text(re.compile(r"^[23]:\d\d"))
    expect(page.get_by_test_id("chart-states")).to_have_attribute("data-active", " ".join(one[0] for one in NOW))
    expect(page.locator(".s-way.last")).to_have_count(1)
    before = places(page)
    later = [one for one in NOW if one[0] != "on-ground"] + [["photo", 1.0]]
    planter(active=later, last=["on-ground", "photo", "planted", "OK"])
    expect(state(page, "photo")).to_have_class("s-state on")
    expect(state(page, "on-ground")).to_have_class("s-state")
    expect(page.get_by_test_id("chart-states").locator(".s-crumb").last).to_have_text("Photo")
    assert places(page) == before


def test_a_touch_on_a_state_tells_what_it_does_and_how_long_it_took(look: Look, planter: Callable[..., None]) -> None:
    page = look(PATH)
    state(page, "on-ground").locator("rect").first.tap()
    sheet = page.get_by_test_id("state-sheet")
    expect(sheet).to_contain_text("Lower")
    expect(sheet).to_contain_text(re.compile(r"active for [23]:\d\d"))
    expect(sheet.locator(".s-lasttimes")).to_contain_text("mean 10 s")
    expect(sheet).to_contain_text("ground too hard")
    sheet.get_by_role("button", name="to Back off 5 cm").click()
    expect(page.get_by_test_id("state-sheet").locator("h2")).to_have_text("Back off 5 cm")
    page.keyboard.press("Escape")
    page.get_by_test_id("chart-tab-tree").click()
    row = page.get_by_test_id("chart-tree").locator("[data-id='hold']")
    expect(row).to_have_attribute("aria-current", "true")
    expect(row).to_contain_text(re.compile(r"[23]:\d\d"))
    page.get_by_test_id("chart-tab-moves").click()
    expect(page.get_by_test_id("chart-moves")).to_contain_text("docked")


def test_the_chart_fills_the_window_and_stop_stays_on_top(look: Look, planter: Callable[..., None]) -> None:
    page = look(PATH)
    expect(state(page, "on-ground")).to_have_class("s-state on over")
    wide = state(page, "on-ground").bounding_box()
    page.get_by_test_id("chart-full").click()
    expect(page.locator(".s-whole")).to_be_visible()
    whole = page.locator(".s-whole").bounding_box()
    assert whole is not None
    assert (whole["x"], whole["y"], whole["width"], whole["height"]) == (0, 0, 1280, 800 - 96)
    assert is_stop_on_top(page)
    page.get_by_test_id("chart-zoom-in").click()
    near = state(page, "on-ground").bounding_box()
    assert wide is not None
    assert near is not None
    assert near["width"] > wide["width"]
    page.keyboard.press("Escape")
    expect(page.locator(".s-whole")).to_have_count(0)


def test_keys_move_over_the_chart_and_open_a_state(look: Look, planter: Callable[..., None]) -> None:
    page = look(PATH, size="desk")
    expect(state(page, "on-ground")).to_have_class("s-state on over")
    page.locator(".s-drawing [tabindex='0']").focus()
    page.keyboard.press("ArrowRight")
    chosen = page.evaluate("document.activeElement.dataset.id")
    assert chosen is not None
    page.keyboard.press("Enter")
    expect(page.get_by_test_id("state-sheet")).to_be_visible()


def test_old_data_turns_grey_and_says_since_when(look: Look, planter: Callable[..., None]) -> None:
    page = look(PATH)
    expect(state(page, "on-ground")).to_have_class("s-state on over")
    planter(is_silent=True)
    expect(page.get_by_test_id("chart-states")).to_have_class("s-charthost stale")
    expect(page.get_by_test_id("chart-states").locator(".s-note")).to_contain_text("State data stopped")
    said = state(page, "hold").locator(".time").text_content()
    planter(is_off=True)
    expect(page.get_by_test_id("chart-states").locator(".s-note")).to_contain_text("Robot is off. Last state: Lower")
    assert state(page, "hold").locator(".time").text_content() == said


@pytest.mark.long
def test_durations_and_shares_are_of_what_was_recorded(look: Look, planter: Callable[..., None]) -> None:
    page = look(PATH)
    gantt = page.get_by_test_id("chart-gantt")
    expect(gantt.locator(".s-lane")).to_have_text(["Base", "Crane", "Planting tool", "Guard"])
    expect(gantt.locator(".s-bar.open.over[data-state='on-ground']")).to_contain_text("normal 7 s")
    expect(gantt.locator(".sub")).to_contain_text("Lower has run")
    ring = page.get_by_test_id("chart-time-share")
    expect(ring).to_contain_text("Crane")
    shares = [float(part.split(":")[1]) for part in (ring.get_attribute("data-value") or "").split()]
    assert sum(shares) == pytest.approx(1, abs=0.001)
    page.get_by_test_id("gantt-look-table").click()
    row = page.get_by_test_id("gantt-table").get_by_role("row", name="Lower")
    expect(row).to_have_attribute("data-drift", "yes")
    expect(row).to_contain_text("+36 %")
    page.get_by_test_id("gantt-export").click()
    with page.expect_download() as download:
        page.get_by_role("button", name="Table (CSV)").click()
    assert "on-ground,Lower,Crane" in download.value.path().read_text("utf-8")
    page.get_by_test_id("gantt-export").click()
    with page.expect_download() as download:
        page.get_by_role("button", name="Picture (PNG)").click()
    assert download.value.path().read_bytes()[:4] == b"\x89PNG"


@pytest.mark.long
def test_a_stay_that_ends_stays_in_the_picture_under_the_finger_before_the_record_has_it(
    look: Look, planter: Callable[..., None]
) -> None:
    page = look(PATH)
    bar = page.get_by_test_id("chart-gantt").locator(".s-bar[data-state='on-ground']").last
    expect(bar).to_have_class(re.compile(r"\bopen\b"))
    held = bar.element_handle()
    others = [one for one in NOW if one[0] != "on-ground"]
    planter(active=[*others, ["photo", 1.0]], last=["on-ground", "photo", "planted", "OK"])  # the record has no end
    expect(page.get_by_test_id("chart-gantt").locator(".s-bar.open[data-state='photo']")).to_have_count(1)
    expect(bar).not_to_have_class(re.compile(r"\bopen\b"))
    assert held is not None
    assert held.evaluate("(node) => node.isConnected && node.dataset.state") == "on-ground"


def test_a_robot_without_a_chart_is_told_by_its_path(look: Look, planter: Callable[..., None]) -> None:
    planter(has_chart=False)
    page = look(PATH)
    expect(page.get_by_text("This robot sends no chart")).to_be_visible()
    expect(page.get_by_test_id("chart-states")).to_contain_text("It says: Mission, Plant tree 147 of 380, Lower")


def test_the_state_on_operate_opens_the_supervisor_and_the_robot_is_switched_there(
    look: Look, planter: Callable[..., None]
) -> None:
    page = look("/operate/planter-02")
    page.get_by_test_id("supervisor-path").click()
    expect(state(page, "on-ground")).to_have_class("s-state on over")
    page.get_by_test_id("robot-switch").click()
    page.get_by_test_id("robot-option-weeder-07").click()
    page.wait_for_url("**/supervisor/weeder-07")
    expect(page.get_by_text("This robot sends no chart")).to_be_visible()


@pytest.mark.long
@pytest.mark.parametrize("size", TABLETS)
def test_everything_fits_in_every_size(look: Look, planter: Callable[..., None], size: str) -> None:
    page = look(PATH, size=size)
    expect(state(page, "on-ground")).to_have_class("s-state on over")
    wide = page.evaluate("[document.documentElement.scrollWidth, innerWidth]")
    assert wide[0] <= wide[1]
    drawing = page.locator(".s-drawing").bounding_box()
    assert drawing is not None
    for box in page.locator(".s-drawing .s-state").all()[:40]:
        place = box.bounding_box()
        assert place is not None
        assert place["x"] >= drawing["x"] - 1
        assert place["x"] + place["width"] <= drawing["x"] + drawing["width"] + 1
    assert is_stop_on_top(page)


@pytest.mark.long
def test_a_mission_that_is_over_is_shown_from_its_record(look: Look, planter: Callable[..., None]) -> None:
    page = look(f"{PATH}?mission=m-0410")
    expect(page.get_by_test_id("chart-gantt").locator(".s-lane")).to_have_text(
        ["Base", "Crane", "Planting tool", "Guard"]
    )
    expect(page.get_by_test_id("gantt-span-mission")).to_have_attribute("aria-pressed", "true")
