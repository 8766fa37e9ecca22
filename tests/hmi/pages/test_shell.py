"""The frame around all screens: one page, one STOP, one lane; sign-in; keys; themes; drafts."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from playwright.sync_api import Page, Route, expect

from tests.hmi.pages.conftest import SIZES, Theatre

pytestmark = pytest.mark.browser
Look = Callable[..., Page]


def test_screens_change_without_a_new_page_or_a_new_lane(look: Look, theatre: Theatre) -> None:
    theatre.play("running")
    page = look(role="admin")
    expect(page.get_by_test_id("value-speed")).to_have_attribute("data-state", "fresh")
    page.evaluate("window.mark = 1; document.getElementById('headland-stop').mark = 1")
    sockets: list[str] = []
    page.on("websocket", lambda socket: sockets.append(socket.url))
    for name in ("fleet", "admin", "operate"):
        page.get_by_test_id(f"nav-{name}").click()
        expect(page.get_by_test_id(f"nav-{name}")).to_have_attribute("aria-current", "page")
        expect(page.get_by_test_id("stop")).to_be_visible()
    expect(page.get_by_test_id("value-speed")).to_have_attribute("data-state", "fresh")
    assert page.evaluate("window.mark === 1 && document.getElementById('headland-stop').mark === 1")
    assert [url for url in sockets if "/live" in url] == []


def test_only_screens_that_a_role_may_open_are_in_the_rail(look: Look, theatre: Theatre) -> None:
    theatre.play("running")
    page = look(role="operator")
    expect(page.get_by_test_id("nav-missions")).to_be_visible()
    expect(page.get_by_test_id("nav-admin")).to_have_count(0)
    page.goto("/admin")
    expect(page.get_by_test_id("notice")).to_contain_text("Admins only")
    page.goto("/nowhere/at-all")
    expect(page.get_by_test_id("notice")).to_contain_text("There is no such screen")
    expect(page.get_by_test_id("stop")).to_be_visible()


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize(
    "theme", ["day", pytest.param("night", marks=pytest.mark.long), pytest.param("sunlight", marks=pytest.mark.long)]
)
def test_stop_is_on_top_in_every_size_and_theme(look: Look, theatre: Theatre, size: str, theme: str) -> None:
    theatre.play("running")
    page = look("/fleet", size=size)
    page.evaluate(f"HL.preferences.set('theme', '{theme}')")
    page.keyboard.press("?")
    expect(page.get_by_test_id("keys-list")).to_be_visible()
    assert is_stop_on_top(page)


LONG = """HL.sheet({title: 'A long one', buttons: [['Leave it', (close) => close()]],
    body: [...Array(200).keys()].map((n) => Object.assign(document.createElement('p'), {textContent: `line ${n}`}))})"""
OPENERS: dict[str, Callable[[Page], object]] = {
    "robot menu": lambda page: page.get_by_test_id("robot-switch").click(),
    "user menu": lambda page: page.get_by_test_id("user-menu").click(),
    "layers of the map": lambda page: page.get_by_test_id("map-layers").click(),
    "take control": lambda page: page.get_by_test_id("lease-take").click(),
    "enrol": lambda page: (page.get_by_test_id("user-menu").click(), page.get_by_test_id("enrol").click()),
    "abort slide": lambda page: page.get_by_test_id("mission-abort").click(),
    "a sheet longer than the screen": lambda page: page.evaluate(LONG),
    "toasts": lambda page: page.evaluate("for (let n = 0; n < 5; n += 1) HL.toast('Something happened '.repeat(12))"),
}


@pytest.mark.parametrize("size", ["landscape", pytest.param("portrait", marks=pytest.mark.long)])
def test_stop_is_on_top_of_everything_that_opens(look: Look, theatre: Theatre, size: str) -> None:
    theatre.play("paused", owner="supervisor")
    page = look(role="admin", size=size)
    covered = []
    for name, open_it in OPENERS.items():
        page.goto("/operate/weeder-07")
        expect(page.get_by_test_id("value-speed")).to_have_attribute("data-state", "fresh")
        before = page.locator("body").inner_text()
        open_it(page)
        page.wait_for_function("(before) => document.body.innerText !== before", arg=before)
        if not is_stop_on_top(page):
            covered.append(name)
    assert covered == []


def is_stop_on_top(page: Page) -> bool:
    """Say whether the slab is what a finger meets at five points of it."""
    box = page.get_by_test_id("stop").bounding_box()
    assert box is not None
    points = [(0.02, 0.03), (0.98, 0.03), (0.5, 0.5), (0.02, 0.97), (0.98, 0.97)]
    places = [[box["x"] + box["width"] * x, box["y"] + box["height"] * y] for x, y in points]
    is_slab = "([x, y]) => Boolean(document.elementFromPoint(x, y)?.closest('#headland-stop'))"
    return all(page.evaluate(is_slab, place) for place in places)


def test_in_portrait_more_holds_the_screens_that_do_not_fit_and_stop_stays_free(look: Look, theatre: Theatre) -> None:
    theatre.play("running")
    page = look("/fleet", role="admin", size="portrait")
    expect(page.get_by_test_id("nav-alarms")).to_be_visible()
    expect(page.get_by_test_id("nav-admin")).to_be_hidden()
    page.get_by_test_id("nav-more").click()
    box, slab = page.get_by_test_id("nav-admin").bounding_box(), page.get_by_test_id("stop").bounding_box()
    assert box
    assert slab
    assert min(box["width"], box["height"]) >= 56
    assert box["x"] + box["width"] <= slab["x"]
    assert is_stop_on_top(page)
    page.get_by_test_id("nav-admin").click()
    expect(page.get_by_test_id("robot-form")).to_be_visible()
    expect(page.get_by_test_id("nav-admin")).to_be_hidden()
    expect(page.get_by_test_id("nav-more")).to_have_attribute("aria-current", "page")


@pytest.mark.long
def test_a_section_pressed_before_its_script_came_is_the_one_that_opens(look: Look, theatre: Theatre) -> None:
    theatre.play("running")
    page = look("/fleet", role="admin")
    held: list[Route] = []
    page.route("**/static/bundle/admin.js*", lambda route: held.append(route))
    page.get_by_test_id("nav-admin").click()
    page.get_by_test_id("admin-tab-limits").click()
    expect(page.get_by_test_id("admin-tab-limits")).to_have_attribute("aria-pressed", "true")
    assert held
    held[0].continue_()
    expect(page.locator("hl-admin .h-sec > *").first).to_be_visible()
    expect(page.get_by_test_id("admin-tab-limits")).to_have_attribute("aria-pressed", "true")


def test_keys_move_between_screens_but_not_while_typing(look: Look, theatre: Theatre) -> None:
    theatre.play("running")
    page = look("/fleet", role="admin")
    expect(page.get_by_test_id("fleet-row-weeder-07")).to_be_visible()
    page.keyboard.press("g")
    page.keyboard.press("i")
    expect(page.locator("[data-screen=missions]").first).to_be_visible()
    page.get_by_test_id("nav-admin").first.click()
    expect(page.get_by_test_id("robot-form")).to_be_visible()
    page.locator("input[name=name]").fill("g")
    page.keyboard.type("f")
    expect(page.get_by_test_id("robot-form")).to_be_visible()


def test_the_theme_changes_by_its_button_and_stays(look: Look, theatre: Theatre) -> None:
    page = look("/fleet")
    expect(page.locator("html")).to_have_attribute("data-theme", "day")
    page.get_by_test_id("theme").click()
    expect(page.locator("html")).to_have_attribute("data-theme", "night")
    page.reload()
    expect(page.locator("html")).to_have_attribute("data-theme", "night")


def test_sign_in_says_what_was_wrong_and_then_opens_the_console(look: Look, theatre: Theatre) -> None:
    theatre.play("running")
    page = look("/operate/weeder-07", role="")
    page.get_by_test_id("login-name").fill("operator")
    page.get_by_test_id("login-password").fill("wrong")
    page.get_by_test_id("login-submit").click()
    expect(page.get_by_test_id("login-error")).to_have_text("Wrong name or password.")
    expect(page.get_by_test_id("stop-all").first).to_be_visible()
    page.get_by_test_id("login-password").fill("operator")
    page.get_by_test_id("login-submit").click()
    expect(page.get_by_test_id("robot-mode")).to_have_attribute("data-state", "auto")
    assert page.evaluate("localStorage.getItem('headland.stop_token')") == "token"


def test_an_enrolled_tablet_asks_for_a_pin(look: Look, theatre: Theatre) -> None:
    page = look("/fleet", role="")
    page.evaluate("localStorage.setItem('headland.stop_token', 'token')")
    page.reload()
    expect(page.get_by_text("Who is working?")).to_be_visible()
    for digit in "1112":
        page.get_by_test_id(f"pin-{digit}").click()
    expect(page.get_by_test_id("login-error")).to_have_text("Wrong name or password.")
    for digit in "1111":
        page.get_by_test_id(f"pin-{digit}").click()
    expect(page.get_by_test_id("nav-fleet")).to_be_visible()


@pytest.mark.long
def test_a_name_typed_at_sign_in_survives_a_reload(look: Look, theatre: Theatre) -> None:
    page = look("/fleet", role="")
    page.get_by_test_id("login-name").fill("oper")
    page.reload()
    expect(page.get_by_test_id("login-name")).to_have_value("oper")
    assert page.get_by_test_id("login-password").input_value() == ""


@pytest.mark.long
def test_a_robot_nobody_heard_of_gets_a_way_back(look: Look, theatre: Theatre) -> None:
    page = look("/operate/nobody")
    expect(page.get_by_test_id("notice")).to_contain_text("No robot nobody")
    page.get_by_role("link", name="Choose a robot").click()
    expect(page.get_by_test_id("robot-option-weeder-07").first).to_be_attached()


def test_the_fleet_lists_every_robot_with_what_is_known(look: Look, theatre: Theatre) -> None:
    theatre.play("running")
    page = look("/fleet")
    expect(page.get_by_test_id("fleet-row-weeder-07")).to_contain_text("Rain in 35 min")
    expect(page.get_by_test_id("fleet-row-weeder-07")).to_contain_text("68 %")
    expect(page.get_by_test_id("fleet-row-weeder-01")).to_contain_text("Never heard")
    expect(page.get_by_test_id("fleet-group-needs-you")).to_contain_text("2")


def test_admin_accepts_a_new_robot_with_an_address_from_the_registry(look: Look, theatre: Theatre) -> None:
    theatre.play("running")
    page = look("/admin", role="admin")
    page.get_by_test_id("robot-accept-planter-09").click()
    expect(page.locator("input[name=id]")).to_have_value("planter-09")
    page.locator("input[name=http_url]").fill("http://10.0.0.19:8090")
    page.get_by_role("button", name="Add robot").click()
    expect(page.locator("input[name=id]")).to_have_value("")
    [order] = [order for order in theatre.until_orders("robots") if order["method"] == "POST"]
    assert (order["id"], order["http_url"]) == ("planter-09", "http://10.0.0.19:8090")


@pytest.mark.long
def test_every_admin_section_opens(look: Look, theatre: Theatre) -> None:
    page = look("/admin", role="admin")
    for name, text in {
        "people": "Martha Keller",
        "tablets": "No tablet is enrolled",
        "audit": "pause",
        "diagnostics": "malformed",
    }.items():
        page.get_by_test_id(f"admin-tab-{name}").click()
        expect(page.get_by_text(text).first).to_be_visible()


def test_the_lost_server_is_said_and_no_press_acts_later(look: Look, theatre: Theatre) -> None:
    theatre.play("running")
    page = look(is_new=True)
    expect(page.get_by_test_id("value-speed")).to_have_attribute("data-state", "fresh")
    page.wait_for_load_state("networkidle")  # the map fetches its parts late
    page.context.set_offline(True)
    page.evaluate("window.socket.disconnect()")
    page.get_by_test_id("nav-fleet").click()
    expect(page.get_by_test_id("toast")).to_contain_text("Not sent")
    expect(page.get_by_test_id("value-speed")).to_be_visible()


@pytest.mark.long
def test_a_page_whose_script_was_lost_says_so_and_comes_by_itself(look: Look) -> None:
    page = look(may_break=True)
    page.route("**/nicegui.js", lambda route: route.abort())
    page.reload()
    notice = page.locator("#h-unloaded")
    expect(notice).to_contain_text("This screen did not load completely. STOP has a way of its own")
    expect(page.get_by_test_id("stop")).to_be_visible()
    notice.get_by_role("button", name="Load again now").click()
    page.wait_for_function("sessionStorage.getItem('headland.load_tries') === '1'")
    expect(notice).to_contain_text("Loading again in")
    page.unroute("**/nicegui.js")
    expect(page.get_by_test_id("value-speed")).to_be_visible()  # after five seconds, by itself
    expect(notice).to_have_count(0)
