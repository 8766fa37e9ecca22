"""The STOP slab alone in a real browser: static page, real gateway, real broker, robots on the wire."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import Locator, Page, expect

from components.stop_slab import StopConfig, head_html
from tests.components.stop_page import RobotThread, StopPage
from tests.hmi.stop_gateway.broker import MOSQUITTO, Broker
from tests.hmi.stop_gateway.fake_robot import FakeRobot
from tests.hmi.stop_gateway.running import TOKEN, RunningGateway

pytestmark = [pytest.mark.browser, pytest.mark.broker]
SIZES = {"landscape": (1280, 800, 300, 96), "portrait": (800, 1280, 296, 108), "desk": (1920, 1080, 320, 88)}


class Farm:
    """Broker, gateway, three robots and the page's server."""

    def __init__(self, folder: Path) -> None:
        self.broker = Broker(folder)
        self.broker.start()
        self.robots_home = RobotThread(self.broker.url)
        self.page = StopPage()
        self.gateway = RunningGateway(folder / "data", self.broker.url, self.page.port)
        self.robots = [self.robots_home.make(name) for name in ("weeder-07", "weeder-08", "planter-01")]
        self.gateway.register(*self.robots, decel_mps2=0.25)  # 2.6 s to stand, also on a busy machine
        self.gateway.start()

    @property
    def weeder(self) -> FakeRobot:
        return self.robots[0]

    def calm(self) -> None:
        """Everything runs, nothing is stopped."""
        self.page.second_path = None
        self.page.second_path_presses.clear()
        if not self.gateway.is_running:
            self.gateway.start()
        for robot in self.robots:
            robot.is_silent = robot.is_deaf = robot.is_runaway = robot.is_mute = robot.is_http_mute = False
            for stop_id in list(robot.presses):
                robot.reset(stop_id)
            robot.speed_mps, robot.ack_after_s = (
                0.4,
                0.0,
            )  # after the reset: who moves while stopped stays NOT CONFIRMED
            robot.stops_by_mqtt.clear()
            robot.stops_by_http.clear()

    def config(self, *, is_all: bool = False) -> StopConfig:
        return StopConfig(
            port=urlsplit(self.gateway.url).port or 0, robot=None if is_all else ("weeder-07", "Weeder 07")
        )

    def close(self) -> None:
        self.gateway.close()
        self.robots_home.close()
        self.page.close()
        self.broker.kill()


@pytest.fixture(scope="module")
def whole_farm(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Farm]:
    """One farm for this file."""
    if MOSQUITTO is None:
        pytest.skip("mosquitto is not installed")
    farm = Farm(tmp_path_factory.mktemp("farm"))
    yield farm
    farm.close()


@pytest.fixture
def farm(whole_farm: Farm) -> Farm:
    """The farm, calm."""
    whole_farm.calm()
    return whole_farm


def come(page: Page, farm: Farm, *, is_all: bool = False, token: str = TOKEN) -> Locator:
    """Open the page as an enrolled tablet; return the slab."""
    farm.page.config = farm.config(is_all=is_all)
    page.add_init_script(f"if ({json.dumps(token)}) localStorage.setItem('headland.stop_token', {json.dumps(token)})")
    page.goto(farm.page.url)
    return page.get_by_test_id("stop")


def sees(slab: Locator, state: str, *, timeout_s: float = 15) -> None:
    expect(slab).to_have_attribute("data-state", state, timeout=timeout_s * 1000)


def touch(slab: Locator) -> None:
    """Put a finger down and leave it there: STOP acts on the way down."""
    slab.dispatch_event("pointerdown")


def state(page: Page) -> dict[str, Any]:
    seen: dict[str, Any] = page.evaluate("headlandStop.state()")
    return seen


def record_states(page: Page) -> None:
    page.evaluate(
        "window.seen = []; addEventListener('headland:stop', (e) => seen.at(-1) !== e.detail.state"
        " && seen.push(e.detail.state))"
    )


