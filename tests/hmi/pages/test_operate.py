"""Operate as an operator meets it: values with their age, actions by state, slides, driving, control."""

from __future__ import annotations

import json
import re
import urllib.request
from collections.abc import Callable

import pytest
from playwright.sync_api import Page, Route, expect

from tests.hmi.pages.conftest import SIZES, TABLETS, Theatre
from tests.hmi.pages.fingers import hold

pytestmark = pytest.mark.browser
Look = Callable[..., Page]


def slide(page: Page, hook: str, *, share: float = 1.0, is_released: bool = True) -> None:
    """Drag the thumb of a slide over ``share`` of its way."""
    thumb = page.get_by_test_id(f"{hook}-thumb")
    thumb.scroll_into_view_if_needed()
    box, track = thumb.bounding_box(), page.get_by_test_id(hook).bounding_box()
    assert box is not None
    assert track is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    way = (track["width"] - box["width"]) * share
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + way / 2, y, steps=4)
    page.mouse.move(x + way, y, steps=4)
    if is_released:
        page.mouse.up()


@pytest.mark.parametrize("size", TABLETS)
def test_every_value_is_shown_with_its_age_and_in_si(look: Look, theatre: Theatre, size: str) -> None:
    theatre.play("running")
    page = look(size=size)
    for key, value in {
        "speed": "0.42",
        "battery": "0.68",
        "gnss": "0.014",
        "tool": "on",
        "cross-track": "0.009",
    }.items():
        tile = page.get_by_test_id(f"value-{key}")
        expect(tile).to_have_attribute("data-value", value)
        expect(tile).to_have_attribute("data-state", "fresh")
        expect(tile).to_have_attribute("data-age-ms", re.compile(r"^\d{1,4}$"))
    expect(page.get_by_test_id("value-row")).to_have_text("37")
    expect(page.get_by_test_id("value-area")).to_contain_text("7.60 of 17.26 ha")
    expect(page.get_by_test_id("robot-mode")).to_have_attribute("data-state", "auto")
    expect(page.get_by_test_id("link-banner")).to_have_attribute("data-state", "ok")


CUT = """() => [...document.querySelectorAll('.h-tile, .h-tile .sub, .h-facts b, .h-path .leaf')]
  .filter((one) => getComputedStyle(one).display !== 'inline')
  .filter((one) => one.scrollHeight > one.clientHeight + 1 || one.scrollWidth > one.clientWidth + 1)
  .map((one) => one.textContent)"""


@pytest.mark.parametrize("size", SIZES)
def test_nothing_scrolls_sideways_and_all_actions_are_in_reach(look: Look, theatre: Theatre, size: str) -> None:
    theatre.play("paused")
    page = look(size=size)
    for hook in ("mission-resume", "mission-return-home", "mission-abort", "drive-open", "stop", "stop-all"):
        box = page.get_by_test_id(hook).first.bounding_box()
        assert box is not None, hook
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= SIZES[size][0] + 1
        assert box["y"] + box["height"] <= SIZES[size][1] + 1, f"{hook} is below the glass"
        assert min(box["width"], box["height"]) >= 64
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    theatre.play("running")
    page.evaluate("HL.preferences.set('theme', 'sunlight')")  # its letters are the largest
    expect(page.locator(".h-path .leaf")).to_have_text("Laser firing")
    expect(page.get_by_test_id("mission-change")).to_be_visible()
    assert page.evaluate(CUT) == []


@pytest.mark.parametrize("size", SIZES)
def test_what_is_said_in_a_corner_takes_no_touch_and_covers_no_action(look: Look, theatre: Theatre, size: str) -> None:
    theatre.play("paused")
    page = look(size=size)
    expect(page.get_by_test_id("actions")).to_be_visible()
    page.evaluate("HL.toast('Martha Keller has control of Weeder 07, which stands at the end of a row.')")
    said, actions = page.locator(".h-toast").bounding_box(), page.get_by_test_id("actions").bounding_box()
    assert said is not None
    assert actions is not None
    apart = said["y"] + said["height"] <= actions["y"] or said["x"] >= actions["x"] + actions["width"]
    assert apart or said["x"] + said["width"] <= actions["x"], (said, actions)
    at = {"x": said["x"] + said["width"] / 2, "y": said["y"] + said["height"] / 2}
    assert page.evaluate("({ x, y }) => document.elementFromPoint(x, y).closest('.h-toast') === null", at)


