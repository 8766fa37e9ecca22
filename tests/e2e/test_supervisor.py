"""Supervisor of a planter at work in the real simulator: nodes, trees, crane, trays, and a console that freezes."""

from __future__ import annotations

import os
import re
import signal
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from playwright.sync_api import Browser, expect

from tests.e2e.installation import Installation
from tests.e2e.person import Person, wait_for

pytestmark = [pytest.mark.browser, pytest.mark.broker, pytest.mark.long]
ROBOT = "planter-01"
SCREEN = f"/supervisor/{ROBOT}"
DOCK = "hl-super-dock > :is(button, .h-slide)"


@pytest.fixture(scope="module")
def farm(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Installation]:
    """The whole demo farm, with a planter that plants."""
    running = Installation.start(tmp_path_factory.mktemp("planters") / "data", fleet="full")
    wait_for(lambda: running.world(ROBOT)["mode"] == "auto", within_s=120, what="the planter is at work")
    yield running
    running.end()


@pytest.fixture(scope="module")
def admin(farm: Installation, plain_browser: Browser) -> Iterator[Person]:
    """An admin who is signed in once: control of the planter is theirs through all tests."""
    context = plain_browser.new_context(viewport={"width": 1280, "height": 800}, has_touch=True, base_url=farm.url)
    person = Person("admin", context, farm)
    person.sign_in()
    yield person
    context.close()


@pytest.fixture
def vera(admin: Person, farm: Installation) -> Person:
    """The admin at the Supervisor screen of the planter, which has no fault."""
    farm.mend(ROBOT)
    admin.open(SCREEN)
    expect(admin.page.locator("hl-super-dock")).to_have_attribute("data-state", "planter", timeout=20_000)
    return admin


def inside(person: Person, what: str) -> Any:
    """Return what the robot said last of its inside."""
    return person.page.evaluate(f"window.headland.state('inside/{ROBOT}')?.{what}")


def joint(person: Person, name: str) -> float:
    """Return where a joint stands."""
    return next(float(one["value"]) for one in inside(person, "joints.joints") if one["name"] == name)


def is_active(person: Person, state: str) -> Callable[[], bool]:
    """Return a question: is the planter in this state?"""
    return lambda: state in (person.hook("chart-states").get_attribute("data-active") or "").split()


def test_a_failed_node_is_restarted_others_are_stopped_and_started(vera: Person, farm: Installation) -> None:
    farm.fault(ROBOT, "node-failure", node="crane")
    vera.sees("node-crane", "failure", within_s=10)
    vera.sees("function-move-crane", "off")
    vera.hook("nodes-restart").click()
    expect(vera.hook("restart-sheet").get_by_role("button").first).to_contain_text("Crane controller")
    vera.hook("restart-crane").click()
    vera.hook("node-restart").click()
    vera.slide("node-restart")
    vera.sees("node-crane", "started", within_s=15)
    vera.sees("function-move-crane", "on", within_s=10)
    vera.page.keyboard.press("Escape")
    for act, state in (("stop", "stopped"), ("start", "started")):
        vera.hook("node-tray-feeder").click()
        vera.hook(f"node-{act}").click()
        vera.slide(f"node-{act}")
        vera.sees("node-tray-feeder", state, within_s=15)
        vera.page.keyboard.press("Escape")


def test_a_tree_is_skipped_the_crane_is_moved_by_hand_and_retracted_and_trays_are_filled(
    vera: Person, farm: Installation
) -> None:
    go_on(vera)
    wait_for(is_active(vera, "crane"), within_s=90, what="it plants")
    expect(vera.hook("target-skip")).to_contain_text(re.compile(r"Skip tree \d"), timeout=90_000)  # it drives first
    vera.hook("target-skip").click()
    wait_for(lambda: "skipped" in statuses(vera), within_s=10, what="a place is skipped")
    farm.fault(ROBOT, "tray-empty", left=0)
    expect(vera.hook("stock-refilled")).to_be_visible(timeout=150_000)  # it plants what head and arm hold first
    farm.mend(ROBOT)
    vera.hook("stock-refilled").click()
    vera.slide("stock-refilled")
    expect(vera.hook("target-skip")).to_be_visible(timeout=20_000)
    vera.hook("mission-pause").click()
    expect(vera.hook("resume-on-operate")).to_be_visible(timeout=20_000)
    vera.hook("jog-open").click()
    expect(vera.hook("jog-sheet")).to_contain_text("Hold a pad to move", timeout=10_000)
    before = joint(vera, "slew")
    vera.hold("jog-slew-plus")
    wait_for(lambda: abs(joint(vera, "slew") - before) > 0.03, within_s=15, what="the crane turns")
    vera.let_go()
    vera.hook("jog-sheet").get_by_text("End manual").click()
    expect(vera.hook("tool-retract")).not_to_have_attribute("aria-disabled", "true", timeout=20_000)
    vera.hook("tool-retract").click()
    vera.slide("tool-retract")
    expect(vera.hook("tool-retract")).to_contain_text("Accepted", timeout=10_000)


def statuses(person: Person) -> list[str]:
    """Return what became of the places of this stop."""
    return [one["status"] for one in (inside(person, "site?.targets") or [])]


def go_on(person: Person) -> None:
    """Resume on Operate where it is paused, as the dock says, and come back."""
    if person.hook("resume-on-operate").count():
        person.hook("resume-on-operate").click()
        person.slide("mission-resume")
        expect(person.hook("mission-pause")).to_be_visible(timeout=20_000)
        person.open(SCREEN)
    expect(person.hook("mission-pause")).not_to_have_attribute("aria-disabled", "true", timeout=20_000)


def test_a_frozen_console_takes_every_order_away_before_it_would_be_refused(vera: Person, farm: Installation) -> None:
    console = farm.pid("console")
    os.kill(console, signal.SIGSTOP)
    try:
        vera.page.wait_for_timeout(2600)
        controls = vera.page.locator(DOCK)
        assert controls.count() == 4
        assert [one.get_attribute("aria-disabled") for one in controls.all()] == ["true"] * 4
        expect(vera.page.locator("hl-super-dock")).to_contain_text("Commands are off until the link is back.")
    finally:
        os.kill(console, signal.SIGCONT)
    vera.sees("link-banner", "ok", within_s=20)


def test_stopped_nothing_looks_possible_but_the_way_to_the_reset(vera: Person, farm: Installation) -> None:
    vera.press_stop()
    expect(vera.hook("reset-on-operate")).to_be_visible(timeout=5000)
    controls = vera.page.locator(DOCK)
    assert controls.count() == 3
    assert [one.get_attribute("aria-disabled") for one in controls.all()] == ["true"] * 3
    expect(vera.page.locator("hl-super-dock")).to_contain_text("Stopped. Reset the stop on Operate first.")
    wait_for(lambda: farm.world(ROBOT)["standstill"], within_s=10, what="it stands")
    vera.hook("reset-on-operate").click()
    expect(vera.hook("stop-reset")).to_be_visible(timeout=10_000)
    vera.hook("stop-reason-test").click()
    vera.slide("stop-reset")
    wait_for(lambda: not farm.world(ROBOT)["latched"], within_s=10, what="the stop is reset")