def test_a_press_is_shown_from_sent_to_stopped_and_never_ahead_of_the_robot(page: Page, farm: Farm) -> None:
    slab = come(page, farm)
    sees(slab, "ready")
    expect(slab).to_contain_text("Weeder 07")
    expect(slab).to_contain_text(re.compile(r"READY · link \d+ ms"))
    record_states(page)
    slab.evaluate(
        "slab => { window.words = []; new MutationObserver(() => words.push(slab.textContent))"
        ".observe(slab, { subtree: true, childList: true, characterData: true }) }"
    )
    farm.weeder.ack_after_s = 0.4
    touch(slab)
    sees(slab, "standstill")
    assert any("waiting for robot" in said for said in page.evaluate("words"))
    assert page.evaluate("seen") == ["sent", "acknowledged", "standstill"]
    expect(slab).to_contain_text("STOPPED")
    expect(slab).to_contain_text("Standstill confirmed")
    expect(slab).to_contain_text(re.compile(r"latched 0:0\d"))
    assert farm.weeder.speed_mps == 0


def test_the_card_tells_who_and_when_and_the_banner_what_to_do(page: Page, farm: Farm) -> None:
    slab = come(page, farm)
    page.evaluate("headlandStop.renderSteps(document.getElementById('card'))")
    card = page.get_by_test_id("stop-steps")
    expect(card).to_be_hidden()
    sees(slab, "ready")
    farm.weeder.is_runaway = True
    touch(slab)
    sees(slab, "not-confirmed")
    expect(card).to_contain_text("Standstill unknown")
    banner = page.evaluate("headlandStop.banner()")
    assert banner["title"] == "Use the red button on the machine"
    assert banner["text"] == "Stop not confirmed. Weeder 07 may still be moving. Keep everyone 15 m away."
    assert banner["contact"] == {"name": "Jonas Weber", "phone": "0123"}
    farm.weeder.is_runaway = False
    sees(slab, "standstill")  # a late confirmation still counts
    expect(card).to_contain_text("Martha Keller, Tablet 3")
    expect(card).to_contain_text("STANDSTILL CONFIRMED")
    expect(card).to_contain_text("Stopping distance 0.31 m")
    sent, acked, stood = (float(card.get_attribute(f"data-{k}-ms") or "nan") for k in ("sent", "ack", "standstill"))
    assert 0 <= sent <= acked <= stood
    assert page.evaluate("headlandStop.banner()")["text"].startswith("Pressed by Martha Keller on Tablet 3.")


def test_a_page_that_opens_later_shows_the_latched_robot_and_who_pressed(page: Page, farm: Farm) -> None:
    slab = come(page, farm)
    sees(slab, "ready")
    touch(slab)
    sees(slab, "standstill")
    page.reload()
    sees(page.get_by_test_id("stop"), "standstill")
    steps = state(page)["steps"]
    assert [step["by"] for step in steps] == ["Martha Keller"]
    for stop_id in list(farm.weeder.presses):
        farm.weeder.reset(stop_id)
    sees(page.get_by_test_id("stop"), "ready")


def test_without_the_gateway_the_browser_itself_says_no_path_and_not_confirmed(page: Page, farm: Farm) -> None:
    slab = come(page, farm)
    sees(slab, "ready")
    farm.gateway.kill()
    sees(slab, "no-path")
    expect(slab).to_contain_text("NO PATH")
    expect(slab).to_contain_text("use the machine button")
    touch(slab)
    sees(slab, "not-confirmed")
    expect(slab).to_contain_text("press again, or use machine")
    page.reload()
    sees(page.get_by_test_id("stop"), "not-confirmed")  # a reload forgets nothing
    farm.gateway.start()
    sees(page.get_by_test_id("stop"), "standstill")  # its own retries reached the gateway
    assert farm.weeder.speed_mps == 0


def test_what_waits_for_stop_does_not_wait_for_ever_without_a_gateway(page: Page, farm: Farm) -> None:
    farm.gateway.kill()
    slab = come(page, farm)
    sees(slab, "no-path")
    assert page.evaluate("headlandStop.whenReady(300).then(() => headlandStop.state().state)") == "no-path"
    farm.gateway.start()
    sees(slab, "ready")


