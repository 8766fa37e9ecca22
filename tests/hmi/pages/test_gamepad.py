"""Driving with a gamepad: the trigger is the dead-man, and nothing sets off by itself."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from playwright.sync_api import Page, expect

from tests.hmi.pages.conftest import Theatre
from tests.hmi.pages.test_operate import Look, open_drive

pytestmark = pytest.mark.browser
PAD = """(() => {
  const button = () => ({ pressed: false, value: 0 });
  const pad = (window.stagePad = { connected: true, axes: [0, 0, 0, 0], buttons: Array.from({ length: 17 }, button) });
  navigator.getGamepads = () => [null, pad.connected ? pad : null];
})()"""
SEVERAL_BEATS_MS = 600


def squeeze(page: Page, *, is_held: bool = True) -> None:
    page.evaluate("held => { stagePad.buttons[7].value = held ? 1 : 0; }", is_held)


def push(page: Page, ahead: float) -> None:
    page.evaluate("ahead => { stagePad.axes[1] = -ahead; }", ahead)


def stays_still(page: Page, theatre: Theatre) -> bool:
    """Say whether, from now on and for several beats, no setpoint but zero is sent."""
    before = len(theatre.heard()["drives"])
    page.wait_for_timeout(SEVERAL_BEATS_MS)
    return all(one["v"] == one["w"] == 0 for one in theatre.heard()["drives"][before:])


@pytest.fixture
def page(look: Look, theatre: Theatre) -> Page:
    """Return a page that drives by hand with a gamepad at rest."""
    theatre.play("manual")
    page: Page = look()
    page.evaluate(PAD)
    return page


def drive(page: Page, theatre: Theatre) -> None:
    """Let go, then squeeze and push: the robot is told to go ahead."""
    squeeze(page, is_held=False)
    page.wait_for_function("HL.drive.isStickReady && !HL.drive.blockedBy")
    squeeze(page)
    push(page, 1)
    theatre.until_drives(lambda drives: drives[-1]["v"] > 0)


@pytest.mark.long
def test_a_stick_alone_moves_nothing_and_letting_go_of_the_trigger_stops(page: Page, theatre: Theatre) -> None:
    open_drive(page)
    push(page, 1)
    assert stays_still(page, theatre)
    drive(page, theatre)
    push(page, 0)
    theatre.until_drives(lambda drives: drives[-1]["v"] == 0)
    push(page, -1)
    theatre.until_drives(lambda drives: drives[-1]["v"] < 0)
    squeeze(page, is_held=False)
    theatre.until_drives(lambda drives: drives[-1]["v"] == 0)
    assert stays_still(page, theatre)


def test_a_trigger_held_when_driving_begins_has_to_be_let_go_first(page: Page, theatre: Theatre) -> None:
    squeeze(page)
    push(page, 1)
    open_drive(page)
    assert stays_still(page, theatre)
    drive(page, theatre)


def finger(page: Page) -> None:
    """Press a pad on the screen as well, and let go of it."""
    page.get_by_test_id("drive-left").hover()
    page.mouse.down()
    page.wait_for_function("!HL.drive.held.size")
    page.mouse.up()


INTERRUPTIONS: dict[str, Callable[[Page], object]] = {
    "lost focus": lambda page: page.evaluate("window.dispatchEvent(new Event('blur'))"),
    "refused": lambda page: page.evaluate("HL.drive.refused({ robot: HL.drive.robot, code: 'late', text: 'Late' })"),
    "a finger beside it": finger,
    "unplugged": lambda page: page.evaluate("stagePad.connected = false"),
}


@pytest.mark.parametrize(
    "name",
    ["lost focus", *(pytest.param(name, marks=pytest.mark.long) for name in INTERRUPTIONS if name != "lost focus")],
)
def test_after_an_interruption_it_rests_until_the_trigger_was_let_go(page: Page, theatre: Theatre, name: str) -> None:
    open_drive(page)
    drive(page, theatre)
    INTERRUPTIONS[name](page)
    theatre.until_drives(lambda drives: drives[-1]["v"] == 0)
    page.evaluate("stagePad.connected = true")
    assert stays_still(page, theatre), "the trigger is still held"
    drive(page, theatre)


def test_a_delay_that_is_over_does_not_set_it_going_again(page: Page, theatre: Theatre) -> None:
    open_drive(page)
    drive(page, theatre)
    theatre._post("/stage-set", {"rtt_s": 0.34})
    expect(page.get_by_test_id("drive-forward")).to_have_attribute("data-state", "off")
    theatre._post("/stage-set", {"rtt_s": 0.02})
    expect(page.get_by_test_id("drive-forward")).to_have_attribute("data-state", "idle")
    assert stays_still(page, theatre), "the trigger is still held"
    drive(page, theatre)
