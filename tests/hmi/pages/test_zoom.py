"""A page zoomed to 150 and 200 % and forced colours: everything is reached, and what is on is told from what is off."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from playwright.sync_api import Page, expect

from tests.hmi.pages.conftest import Theatre

pytestmark = pytest.mark.browser
Look = Callable[..., Page]
WINDOWS = {
    "landscape-200": (640, 400),
    "portrait-200": (400, 640),
    "portrait-150": (533, 853),
    "landscape-150": (853, 533),
}
SCREENS = ("fleet", "maps", "missions", "alarms", "cameras", "sensors", "admin")

# what of a kind cannot be pressed: cut at a side, under something else, or out of the window with nothing that scrolls
UNREACHED = """(hooks) => hooks.filter((hook) => {
  const one = document.querySelector(`[data-testid="${hook}"]`);
  if (!one) return true;
  const box = one.getBoundingClientRect();
  const found = document.elementFromPoint(box.x + box.width / 2, box.y + box.height / 2);
  const isWhole = box.left >= 0 && box.right <= innerWidth && box.top >= 0 && box.bottom <= innerHeight;
  return !isWhole || !found || !(one.contains(found) || found.contains(one));
})"""
STOP_COVERED = """() => {
  const stop = document.querySelector("#headland-stop .hl-stop");
  const box = stop.getBoundingClientRect();
  const spots = [[box.left + 4, box.top + 4], [box.right - 4, box.bottom - 4], [box.x + box.width / 2, box.y + 20]];
  const isSmall = box.left < 0 || box.width < 180 || box.height < 76;
  return isSmall || spots.some(([x, y]) => !stop.contains(document.elementFromPoint(x, y)));
}"""
SIDEWAYS = """() => ["html", ".h-main", ".h-screen", ".h-top", ".h-side"].filter((name) => {
  const one = document.querySelector(name);
  return one && one.scrollWidth > one.clientWidth + 1 && getComputedStyle(one).display !== "contents";
})"""
# buttons that no scrolling brings into the window
LOST = """() => [...document.querySelectorAll(".h-main :is(button, a[href], select, input)")].filter((one) => {
  if (!one.checkVisibility({ visibilityProperty: true }) || one.closest(".h-vh, svg")) return false;
  one.scrollIntoView({ block: "center", inline: "center" });
  const box = one.getBoundingClientRect();
  return box.width > 4 && (box.right > innerWidth + 1 || box.left < -1 || box.top < 0 || box.top > innerHeight - 24);
}).map((one) => one.dataset.testid ?? one.outerHTML.slice(0, 90))"""


def zoom(page: Page, window: str) -> None:
    """Give the page the window that is left of a tablet's at that zoom."""
    width, height = WINDOWS[window]
    page.set_viewport_size({"width": width, "height": height})


@pytest.mark.parametrize("window", WINDOWS)
@pytest.mark.parametrize("theme", ["day", "sunlight"])
def test_zoomed_a_running_robot_can_be_stopped_paused_and_left(
    look: Look, theatre: Theatre, window: str, theme: str
) -> None:
    theatre.play("running")
    page = look("/operate/weeder-07")
    page.evaluate("(theme) => HL.preferences.set('theme', theme)", theme)
    zoom(page, window)
    expect(page.get_by_test_id("mission-pause")).to_be_enabled()
    page.wait_for_function("() => document.querySelector('.h-nav.rest') || innerWidth >= 533")
    reached = ["mission-pause", "mission-return-home", "mission-abort", "drive-open", "nav-operate", "user-menu"]
    page.wait_for_function(f"(hooks) => ({UNREACHED})(hooks).length === 0", arg=reached)
    assert not page.evaluate(STOP_COVERED)
    assert page.evaluate(SIDEWAYS) == []


@pytest.mark.parametrize("window", WINDOWS)
@pytest.mark.parametrize("screen", SCREENS)
def test_zoomed_every_screen_is_reached_by_scrolling_down_only(
    look: Look, theatre: Theatre, window: str, screen: str
) -> None:
    theatre.play("running")
    page = look("/fleet", role="admin")
    page.get_by_test_id(f"nav-{screen}").click()
    expect(page.locator(f".h-screen[data-screen={screen}]")).to_be_visible()
    zoom(page, window)
    page.wait_for_function(f"() => ({LOST})().length === 0")
    assert page.evaluate(SIDEWAYS) == []
    assert not page.evaluate(STOP_COVERED)
    assert page.evaluate(UNREACHED, ["user-menu"]) == []


def test_what_is_chosen_and_stop_are_told_by_more_than_a_ground_in_forced_colours(look: Look, theatre: Theatre) -> None:
    theatre.play("running")
    page = look("/alarms")
    page.emulate_media(forced_colors="active")
    tab, other = page.get_by_test_id("alarms-tab-active"), page.get_by_test_id("alarms-tab-journal")
    expect(tab).to_be_visible()
    ground = "(one) => getComputedStyle(one).backgroundColor"
    page.wait_for_function(
        "() => getComputedStyle(document.querySelector('#headland-stop .hl-stop')).borderTopWidth === '3px'"
    )
    assert tab.evaluate(ground) != other.evaluate(ground)
    here, there = page.get_by_test_id("nav-alarms"), page.get_by_test_id("nav-fleet")
    assert here.evaluate(ground) != there.evaluate(ground)


def test_more_contrast_is_given_to_whom_the_system_says_wants_it(look: Look, theatre: Theatre) -> None:
    theatre.play("running")
    page = look("/fleet")
    ink = "() => getComputedStyle(document.documentElement).getPropertyValue('--hl-ink-3').trim()"
    for theme in ("day", "night"):
        page.emulate_media(contrast="no-preference")
        page.evaluate("(theme) => HL.preferences.set('theme', theme)", theme)
        before = page.evaluate(ink)
        page.emulate_media(contrast="more")
        assert page.evaluate(ink) != before, theme