def test_a_gateway_that_dies_after_the_press_leaves_not_confirmed_by_the_browsers_own_clock(
    page: Page, farm: Farm
) -> None:
    slab = come(page, farm)
    sees(slab, "ready")
    farm.weeder.is_runaway = True
    touch(slab)
    sees(slab, "acknowledged")
    farm.gateway.kill()
    sees(slab, "not-confirmed")


def test_the_consoles_second_path_is_used_with_the_token_when_the_gateway_is_dead(page: Page, farm: Farm) -> None:
    step = {
        "k": "step", "robot": "weeder-07", "name": "Weeder 07", "state": "standstill", "by": "Martha", "device": "",
        "pressed_utc": "2026-05-04T14:36:40.900Z", "age_ms": 900, "sent_ms": 1, "ack_ms": 20,
        "standstill_ms": 800, "count": 3, "paths": {"mqtt": 3, "http": 0}, "speed_mps": 0.0,
        "stopping_distance_m": 0.2, "text": "",
    }  # fmt: skip
    slab = come(page, farm)
    sees(slab, "ready")
    farm.page.second_path = [step]
    farm.gateway.kill()
    sees(slab, "no-path")
    touch(slab)
    sees(slab, "standstill")
    assert farm.page.second_path_presses[0]["robots"] == ["weeder-07"]
    assert farm.page.second_path_presses[0]["authorization"] == f"Bearer {TOKEN}"


def test_a_silent_robot_is_no_link_and_stop_is_sent_anyway(page: Page, farm: Farm) -> None:
    slab = come(page, farm)
    sees(slab, "ready")
    farm.weeder.is_silent = True
    sees(slab, "no-link")
    expect(slab).to_contain_text(re.compile(r"NO LINK \d+ s · sends anyway"))
    record_states(page)
    touch(slab)
    sees(slab, "not-confirmed")
    assert page.evaluate("seen") == ["sent", "not-confirmed"]
    farm.weeder.is_silent = False
    sees(slab, "standstill")


def test_stop_all_counts_honestly_and_names_what_is_not_confirmed(page: Page, farm: Farm) -> None:
    slab = come(page, farm, is_all=True)
    sees(slab, "ready")
    expect(slab).to_contain_text("STOP ALL")
    expect(slab).to_contain_text("All 3 robots")
    everybody = page.locator('[data-testid="stop-all"]:visible')
    expect(everybody).to_have_attribute("data-total", "3")
    expect(everybody).to_have_attribute("data-standing", "0")
    farm.robots[2].is_silent = True
    touch(everybody)
    sees(slab, "not-confirmed")
    expect(everybody).to_have_attribute("data-standing", "2")
    expect(slab).to_contain_text("2 of 3 standing,")
    expect(slab).to_contain_text("1 NOT CONFIRMED")
    expect(everybody).to_have_attribute("data-failing", "Planter 01")
    farm.robots[2].is_silent = False
    sees(slab, "standstill")
    expect(everybody).to_have_attribute("data-standing", "3")


def test_a_robot_that_went_offline_after_it_stopped_is_not_counted(page: Page, farm: Farm) -> None:
    slab = come(page, farm, is_all=True)
    sees(slab, "ready")
    touch(slab)
    everybody = page.locator('[data-testid="stop-all"]:visible')
    expect(everybody).to_have_attribute("data-standing", "3", timeout=8000)
    farm.robots[1].is_silent = True
    expect(everybody).to_have_attribute("data-standing", "2", timeout=8000)
    assert slab.get_attribute("data-state") != "standstill"


def test_beside_one_robots_slab_the_segment_stops_all(page: Page, farm: Farm) -> None:
    slab = come(page, farm)
    sees(slab, "ready")
    segment = page.get_by_test_id("stop-all")
    expect(segment).to_have_text("All 3robots")
    touch(segment)
    sees(segment, "standstill")
    assert all(robot.is_latched for robot in farm.robots)
    page.evaluate("headlandStop.setScope({kind: 'all'})")
    expect(page.locator(".hl-stop-all")).to_be_hidden()