def test_old_values_turn_stale_and_then_the_link_is_lost(look: Look, theatre: Theatre) -> None:
    theatre.play("running")
    page = look()
    expect(page.get_by_test_id("value-speed")).to_have_attribute("data-state", "fresh")
    theatre.play("silent")
    expect(page.get_by_test_id("value-speed")).to_have_attribute("data-state", "stale", timeout=4000)
    assert page.get_by_test_id("value-speed").get_attribute("data-value") == "0.42"
    expect(page.get_by_test_id("link-banner")).to_have_attribute("data-state", "robot-lost", timeout=4000)
    expect(page.get_by_test_id("link-banner")).to_contain_text("It pauses by itself after 3.5 s")
    expect(page.get_by_test_id("actions")).to_contain_text("Commands are off until the link is back.")
    expect(page.get_by_test_id("mission-pause")).to_have_attribute("aria-disabled", "true")
    page.get_by_test_id("mission-pause").click(force=True)
    expect(page.get_by_test_id("toast")).to_contain_text("Commands are off until the link is back.")
    assert theatre.orders("commands") == []


def test_pause_is_one_press(look: Look, theatre: Theatre) -> None:
    theatre.play("running")
    page = look()
    page.get_by_test_id("mission-pause").click()
    expect(page.get_by_test_id("mission-pause")).to_have_attribute("data-state", "accepted")
    [order] = theatre.until_orders("weeder-07/commands")
    assert order["action"] == "pause"
    assert order["tick"].startswith("stage-")


def test_a_slide_that_is_let_go_early_sends_nothing(look: Look, theatre: Theatre) -> None:
    theatre.play("paused")
    page = look()
    slide(page, "mission-resume", share=0.7)
    expect(page.get_by_test_id("mission-resume")).to_have_attribute("data-state", "idle")
    assert theatre.orders("commands") == []


def test_a_slide_past_the_flag_sends_the_order_once(look: Look, theatre: Theatre) -> None:
    theatre.play("paused")
    page = look()
    slide(page, "mission-resume", is_released=False)
    expect(page.get_by_test_id("mission-resume")).to_have_attribute("data-state", "armed")
    assert theatre.orders("commands") == []
    page.mouse.up()
    expect(page.get_by_test_id("mission-resume")).to_have_attribute("data-state", "confirmed")
    assert [order["action"] for order in theatre.until_orders("commands")] == ["resume"]


def test_a_refused_slide_says_why(look: Look, theatre: Theatre) -> None:
    theatre.play("paused", outcome="rejected", text="Area not clear. Look at the camera.")
    page = look()
    slide(page, "mission-resume")
    expect(page.get_by_test_id("mission-resume")).to_have_attribute("data-state", "refused")
    expect(page.get_by_test_id("mission-resume")).to_contain_text("Area not clear. Look at the camera.")


def test_a_second_touch_cancels_a_slide(look: Look, theatre: Theatre) -> None:
    theatre.play("paused")
    page = look()
    slide(page, "mission-resume", is_released=False)
    page.evaluate("window.dispatchEvent(new PointerEvent('pointerdown', {pointerId: 77, bubbles: true}))")
    expect(page.get_by_test_id("mission-resume")).to_have_attribute("data-state", "idle")
    page.mouse.up()
    assert theatre.orders("commands") == []


def test_holding_enter_confirms_without_a_drag(look: Look, theatre: Theatre) -> None:
    theatre.play("paused")
    page = look()
    expect(page.get_by_test_id("value-speed")).to_have_attribute("data-state", "fresh")
    page.get_by_test_id("mission-resume").focus()
    page.keyboard.down("Enter")
    expect(page.get_by_test_id("mission-resume")).to_have_attribute("data-state", "armed")
    expect(page.get_by_test_id("mission-resume")).to_have_attribute("data-state", "confirmed", timeout=3000)
    page.keyboard.up("Enter")
    assert [order["action"] for order in theatre.until_orders("commands")] == ["resume"]


def test_abort_opens_a_slide_and_escape_closes_it(look: Look, theatre: Theatre) -> None:
    theatre.play("running")
    page = look()
    page.get_by_test_id("mission-abort").click()
    expect(page.get_by_test_id("mission-abort-thumb")).to_be_visible()
    expect(page.get_by_test_id("mission-abort")).to_have_attribute("data-state", "armed")
    page.get_by_test_id("mission-abort").focus()
    page.keyboard.press("Escape")
    expect(page.get_by_test_id("mission-abort-thumb")).to_be_hidden()
    page.get_by_test_id("mission-abort").click()
    slide(page, "mission-abort")
    expect(page.get_by_test_id("mission-pause")).to_be_visible()
    assert [order["action"] for order in theatre.until_orders("commands")] == ["abort"]


