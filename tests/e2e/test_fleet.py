"""The fleet with real processes: group orders with a silent robot, STOP ALL counted on the screen, a wall screen."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest
from playwright.sync_api import expect

from tests.e2e.installation import Installation
from tests.e2e.person import Person, wait_for
from tests.e2e.test_farmer import send_mission

Come = Callable[..., Person]

pytestmark = [pytest.mark.browser, pytest.mark.long]
AWAY_M = 4.0  # a robot that stands at home is not sent there


def test_two_robots_go_home_together_and_the_silent_one_is_named_and_tried_again(
    person: Come, calm: Installation
) -> None:
    anna = person("supervisor")
    send_mission(anna)
    anna.operate("weeder-01")
    anna.slide("mission-start")
    wait_for(lambda: calm.world("weeder-01")["distance_m"] > AWAY_M, within_s=60, what="it left its home")
    anna.open("/fleet")
    expect(anna.hook("fleet-row-weeder-02")).to_be_visible()
    for robot in ("weeder-01", "weeder-02"):
        anna.hook(f"fleet-pick-{robot}").check()
    calm.fault("weeder-02", "silence", http=True, deaf=True)
    expect(anna.hook("fleet-row-weeder-02")).to_contain_text("No link for", timeout=10_000)
    anna.hook("fleet-do-home").click()
    expect(anna.hook("fleet-home-names")).to_contain_text("No link. It will not hear this")
    anna.slide("fleet-home")
    expect(anna.hook("fleet-results-sum")).to_have_attribute("data-value", "1/2", timeout=10_000)
    expect(anna.hook("fleet-result-weeder-02")).to_contain_text(re.compile("No link|not known right now"))
    assert calm.world("weeder-01")["mode"] == "auto"
    calm.mend("weeder-02")
    anna.page.keyboard.press("Escape")
    expect(anna.hook("fleet-row-weeder-02")).not_to_contain_text("No link for", timeout=10_000)
    anna.hook("fleet-do-pause").click()
    expect(anna.hook("fleet-results")).to_be_visible(timeout=10_000)
    expect(anna.hook("fleet-result-weeder-01")).to_have_attribute("data-state", "accepted")


def test_stop_all_names_the_robot_that_lost_its_link_and_does_not_count_it(person: Come, calm: Installation) -> None:
    anna = person("supervisor")
    anna.open("/fleet")
    anna.sees("stop", "ready")
    calm.fault("weeder-02", "silence", http=True, deaf=True)
    expect(anna.hook("fleet-row-weeder-02")).to_contain_text("No link for", timeout=10_000)
    anna.press_stop()
    card = anna.hook("fleet-stop")
    expect(card).to_have_attribute("data-standing", "2", timeout=10_000)
    expect(card).to_have_attribute("data-total", "3")
    name = anna.page.evaluate("HL.port.fleet()['weeder-02'].name")
    expect(card).to_contain_text(f"No link: {name}. Not counted as stopped")
    expect(card).to_contain_text("queue is frozen", timeout=10_000)
    expect(anna.hook("fleet-row-weeder-02")).to_contain_text("Stop not confirmed", timeout=10_000)
    calm.mend("weeder-02")
    expect(card).to_have_attribute("data-standing", "3", timeout=20_000)


def test_a_wall_screen_opens_by_its_address_stops_and_goes_dark_when_it_is_taken_out(
    person: Come, calm: Installation
) -> None:
    anna = person("supervisor")
    anna.open("/fleet")
    anna.hook("fleet-filter").click()
    anna.hook("wall-manage").click()
    anna.hook("wall-name").fill("Barn")
    anna.hook("wall-make").click()
    address = anna.hook("wall-link").input_value()
    browser = anna.context.browser
    assert browser is not None
    barn = browser.new_context(viewport={"width": 1920, "height": 1080})
    try:
        wall = barn.new_page()
        wall.goto(address)
        expect(wall.get_by_test_id("wall-sum")).to_be_visible(timeout=20_000)
        assert "#" not in wall.url
        wall.reload()
        expect(wall.get_by_test_id("stop")).to_have_attribute("data-state", "ready", timeout=20_000)
        wall.keyboard.press("Control+.")
        expect(wall.get_by_test_id("stop")).to_have_attribute("data-state", "standstill", timeout=20_000)
        anna.hook("wall-revoke-Barn").click()
        expect(wall.get_by_test_id("login-name")).to_be_visible(timeout=20_000)
    finally:
        barn.close()