@pytest.mark.parametrize("key", ["Pause", "Control+."])
def test_the_keys_stop_from_anywhere_even_while_somebody_types(page: Page, farm: Farm, key: str) -> None:
    slab = come(page, farm)
    sees(slab, "ready")
    page.evaluate("document.body.insertAdjacentHTML('beforeend', '<input id=name>')")
    page.locator("#name").focus()
    page.keyboard.press(key)
    sees(slab, "standstill")


@pytest.mark.parametrize("key", ["Enter", "Space"])
def test_stop_is_first_in_the_tab_order_and_acts_on_key_down(page: Page, farm: Farm, key: str) -> None:
    slab = come(page, farm)
    sees(slab, "ready")
    page.evaluate("document.body.insertAdjacentHTML('afterbegin', '<button>first in the page</button>')")
    page.keyboard.press("Tab")
    expect(slab).to_be_focused()
    page.keyboard.down(key)
    sees(slab, "standstill")
    page.keyboard.up(key)
    assert len(farm.weeder.presses) == 1


def test_a_click_without_a_finger_counts_too_and_a_finger_with_its_click_counts_once(page: Page, farm: Farm) -> None:
    slab = come(page, farm)
    sees(slab, "ready")
    slab.click()
    sees(slab, "standstill")
    assert len(farm.weeder.presses) == 1
    farm.calm()
    sees(slab, "ready")
    page.wait_for_timeout(1100)  # longer than a click may follow its own finger
    slab.dispatch_event("click")  # as switch control and screen readers do
    sees(slab, "standstill")


def test_pressing_again_always_sends_again(page: Page, farm: Farm) -> None:
    slab = come(page, farm)
    sees(slab, "ready")
    touch(slab)
    sees(slab, "standstill")
    first = set(farm.weeder.presses)
    page.wait_for_timeout(2100)  # a press older than this may have been reset: it needs a name of its own
    touch(slab)
    page.wait_for_function("headlandStop.state().steps.length === 2 && headlandStop.state().state === 'standstill'")
    assert set(farm.weeder.presses) > first


@pytest.mark.parametrize("size", SIZES)
def test_the_slab_has_its_size_and_nothing_covers_it(page: Page, farm: Farm, size: str) -> None:
    width, height, slab_width, slab_height = SIZES[size]
    page.set_viewport_size({"width": width, "height": height})
    slab = come(page, farm)
    page.evaluate(f"document.documentElement.dataset.density = {json.dumps('desk' if size == 'desk' else 'glove')}")
    sees(slab, "ready")
    cover = '<div style="position:fixed;inset:0;z-index:9600">cover</div>'
    page.evaluate(f"document.body.insertAdjacentHTML('beforeend', {json.dumps(cover)})")
    box = slab.bounding_box()
    assert box == {"x": width - slab_width, "y": height - slab_height, "width": slab_width, "height": slab_height}
    segment = page.get_by_test_id("stop-all").bounding_box()
    assert segment == {
        "x": width - slab_width - 104, "y": height - slab_height, "width": 104, "height": slab_height,
    }  # fmt: skip
    on_top = """(slab) => {
        const r = slab.getBoundingClientRect();
        return [[r.left + 3, r.top + 3], [r.right - 3, r.top + 3], [r.left + 3, r.bottom - 3],
                [r.right - 3, r.bottom - 3], [r.left + r.width / 2, r.top + r.height / 2]]
            .map(([x, y]) => slab.contains(document.elementFromPoint(x, y)));
    }"""
    assert slab.evaluate(on_top) == [True] * 5