def test_reset_needs_a_reason_and_resume_waits_for_it(look: Look, theatre: Theatre) -> None:
    theatre.play("latched")
    page = look()
    expect(page.get_by_test_id("robot-mode")).to_have_attribute("data-state", "stopped")
    expect(page.get_by_test_id("mission-resume")).to_contain_text("Reset the stop first")
    slide(page, "stop-reset")
    expect(page.get_by_test_id("stop-reset")).to_contain_text("Tap a reason first.")
    assert theatre.orders("stop-reset") == []
    page.get_by_test_id("stop-reason-person").click()
    slide(page, "stop-reset")
    expect(page.get_by_test_id("stop-reset")).to_have_attribute("data-state", "confirmed")
    [order] = theatre.until_orders("stop-reset")
    assert order["reason"] == "Person"
    assert order["stop_ids"] == ["d" * 32]


def test_a_viewer_watches_and_is_told_what_is_missing(look: Look, theatre: Theatre) -> None:
    theatre.play("paused")
    page = look(role="viewer")
    expect(page.get_by_test_id("actions")).to_contain_text("You can watch Weeder 07. Driving needs the operator role.")
    slide(page, "mission-resume")
    expect(page.get_by_test_id("mission-resume")).to_have_attribute("data-state", "idle")
    expect(page.get_by_test_id("stop")).to_be_visible()
    assert theatre.orders("commands") == []


def test_control_of_somebody_else_is_shown_and_asked_for(look: Look, theatre: Theatre) -> None:
    theatre.play("paused", owner="supervisor")
    page = look()
    expect(page.get_by_test_id("lease-owner")).to_have_text("Anna Ostermeier has control")
    expect(page.get_by_test_id("mission-resume")).to_contain_text("Anna Ostermeier has control. Ask for it.")
    page.get_by_test_id("lease-request").click()
    expect(page.get_by_test_id("toast")).to_be_attached()
    assert [order["op"] for order in theatre.until_orders("lease")] == ["request"]


def test_a_request_for_control_is_answered_in_one_press(look: Look, theatre: Theatre) -> None:
    theatre.play("held")
    page = look()
    expect(page.get_by_text("Anna Ostermeier asks for control.")).to_be_visible()
    page.get_by_test_id("lease-grant").click()
    expect(page.get_by_test_id("lease-owner")).to_have_text("You have control")
    assert [(order["op"], order["session"]) for order in theatre.until_orders("lease")] == [("grant", "supervisor")]


def test_why_it_does_not_move_is_one_sentence(look: Look, theatre: Theatre) -> None:
    theatre.play("held")
    page = look()
    expect(page.get_by_test_id("robot-why")).to_contain_text("A person is 4 m ahead.")
    expect(page.get_by_test_id("robot-why")).to_contain_text("It goes on when the person has left.")


def drives(theatre: Theatre) -> list[dict[str, float]]:
    """Return the setpoints heard so far."""
    found: list[dict[str, float]] = theatre.heard()["drives"]
    return found


def open_drive(page: Page) -> None:
    """Open manual driving, once the delay is no longer that of a page which is still building itself."""
    page.wait_for_function("headland.rtt() !== null && headland.rtt() < 150")
    page.get_by_test_id("drive-open").click()
    expect(page.get_by_test_id("drive-forward")).to_have_attribute("data-state", "idle")


@pytest.mark.parametrize("size", TABLETS)
def test_the_robot_drives_only_while_a_pad_is_held(look: Look, theatre: Theatre, size: str) -> None:
    theatre.play("manual")
    page = look(size=size)
    open_drive(page)
    hold(page, page.get_by_test_id("drive-forward"))
    theatre.until_drives(lambda drives: len(drives) >= 3)
    page.mouse.up()
    expect(page.get_by_test_id("drive-forward")).to_have_attribute("data-state", "idle")
    theatre.until_drives(lambda drives: drives[-1]["v"] == 0)
    assert {d["v"] for d in drives(theatre)} == {0.2, 0.0}


HIDE = """
Object.defineProperty(document, 'hidden', {value: true, configurable: true});
document.dispatchEvent(new Event('visibilitychange'));
"""
ENDS = {
    "lost focus": "window.dispatchEvent(new Event('blur'))",
    "a second touch": "window.dispatchEvent(new PointerEvent('pointerdown', {pointerId: 77, bubbles: true}))",
    "a cancelled touch": "window.dispatchEvent(new PointerEvent('pointercancel', {pointerId: 1, bubbles: true}))",
    "a hidden tab": HIDE,
}


@pytest.mark.parametrize(
    "end", ["lost focus", *(pytest.param(end, marks=pytest.mark.long) for end in ENDS if end != "lost focus")]
)
def test_whatever_ends_the_touch_gives_zero_at_once(look: Look, theatre: Theatre, end: str) -> None:
    theatre.play("manual")
    page = look()
    open_drive(page)
    page.get_by_test_id("drive-left").hover()
    page.mouse.down()
    theatre.until_drives(lambda drives: any(one["w"] > 0 for one in drives))
    page.evaluate(ENDS[end])
    expect(page.get_by_test_id("drive-left")).not_to_have_attribute("data-state", "held")
    theatre.until_drives(lambda drives: drives[-1]["w"] == 0)
    page.mouse.up()


