"""What can be read and reached: contrast, targets, nothing cut and nothing covered, measured in the three themes."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from tests.hmi.pages.conftest import Theatre
from tests.hmi.pages.test_missions import Played, mission
from tests.hmi.pages.test_plan import PlayedPlans
from tests.hmi.pages.test_queue import PlayedQueue, entry, robot, utc, whole

pytestmark = pytest.mark.browser
Look = Callable[..., Page]
THEMES = ("day", "night", "sunlight")
LEAST = {"day": 4.5, "night": 4.5, "sunlight": 7.0}
STOP, LINK = "stop-not-confirmed.weeder-07", "link-lost.weeder-07"

# what lies on top in the middle of each that is shown
TOPMOST = """(one) => { const box = one.getBoundingClientRect();
  const found = document.elementFromPoint(box.x + box.width / 2, box.y + box.height / 2);
  return Boolean(found) && (one.contains(found) || found.contains(one)) && box.bottom <= innerHeight; }"""

# contrast of what is off, as it is drawn: ink over every ground and opacity beneath it
FAINT = """() => {
  const linear = (v) => (v / 255 <= 0.03928 ? v / 255 / 12.92 : ((v / 255 + 0.055) / 1.055) ** 2.4);
  const light = ([r, g, b]) => 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
  const parse = (text) => { const p = text.match(/[\\d.]+/g).map(Number); return [p[0], p[1], p[2], p[3] ?? 1]; };
  const over = (top, low, share) => [0, 1, 2].map((i) => top[i] * share + low[i] * (1 - share));
  const chain = (one) => (one ? [...chain(one.parentElement), one] : []);
  const off = [...document.querySelectorAll(':is(button, input, select):is(:disabled, [aria-disabled=true])')];
  const isRead = (one) => one.offsetWidth > 1 && (one.textContent.trim() || one.value);
  return off.filter((one) => one.checkVisibility({ visibilityProperty: true }) && isRead(one)).map((one) => {
    let ground = [255, 255, 255];
    let share = 1;
    for (const node of chain(one)) {
      const style = getComputedStyle(node);
      const colour = parse(style.backgroundColor);
      share *= Number(style.opacity);
      ground = over(colour, ground, colour[3] * share);
    }
    const ink = over(parse(getComputedStyle(one).color), ground, share);
    const [high, low] = [light(ink), light(ground)].sort((a, b) => b - a);
    return [one.dataset.testid ?? one.textContent.trim(), (high + 0.05) / (low + 0.05)];
  });
}"""

# kept when every element has painted what it knows now: repainting is put together in one frame
PAINTED = """() => new Promise((done) => {
  HL.repaint(); requestAnimationFrame(() => requestAnimationFrame(() => requestAnimationFrame(done))); })"""


def dress(page: Page, theme: str) -> None:
    """Change the theme."""
    page.evaluate("(theme) => HL.preferences.set('theme', theme)", theme)


def played(page: Page, screen: str) -> None:
    """Answer for the missions, where a screen shows some."""
    if screen == "missions":
        Played(page, [mission("m-1", status="accepted"), mission("m-2")])
    if screen == "plan":
        PlayedPlans(page)
    page.get_by_test_id(f"nav-{'missions' if screen == 'plan' else screen}").click()
    expect(page.locator(f".h-screen[data-screen={'missions' if screen == 'plan' else screen}]")).to_be_visible()
    if screen == "plan":
        page.get_by_test_id("mission-plan").click()
        expect(page.get_by_test_id("plan-width")).to_be_visible()


@pytest.mark.parametrize(
    ("screen", "role"),
    [
        ("missions", "viewer"),
        ("plan", "supervisor"),
        ("sensors", "viewer"),
        ("maps", "planner"),
        ("supervisor", "operator"),
    ],
)
def test_what_is_off_can_be_read_in_every_theme(look: Look, theatre: Theatre, screen: str, role: str) -> None:
    theatre.play("running")
    theatre.sensors(anew=True)
    page = look(role=role, size="desk")
    played(page, screen)
    page.locator(":is(button, select):is(:disabled, [aria-disabled=true]):visible").first.wait_for()
    for theme in THEMES:
        dress(page, theme)
        page.wait_for_function("(theme) => document.documentElement.dataset.theme === theme", arg=theme)
        found = page.evaluate(FAINT)
        assert found, screen
        assert [one for one in found if one[1] < LEAST[theme]] == [], theme


@pytest.mark.parametrize("theme", THEMES)
def test_held_upright_every_action_is_in_reach_and_large_also_of_a_machine_with_many_values(
    look: Look, theatre: Theatre, theme: str
) -> None:
    theatre.play("running")
    theatre.machine(mode="auto")
    page = look("/operate/planter-09", size="portrait")
    dress(page, theme)
    expect(page.locator(".h-tile")).to_have_count(8)
    page.set_viewport_size({"width": 800, "height": 1180})
    expect(page.get_by_test_id("drive-open")).to_be_attached()
    for hook in page.locator(".h-actions > [data-testid]").all():
        assert hook.evaluate(TOPMOST), hook.get_attribute("data-testid")
        box = hook.bounding_box()
        assert box is not None
        assert min(box["width"], box["height"]) >= 76
    theatre.machine(off=True)


def test_held_upright_why_everything_is_off_is_in_sight(look: Look, theatre: Theatre) -> None:
    theatre.play("running")
    page = look(size="portrait")
    page.set_viewport_size({"width": 800, "height": 1000})
    theatre.play("silent")
    reason = page.get_by_text("Commands are off until the link is back.")
    expect(reason).to_be_visible(timeout=6000)
    assert reason.evaluate(TOPMOST)


@pytest.mark.parametrize("theme", ["day", "sunlight"])
def test_held_upright_the_buttons_of_a_low_map_can_be_pressed(look: Look, theatre: Theatre, theme: str) -> None:
    theatre.play("float")  # who has control is a long name
    theatre.alarms(put={LINK: {"title": "No data link", "priority": 2, "state": "unacknowledged"}})
    page = look(size="portrait")
    page.set_viewport_size({"width": 800, "height": 1000})
    dress(page, theme)
    expect(page.get_by_test_id("alarm-strip")).to_be_visible()
    expect(page.locator(".h-leaseline").first).to_be_visible()
    shown = page.locator(".hl-map-button:visible")
    expect(shown.first).to_be_visible()
    assert [one.get_attribute("data-testid") for one in shown.all() if not one.evaluate(TOPMOST)] == []


@pytest.mark.parametrize("theme", THEMES)
def test_without_a_link_no_value_is_cut_and_the_whole_state_is_told(look: Look, theatre: Theatre, theme: str) -> None:
    theatre.play("running")
    page = look()
    dress(page, theme)
    expect(page.locator(".h-path .leaf")).to_have_text("Laser firing")
    theatre.play("silent")
    expect(page.get_by_test_id("link-banner")).to_have_attribute("data-state", "robot-lost", timeout=6000)
    side = page.locator(".h-side").bounding_box()
    last = page.get_by_test_id("value-cross-track").bounding_box()
    assert side is not None
    assert last is not None
    assert last["y"] + last["height"] <= side["y"] + side["height"]
    assert "…" not in page.locator(".h-path").inner_text()


def test_the_alarms_that_nobody_answered_lie_on_no_tab_of_missions(look: Look, theatre: Theatre) -> None:
    theatre.play("running")
    many = {f"x{n}.weeder-07": {"priority": n % 4 + 1, "state": "unacknowledged", "escalated": 5} for n in range(48)}
    theatre.alarms(put=many)
    page = look("/missions", role="planner")
    dress(page, "sunlight")
    expect(page.get_by_test_id("alarm-unanswered")).to_be_visible()
    page.evaluate("HL.bell.state = () => 'blocked'")  # as before the first touch
    expect(page.locator("button.h-soundoff")).to_be_visible()
    expect(page.get_by_test_id("missions-tab-queue")).to_be_visible()
    assert page.get_by_test_id("alarm-unanswered").evaluate(TOPMOST)
    tab, chip = (page.get_by_test_id(one).bounding_box() for one in ("missions-tab-queue", "alarm-unanswered"))
    assert tab is not None
    assert chip is not None
    assert tab["x"] + tab["width"] <= chip["x"]


def test_the_strip_leaves_an_unconfirmed_stop_to_the_banner_and_keeps_other_alarms(
    look: Look, theatre: Theatre
) -> None:
    theatre.play("running")
    stop = {"title": "Stop is not confirmed", "priority": 1, "state": "unacknowledged"}
    link = {"title": "No data link", "priority": 2, "state": "unacknowledged"}
    theatre.alarms(put={STOP: stop, LINK: link})
    page = look()
    strip = page.get_by_test_id("alarm-strip")
    expect(strip).to_have_attribute("data-value", STOP)  # no banner speaks of it
    banner = {"state": "not-confirmed", "level": "p1", "height": 112, "icon": "pan_tool", "title": "t", "text": "x"}
    page.evaluate(f"window.headlandStop.banner = () => ({json.dumps({**banner, 'robots': ['weeder-01']})})")
    page.evaluate(PAINTED)
    expect(strip).to_have_attribute("data-value", STOP)  # it speaks of another robot
    page.evaluate(f"window.headlandStop.banner = () => ({json.dumps({**banner, 'robots': ['weeder-07']})})")
    expect(strip).to_have_attribute("data-value", LINK)
    expect(strip).to_be_visible()


def test_a_mission_under_way_looks_the_same_in_list_and_head_and_offers_no_sending(
    look: Look, theatre: Theatre
) -> None:
    theatre.play("running")
    page = look("/operate", role="supervisor")
    Played(page, [mission("m-1", status="paused"), mission("m-2", status="validated")])
    page.get_by_test_id("nav-missions").click()
    row, head = page.get_by_test_id("mission-row-m-1"), page.get_by_test_id("mission-status")
    expect(head).to_have_text("Paused")
    assert row.locator(".h-chip").get_attribute("class") == head.get_attribute("class") == "h-chip line"
    expect(row).to_contain_text("changed Wed 20 May")
    expect(page.locator(".h-mdetail")).not_to_contain_text("Sending does not move the robot.")
    page.get_by_test_id("mission-row-m-2").click()
    expect(page.locator(".h-mdetail")).to_contain_text("Sending does not move the robot.")


FITS = """(one) => { const pen = document.createElement('canvas').getContext('2d'); const style = getComputedStyle(one);
  pen.font = style.font; const room = one.clientWidth - parseFloat(style.paddingLeft) - parseFloat(style.paddingRight);
  return pen.measureText(one.selectedOptions[0].textContent).width + 20 <= room; }"""


def test_planning_says_why_nothing_can_be_sent_and_back_leads_back(look: Look, theatre: Theatre) -> None:
    theatre.play("running")
    page = look("/operate", role="supervisor")
    played(page, "plan")
    dress(page, "sunlight")
    expect(page.get_by_test_id("plan-send")).to_be_disabled()
    expect(page.get_by_test_id("plan-hint")).to_be_visible()
    expect(page.get_by_test_id("plan-hint")).to_have_text("Preview first.")
    assert page.get_by_test_id("plan-hint").evaluate(TOPMOST)
    home = page.locator("select[name=home_id]")
    assert home.evaluate(FITS), home.evaluate("(one) => one.selectedOptions[0].textContent")
    page.get_by_test_id("plan-preview").click()
    expect(page.get_by_test_id("plan-send")).to_be_enabled()
    expect(page.locator(".p-dock").get_by_test_id("plan-back")).to_contain_text("Treatment")
    page.reload()
    played(page, "plan")
    page.locator(".p-dock").get_by_test_id("plan-back").get_by_text("Missions").click()
    expect(page.get_by_test_id("mission-row-m-1")).to_be_visible()


def test_held_upright_the_hint_of_the_plan_and_of_sign_in_are_whole(look: Look, theatre: Theatre) -> None:
    theatre.play("running")
    page = look("/operate", role="supervisor", size="portrait")
    played(page, "plan")
    box = page.get_by_test_id("plan-hint").bounding_box()
    assert box is not None
    assert box["x"] >= 0
    assert box["x"] + box["width"] <= 800
    assert box["height"] < 30
    page = look("/login", role="", size="portrait")
    hint = page.get_by_text("STOP works before sign-in on enrolled tablets.")
    expect(hint).to_be_visible()
    assert hint.evaluate(TOPMOST)
    slab, box = page.get_by_test_id("stop").bounding_box(), hint.bounding_box()
    assert slab is not None
    assert box is not None
    assert box["x"] + box["width"] <= slab["x"]


@pytest.mark.parametrize("size", ["landscape", "portrait"])
def test_names_in_the_queue_are_whole_where_the_row_is_free_and_now_touches_none(
    look: Look, theatre: Theatre, size: str
) -> None:
    theatre.play("running")
    page = look("/operate", size=size)
    long = robot("weeder-01", "Weeder 01", now={"name": "Elzenbos", "from_utc": utc(-10), "to_utc": utc(600)})
    name = "Zuidkamp, along the ditch"
    queue = whole(robots=[robot("weeder-07", "Weeder 07"), long], entries=[entry("a", name, duration_s=5400)])
    queue["entries"].append(entry("l", "Wheat", robot_id="weeder-01", duration_s=36000))
    PlayedQueue(page, queue)
    page.get_by_test_id("nav-missions").click()
    page.get_by_test_id("missions-tab-queue").click()
    page.get_by_test_id("queue-look-timeline").click()
    label = page.get_by_test_id("queue-bar-a").locator(".h-ell")
    expect(label).to_be_visible()
    page.wait_for_function("(one) => one.scrollWidth <= one.clientWidth", arg=label.element_handle())
    gaps = page.evaluate(
        """[...document.querySelectorAll('.q-robot')].map((row) => {
          const now = row.querySelector('.q-now').getBoundingClientRect();
          return [...row.querySelectorAll('.q-name *')].every((one) => { const box = one.getBoundingClientRect();
            return box.bottom <= now.top || box.right <= now.left || box.left >= now.right; }); })"""
    )
    assert all(gaps)


AUDIT = {"seq": 47, "utc": "2026-11-23T06:33:11+00:00", "actor": "Jonas Weber", "device": "", "kind": "sign_in",
         "robot_id": "weeder-07", "outcome": "accepted", "text": ""}  # fmt: skip
COUNTS = {"health": {"parts": {"broker": {"down_since_utc": None}}}, "ingest": {"refused_by_robot": {"weeder-07": 3}}}


def test_records_name_robots_and_acts_as_people_do(look: Look, theatre: Theatre) -> None:
    theatre.play("running")
    page = look("/fleet", role="admin", size="portrait")

    def answer(body: dict[str, Any]) -> Callable[..., None]:
        return lambda route: route.fulfill(status=200, content_type="application/json", body=json.dumps(body))

    page.route("**/api/v1/audit**", answer({"entries": [AUDIT]}))
    page.route("**/api/v1/diagnostics", answer(COUNTS))
    page.goto("/admin")
    page.get_by_test_id("admin-tab-audit").click()
    row = page.get_by_test_id("audit-row-47")
    expect(row).to_contain_text("Sign in")
    expect(row).to_contain_text("Weeder 07")
    assert row.locator("td").first.inner_text().startswith("23 Nov 2026")  # the head of its card
    page.get_by_test_id("admin-tab-diagnostics").click()
    expect(page.get_by_text("Parts, broker, down since (UTC)")).to_be_visible()
    expect(page.get_by_text("Refused by robot, Weeder 07")).to_be_visible()


def test_figures_of_alarms_say_the_same_in_both_places_and_missing_ones_are_dashes(
    look: Look, theatre: Theatre
) -> None:
    theatre.play("running")
    theatre.alarms(put={LINK: {"title": "No data link", "priority": 2, "state": "returned", "escalated": 5}})
    page = look("/alarms")
    told = page.locator(".al-row .state .told")
    expect(told).to_have_text("Returned, nobody answered")
    for theme in THEMES:
        dress(page, theme)
        assert told.evaluate("(one) => one.scrollWidth <= one.clientWidth && one.scrollHeight <= one.clientHeight + 1")
    page.get_by_test_id("alarms-tab-shelved").click()
    expect(page.get_by_test_id("alarm-blank")).to_contain_text("Nothing is shelved.")
    expect(page.get_by_test_id("alarm-blank")).not_to_contain_text("Last one")
    mixed = page.evaluate("HL.alarmMix({1: 0.0, 2: 0.22, 3: 0.78})")
    assert mixed == "22/78/0"
    assert page.evaluate("HL.alarmMix({})") is None
    page.get_by_test_id("alarms-tab-statistics").click()
    shown = page.get_by_test_id("alarm-kpi-mix").inner_text()
    expect(page.get_by_test_id("alarm-statistics")).to_contain_text(f"Priority mix, 7 days{shown}")
    assert page.evaluate("HL.alarmWords.clock(null)") == "––"


STATION = {"robot": "field", "camera": "multispec-01", "label": "Multispectral 1", "state": "frozen"}
PICTURE = {"id": "p-9", "kind": "snapshot", "robot": "field", "robot_name": "Field", "camera": "multispec-01",
           "captured_utc": "2026-11-23T06:33:11+00:00", "file": "/api/v1/pictures/p-9/file"}  # fmt: skip


def test_a_picture_of_a_station_bears_its_name(look: Look, theatre: Theatre) -> None:
    theatre.play("running")
    theatre.cameras(anew=True)
    page = look("/cameras")
    expect(page.get_by_test_id("camera-weeder-07-front")).to_be_visible()
    page.evaluate(f"HL.camera.wall.cameras.push({json.dumps(STATION)})")
    page.route(
        "**/api/v1/pictures?*",
        lambda route: route.fulfill(content_type="application/json", body=json.dumps({"pictures": [PICTURE]})),
    )
    page.get_by_test_id("cameras-pictures").click()
    expect(page.get_by_test_id("picture-p-9").locator("b")).to_have_text("Multispectral 1")


def test_a_camera_that_takes_no_orders_says_why_beside_its_buttons(look: Look, theatre: Theatre) -> None:
    theatre.cameras(anew=True)
    theatre.cameras(cameras={"weeder-07/front": {"has_trigger": True}})
    theatre.play("float")  # another person has control
    page = look("/operate/weeder-07")
    page.get_by_test_id("view-camera").click()
    expect(page.get_by_test_id("camera-trigger")).to_have_attribute("aria-disabled", "true")
    expect(page.locator(".c-line")).to_contain_text("Take control of the robot first.")
    theatre.play("running")
    expect(page.get_by_test_id("camera-trigger")).not_to_have_attribute("aria-disabled", "true")
    expect(page.locator(".c-line")).not_to_contain_text("Take control")