@pytest.mark.parametrize(("theme", "size"), [("day", "landscape"), ("sunlight", "portrait")])
def test_no_words_run_out_of_the_slab_in_any_state(page: Page, farm: Farm, theme: str, size: str) -> None:
    page.set_viewport_size(dict(zip(("width", "height"), SIZES[size][:2], strict=True)))
    slab = come(page, farm)
    page.evaluate(f"document.documentElement.dataset.theme = {json.dumps(theme)}")
    too_wide = """() => [...document.querySelectorAll('#headland-stop .words > span, #headland-stop .st span')]
        .filter((e) => e.getBoundingClientRect().right > innerWidth - 2 || e.scrollWidth > e.clientWidth + 1)
        .filter((e) => getComputedStyle(e).display !== 'inline').map((e) => e.textContent)"""
    sees(slab, "ready")
    found = page.evaluate(too_wide)
    farm.weeder.ack_after_s, farm.weeder.is_runaway = 0.3, True
    touch(slab)
    for name in ("sent", "acknowledged", "not-confirmed"):
        sees(slab, name)
        found += page.evaluate(too_wide)
    farm.weeder.is_runaway = False
    sees(slab, "standstill")
    found += page.evaluate(too_wide)
    farm.weeder.is_mute = farm.weeder.is_http_mute = True
    expect(slab).to_contain_text("safety controller silent", timeout=15_000)
    expect(slab).to_have_attribute("data-hollow", "")
    found += page.evaluate(too_wide)
    farm.weeder.is_mute = False
    expect(slab).to_contain_text("Standstill confirmed", timeout=15_000)
    assert found == []


def test_a_tablet_that_is_not_enrolled_says_so_and_a_press_is_not_confirmed_at_once(page: Page, farm: Farm) -> None:
    slab = come(page, farm, token="")
    sees(slab, "no-path")
    expect(slab).to_have_attribute("aria-label", re.compile("This tablet is not enrolled. STOP does not work here."))
    touch(slab)
    sees(slab, "not-confirmed", timeout_s=2)
    assert not farm.weeder.is_latched


def test_a_refused_token_is_said_as_not_enrolled(page: Page, farm: Farm) -> None:
    slab = come(page, farm, token="not-a-token")
    expect(slab).to_contain_text("This tablet is not enrolled.")
    sees(slab, "no-path")


def test_enrolling_brings_stop_without_a_reload(page: Page, farm: Farm) -> None:
    slab = come(page, farm, token="")
    sees(slab, "no-path")
    page.evaluate(f"localStorage.setItem('headland.stop_token', {json.dumps(TOKEN)})")
    sees(slab, "ready")


def test_the_slab_survives_what_rebuilds_the_page_and_is_never_there_twice(page: Page, farm: Farm) -> None:
    slab = come(page, farm)
    sees(slab, "ready")
    page.evaluate("document.getElementById('headland-stop').remove()")
    expect(slab).to_be_visible()
    page.add_script_tag(url="/static/js/stop_view.js")
    page.add_script_tag(url="/static/js/stop.js")
    expect(slab).to_have_count(1)
    page.evaluate("document.body.replaceChildren()")
    expect(slab).to_be_visible()
    touch(slab)
    sees(slab, "standstill")


def test_stop_is_there_even_when_style_and_tokens_did_not_load(page: Page, farm: Farm) -> None:
    page.route("**/tokens.css", lambda route: route.abort())
    slab = come(page, farm)
    sees(slab, "ready")
    box = slab.bounding_box()
    assert box is not None
    assert (box["width"], box["height"]) == (300, 96)
    assert slab.evaluate("(e) => getComputedStyle(e).backgroundColor") == "rgb(0, 0, 0)"


def test_what_is_not_sent_while_the_socket_is_down_does_not_arrive_from_the_past(page: Page, farm: Farm) -> None:
    slab = come(page, farm)
    sees(slab, "ready")
    sent = page.evaluate(
        """() => { const old = WebSocket.prototype.send, sent = []; window.sent = sent;
            WebSocket.prototype.send = function (text) {
                sent.push([this.readyState, text]);
                return old.call(this, text);
            };
            return sent.length; }"""
    )
    assert sent == 0
    farm.gateway.kill()
    sees(slab, "no-path")
    touch(slab)
    farm.gateway.start()
    sees(slab, "standstill")
    assert all(ready == 1 for ready, _ in page.evaluate("sent"))


def test_the_head_carries_nonce_and_versions_and_cannot_be_broken_out_of() -> None:
    config = StopConfig(base="https://farm.example/stop/", robot=("weeder-07", "</script><b>"), note='"')
    html = head_html(config, address=lambda path: f"/s/{path}?v=1", nonce="abc")
    assert html.count('nonce="abc"') == html.count("<script")
    assert "</script><b>" not in html
    assert '"base": "https://farm.example/stop"' in html
    assert 'src="/s/js/stop.js?v=1"' in html