def test_arrow_keys_drive_and_a_second_one_turns_it_into_an_arc(look: Look, theatre: Theatre) -> None:
    theatre.play("manual")
    page = look()
    open_drive(page)
    page.keyboard.down("ArrowUp")
    page.keyboard.down("ArrowRight")
    theatre.until_drives(lambda drives: any(one["v"] > 0 > one["w"] for one in drives))
    page.keyboard.up("ArrowRight")
    page.keyboard.up("ArrowUp")
    theatre.until_drives(lambda drives: drives[-1]["v"] == 0)


def test_a_slow_link_switches_driving_off(look: Look, theatre: Theatre) -> None:
    theatre.play("manual")
    page = look()
    open_drive(page)
    theatre._post("/stage-set", {"rtt_s": 0.34})
    expect(page.get_by_test_id("drive-forward")).to_have_attribute("data-state", "off")
    expect(page.get_by_test_id("drive-forward")).to_contain_text("Off, ")
    page.get_by_test_id("drive-forward").hover()
    page.mouse.down()
    page.mouse.up()
    assert drives(theatre) == []


@pytest.mark.long
def test_speeds_above_slow_are_locked_and_units_follow_the_person(look: Look, theatre: Theatre) -> None:
    theatre.play("manual")
    page = look()
    open_drive(page)
    expect(page.get_by_test_id("drive-speed-fast")).to_be_disabled()
    page.get_by_test_id("user-menu").click()
    page.get_by_test_id("units-speed").get_by_text("km/h").click()
    expect(page.get_by_test_id("value-speed")).to_contain_text("0.6")
    expect(page.get_by_test_id("value-speed")).to_contain_text("km/h")
    expect(page.get_by_test_id("value-speed")).to_have_attribute("data-value", "0.18")


def test_leaving_the_screen_ends_driving(look: Look, theatre: Theatre) -> None:
    theatre.play("manual")
    page = look()
    open_drive(page)
    page.get_by_test_id("nav-fleet").click()
    expect(page.get_by_test_id("fleet-row-weeder-07")).to_be_visible()
    theatre.until_heard(lambda heard: any(order.get("action") == "drive_close" for order in heard["orders"]))


def test_control_is_kept_alive_on_every_screen(look: Look, theatre: Theatre) -> None:
    theatre.play("paused")
    page = look()
    expect(page.get_by_test_id("lease-owner")).to_have_text("You have control")
    page.get_by_test_id("nav-fleet").click()
    expect(page.get_by_test_id("fleet-row-weeder-07")).to_be_visible()
    before = heres(theatre)
    theatre.until_heard(lambda heard: heard["heres"] > before + 1)


def heres(theatre: Theatre) -> int:
    """Return how many proofs of an open page were heard."""
    with urllib.request.urlopen(f"{theatre.url}/stage-heard") as reply:
        return int(json.loads(reply.read())["heres"])


WAKE_LOCK = """window.locks = []; Object.defineProperty(navigator, 'wakeLock', {value: {request: async (kind) => {
    const lock = new EventTarget(); lock.kind = kind; lock.isOn = true;
    lock.release = async () => { lock.isOn = false; lock.dispatchEvent(new Event('release')); };
    window.locks.push(lock); return lock; }}})"""


@pytest.mark.long
def test_the_screen_stays_on_exactly_while_one_has_control(look: Look, theatre: Theatre) -> None:
    theatre.play("paused", owner="operator")
    page = look(is_new=True)
    page.context.add_init_script(WAKE_LOCK)
    page.reload()
    expect(page.get_by_test_id("lease-owner")).to_have_text("You have control")
    page.wait_for_function("window.locks.some((lock) => lock.isOn)")
    theatre.play("paused", owner="supervisor")
    page.wait_for_function("window.locks.every((lock) => !lock.isOn)")
    page.get_by_test_id("user-menu").click()
    expect(page.get_by_test_id("stay-awake")).to_have_text("This screen stays on while you have control.")


def test_what_is_pressed_before_its_script_has_come_opens_when_it_has(look: Look, theatre: Theatre) -> None:
    """The sheets of a mission come after the first picture, which takes seconds on a slow tablet."""
    theatre.play("idle")
    page = look("/fleet")
    held: list[Route] = []
    page.route("**/static/bundle/run.js*", lambda route: held.append(route))
    with page.expect_request("**/static/bundle/run.js*"):
        page.goto("/operate/weeder-07")
        page.get_by_test_id("mission-checks").click()
    expect(page.get_by_test_id("start-sheet")).to_have_count(0)
    held[0].continue_()
    expect(page.get_by_test_id("start-sheet")).to_be_visible()
