"""Nodes, functions, log, dock and joints by hand on Supervisor, as a machine expert meets them."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import pytest
from playwright.sync_api import Page, expect

from tests.hmi.pages.conftest import SIZES, Theatre
from tests.hmi.pages.test_operate import slide

pytestmark = pytest.mark.browser
Look = Callable[..., Page]
SCREEN = "/supervisor/planter-09"
TROUBLE = {
    "camera-rear": {"state": "failure", "text": "No picture", "since_s": 41, "restarts": 3},
    "tree-planner": {"age_s": 60},
    "tray-feeder": {"state": "stopped", "rate_hz": 0.0},
    "rtk": {"clock_offset_s": 0.18},
}


@pytest.fixture
def machine(theatre: Theatre) -> Iterator[Theatre]:
    """The stage with a planter on it, taken away afterwards."""
    theatre.play("running")
    theatre.machine(nodes={})
    yield theatre
    theatre.machine(off=True)


def test_nodes_and_functions_say_what_is_wrong_why_and_what_turns_it_on(look: Look, machine: Theatre) -> None:
    machine.machine(nodes=TROUBLE)
    page = look(SCREEN, size="desk")
    expect(page.get_by_test_id("node-crane")).to_have_attribute("data-state", "started")
    expect(page.get_by_test_id("node-tray-feeder")).to_have_attribute("data-state", "stopped")
    failed = page.get_by_test_id("node-camera-rear")
    expect(failed).to_have_attribute("data-state", "failure")
    expect(failed).to_contain_text("Failed. No picture")
    lost = page.get_by_test_id("node-tree-planner")
    expect(lost).to_have_attribute("data-fresh", "stale")
    expect(lost).to_contain_text("Was started")
    expect(page.get_by_test_id("node-rtk")).to_contain_text("180 ms ahead")
    states = {"plant": "off", "follow-path": "on", "see-people": "limited", "back-up": "off", "manual-crane": "on"}
    for name, state in states.items():
        expect(page.get_by_test_id(f"function-{name}")).to_have_attribute("data-state", state)
    expect(page.get_by_test_id("function-back-up")).to_contain_text("Rear camera failed for 4")
    expect(page.get_by_test_id("function-hint")).to_contain_text("To turn on Plant trees: restart Tree planner")
    page.get_by_test_id("function-back-up").click()
    expect(page.get_by_test_id("function-hint")).to_have_text(
        "infoTo turn on Reverse over 0.3 m/s: restart Rear camera."
    )
    machine.machine(nodes={})
    expect(page.get_by_test_id("function-plant")).to_have_attribute("data-state", "on")
    expect(page.get_by_test_id("function-hint")).to_be_hidden()


def test_an_admin_restarts_a_node_by_a_slide_and_hears_the_answer(look: Look, machine: Theatre) -> None:
    machine.machine(nodes=TROUBLE)
    page = look(SCREEN, role="admin")
    page.get_by_test_id("node-camera-rear").click()
    sheet = page.get_by_test_id("node-sheet")
    expect(sheet).to_contain_text("Needed by: Reverse over 0.3 m/s.")
    page.get_by_test_id("node-restart").click()
    expect(page.get_by_test_id("node-restart")).to_contain_text("Turns off: Reverse over 0.3 m/s")
    slide(page, "node-restart", share=0.6)
    assert machine.orders("commands") == []
    slide(page, "node-restart")
    [order] = machine.until_orders("commands")
    assert (order["path"], order["action"], order["node"]) == (
        "robots/planter-09/commands",
        "node_restart",
        "camera-rear",
    )
    assert order["tick"]
    expect(page.get_by_test_id("node-restart")).to_contain_text("Accepted")


def test_without_the_right_nodes_are_watched_and_logs_are_searched(look: Look, machine: Theatre) -> None:
    page = look(SCREEN)
    page.get_by_test_id("node-crane").click()
    expect(page.get_by_test_id("node-sheet")).to_contain_text("Restarting nodes needs the admin role.")
    expect(page.get_by_test_id("node-restart")).to_be_hidden()
    page.get_by_test_id("node-sheet").get_by_text("Log", exact=True).click()
    lines = page.get_by_test_id("logs-lines")
    expect(lines).to_contain_text("crane soft limit near")
    expect(lines).not_to_contain_text("pulse")
    page.get_by_test_id("logs-node").select_option("")
    page.get_by_test_id("logs-search").fill("TIMEOUT")
    expect(page.get_by_test_id("logs-said")).to_contain_text("40 found in its last 160 lines")
    machine.machine(log_error="Planter 09 did not give its log: no answer. Try again.")
    expect(page.get_by_test_id("logs-said")).to_contain_text(
        "did not give its log: no answer. Try again. What is shown"
    )


def test_what_is_off_in_the_dock_says_why_and_sends_nothing(look: Look, machine: Theatre) -> None:
    machine.machine(oil=80.0, mode="paused")
    page = look(SCREEN)
    retract = page.get_by_test_id("tool-retract")
    expect(retract).to_have_attribute("aria-disabled", "true")
    expect(page.locator("hl-super-dock")).to_contain_text(
        "Retract crane: Move the crane is off: Oil at 80 °C, limit 75 °C."
    )
    page.get_by_test_id("jog-open").click(force=True)
    expect(page.get_by_test_id("toast")).to_contain_text("Crane by hand is off")
    assert machine.orders("commands") == []
    machine.machine(oil=60.0, mode="paused")
    expect(retract).not_to_have_attribute("aria-disabled", "true")
    retract.click()
    slide(page, "tool-retract")
    assert machine.until_orders("commands")[0]["action"] == "tool_retract"
    expect(page.get_by_test_id("target-skip")).to_have_text("keyboard_double_arrow_rightSkip tree 147")
    machine.machine(is_silent=True)
    expect(page.locator("hl-super-nodes")).to_contain_text("State data stopped", timeout=8000)
    expect(page.locator("hl-super-dock")).to_contain_text("Commands are off until the link is back.")


def open_joints(page: Page, machine: Theatre) -> None:
    """Open driving the crane by hand; the robot says that it is in manual."""
    page.get_by_test_id("jog-open").click()
    assert machine.until_orders("commands")[0]["action"] == "drive_open"
    machine.machine(mode="manual")
    expect(page.get_by_test_id("jog-slew")).to_contain_text("23°")


def until_jogs(machine: Theatre, count: int) -> list[dict[str, float]]:
    """Return the setpoints when there are as many."""
    end_s = time.monotonic() + 10
    while len(found := machine.heard()["jogs"]) < count and time.monotonic() < end_s:
        time.sleep(0.02)
    return list(found)


def hold(page: Page, hook: str) -> None:
    """Press a pad, once it stands still and may be pressed, and keep it."""
    expect(page.get_by_text("Hold a pad to move")).to_be_visible()
    page.get_by_test_id(hook).hover()  # waits until the sheet has come to rest
    page.mouse.down()


def test_a_joint_moves_while_its_pad_is_held_and_rests_at_once(look: Look, machine: Theatre) -> None:
    page = look(SCREEN, size="desk")
    open_joints(page, machine)
    hold(page, "jog-slew-plus")
    held = until_jogs(machine, 5)
    assert held[:5] == [{"slew": 0.1}] * 5
    page.mouse.up()
    expect(page.get_by_test_id("jog-slew-plus")).to_have_attribute("data-state", "idle")
    rest = [{"slew": 0}, {"slew": 0}]
    # one more may have gone out before the finger left
    count = len(machine.until_heard(lambda heard: heard["jogs"][-2:] == rest)["jogs"])
    # four periods of a setpoint that would still be sent, measured by the page's own clock
    page.evaluate(
        "() => new Promise((done) => { const end = performance.now() + 400;"
        " const look = () => (performance.now() < end ? requestAnimationFrame(look) : done()); look(); })"
    )
    assert len(machine.heard()["jogs"]) == count
    page.get_by_test_id("jog-speed-slow").click()
    hold(page, "jog-extension-minus")
    assert until_jogs(machine, count + 1)[count] == {"extension": -0.3}
    page.evaluate("window.dispatchEvent(new Event('blur'))")
    expect(page.get_by_test_id("jog-extension-minus")).to_have_attribute("data-state", "idle")
    assert until_jogs(machine, count + 2)[-1] == {"extension": 0}
    page.mouse.up()
    hold(page, "jog-boom-plus")
    until_jogs(machine, len(machine.heard()["jogs"]) + 1)
    page.evaluate("dispatchEvent(new PointerEvent('pointerdown', {pointerId: 77, bubbles: true}))")
    expect(page.get_by_test_id("jog-boom-plus")).to_have_attribute("data-state", "idle")
    page.mouse.up()


def test_a_stop_takes_the_pads_away_and_closing_them_ends_manual(look: Look, machine: Theatre) -> None:
    page = look(SCREEN, size="desk")
    open_joints(page, machine)
    machine.machine(mode="manual", is_latched=True)
    expect(page.get_by_test_id("jog-sheet")).to_have_count(0)
    expect(page.get_by_test_id("toast")).to_contain_text("Stopped. Reset the stop first.")
    machine.machine(mode="paused")
    expect(page.get_by_test_id("jog-open")).not_to_have_attribute("aria-disabled", "true")
    page.get_by_test_id("jog-open").click()
    machine.machine(mode="manual")
    page.get_by_test_id("jog-sheet").get_by_text("End manual").click()
    expect(page.get_by_test_id("jog-sheet")).to_have_count(0)
    assert [one["action"] for one in machine.until_orders("commands", 1)][-1] == "drive_close"


@pytest.mark.long
@pytest.mark.parametrize("size", SIZES)
def test_every_control_is_large_enough_and_nothing_is_cut(look: Look, machine: Theatre, size: str) -> None:
    machine.machine(nodes=TROUBLE)
    page = look(SCREEN, size=size)
    for hook in ("mission-pause", "tool-retract", "jog-open", "target-skip"):
        node = page.get_by_test_id(hook)
        box = node.bounding_box()
        assert box is not None, hook
        assert min(box["width"], box["height"]) >= 64
        assert node.evaluate("node => node.scrollWidth <= node.clientWidth + 1"), f"{hook} is cut"
        assert box["x"] >= 12, f"{hook} touches the edge of the screen"
        assert box["x"] + box["width"] <= SIZES[size][0] - (12 if size == "portrait" else 0)
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    row = page.get_by_test_id("node-crane").bounding_box()
    assert row is not None
    assert row["height"] >= (36 if size == "desk" else 48)


@pytest.mark.long
def test_a_robot_that_tells_nothing_of_its_inside_says_so(look: Look, machine: Theatre) -> None:
    machine.machine(off=True)
    machine.machine(is_mute=True)
    page = look(SCREEN)
    expect(page.locator("hl-super-nodes")).to_contain_text("Planter 09 tells nothing of its nodes.")
    expect(page.locator("hl-super-functions")).to_contain_text("Planter 09 does not tell what it can do.")
