"""Without a pointer: what was opened is left by Escape to where it was opened, and a screen reader finds its way."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from playwright.sync_api import Page, expect

from tests.hmi.pages.conftest import Theatre

pytestmark = pytest.mark.browser
Look = Callable[..., Page]


@pytest.mark.parametrize(
    ("screen", "button", "first"),
    [
        ("operate", "robot-switch", ".h-menu .item"),
        ("operate", "user-menu", ".h-menu :is(.item, button, a)"),
        ("maps", "editor-layers", ".h-menu input"),
        ("maps", "editor-export", ".h-menu .item"),
    ],
)
def test_a_menu_left_by_escape_gives_the_focus_back_to_its_button(
    look: Look, theatre: Theatre, screen: str, button: str, first: str
) -> None:
    theatre.play("running")
    page = look("/operate/weeder-07", role="supervisor")
    if screen != "operate":
        page.get_by_test_id(f"nav-{screen}").click()
    opener = page.get_by_test_id(button)
    expect(opener).to_be_enabled()
    opener.focus()
    page.keyboard.press("Enter")
    expect(page.locator(first).and_(page.locator(":visible")).first).to_be_visible()
    page.keyboard.press("Escape")
    expect(opener).to_be_focused()


def test_choosing_a_person_by_key_keeps_the_focus_and_the_digits_are_told(look: Look, theatre: Theatre) -> None:
    page = look("/fleet", role="", is_new=True)
    page.evaluate("localStorage.setItem('headland.stop_token', 'token')")
    page.reload()
    other = page.get_by_test_id("login-person-supervisor")
    other.focus()
    page.keyboard.press("Enter")
    expect(other).to_have_attribute("aria-pressed", "true")
    expect(other).to_be_focused()
    page.keyboard.press("4")
    expect(page.get_by_role("img", name="1 of 4 digits")).to_be_visible()


def test_while_a_pin_is_checked_the_screen_says_so_and_nobody_else_is_chosen(look: Look, theatre: Theatre) -> None:
    page = look("/fleet", role="", is_new=True)
    page.evaluate("localStorage.setItem('headland.stop_token', 'token')")
    page.reload()
    page.evaluate("() => { HL.port.api = () => new Promise((answer) => { window.answer = answer; }); }")
    for digit in "1112":
        page.get_by_test_id(f"pin-{digit}").click()
    expect(page.get_by_text("Signing in")).to_be_visible()
    page.get_by_test_id("login-person-supervisor").click()
    expect(page.get_by_test_id("login-person-operator")).to_have_attribute("aria-pressed", "true")
    page.evaluate("window.answer({ ok: false, text: 'Wrong PIN. 3 tries left.' })")
    expect(page.get_by_test_id("login-error")).to_have_text("Wrong PIN. 3 tries left.")
    expect(page.get_by_text("PIN for Martha")).to_be_visible()
    page.get_by_test_id("login-person-supervisor").click()
    expect(page.get_by_test_id("login-error")).to_have_text("")


def test_a_screen_reader_finds_one_main_and_headings_of_the_alarm_table(look: Look, theatre: Theatre) -> None:
    theatre.play("running")
    page = look("/alarms")
    expect(page.get_by_role("main")).to_have_count(1)
    table = page.get_by_role("table", name="Alarms")
    expect(table).to_have_attribute("aria-owns", "al-head")
    expect(page.locator("#al-head").get_by_role("columnheader", name="Robot")).to_have_count(1)
    expect(page.get_by_role("tab")).to_have_count(0)
    expect(page.get_by_test_id("alarms-tab-active")).to_have_attribute("aria-pressed", "true")
