"""STOP, pressed by a finger, in a real browser, over real wire."""

from __future__ import annotations

import os
import re
import signal
from collections.abc import Callable

import pytest
from playwright.sync_api import expect

from tests.e2e.installation import Installation
from tests.e2e.person import Person, wait_for

pytestmark = pytest.mark.browser
Come = Callable[..., Person]
SCREENS = ("/operate/weeder-01", "/fleet", "/missions", "/admin")
WHEN_READY = """new MutationObserver((_, watch) => {
  if (document.querySelector('[data-testid=stop]')?.dataset.state !== 'ready') return;
  window.readyAt = performance.now();
  watch.disconnect();
}).observe(document, { subtree: true, childList: true, attributes: true })"""
EARLY = """() => performance.getEntriesByType('resource')
  .filter((one) => one.startTime < window.readyAt).map((one) => one.name)"""
MAP_IS_HERE = "() => performance.getEntriesByType('resource').some((one) => /resources.*live_map.js/.test(one.name))"
PATIENT = """Object.defineProperty(window, 'headlandStop', {configurable: true, set(stop) {
    const own = stop.whenReady;
    stop.whenReady = () => own(60000); // on a busy machine STOP may take longer than a page waits for it
    Object.defineProperty(window, 'headlandStop', {value: stop});
}})"""
LATE = ("/live_map.js", "maplibre", "/bundle/demo", "/bundle/run", "/bundle/bell")


def test_one_press_leads_to_confirmed_standstill_with_the_time_of_each_step(person: Come, calm: Installation) -> None:
    martha = person("operator")
    martha.operate("weeder-01")
    martha.press_stop()
    martha.sees("stop", "standstill")
    steps = martha.hook("stop-steps")
    expect(steps).to_have_attribute("data-standstill-ms", re.compile(r"\d"))  # drawn a frame after the slab
    sent, acknowledged, standing = (
        float(steps.get_attribute(f"data-{name}-ms") or "nan") for name in ("sent", "ack", "standstill")
    )
    assert 0 <= sent <= acknowledged <= standing
    assert calm.world("weeder-01")["latched"]
    assert not calm.world("weeder-02")["latched"]


@pytest.mark.parametrize(
    "size", ["portrait", *(pytest.param(s, marks=pytest.mark.long) for s in ("landscape", "desk"))]
)
def test_nothing_ever_covers_stop_on_any_screen(person: Come, size: str) -> None:
    anna = person("admin", size=size)
    for screen in SCREENS:
        anna.open(screen)
        anna.sees("stop", "ready")
        assert anna.covers_of_stop() == [], screen


def test_stop_survives_every_change_of_screen_with_one_socket(person: Come) -> None:
    anna = person("admin", sign_in=False)
    opened: list[str] = []
    anna.page.on("websocket", lambda socket: opened.append(socket.url))
    anna.sign_in()
    anna.operate("weeder-01")
    before = len([url for url in opened if url.endswith("/ws")])
    for name in ("fleet", "missions", "admin", "operate", "fleet"):
        anna.hook(f"nav-{name}").first.click()
        anna.sees("stop", "ready")
    assert len([url for url in opened if url.endswith("/ws")]) == before


def test_map_and_demo_are_fetched_only_after_stop_is_ready(person: Come) -> None:
    martha = person("operator")
    martha.page.add_init_script(WHEN_READY)
    martha.page.add_init_script(PATIENT)
    martha.operate("weeder-01")
    martha.page.wait_for_function(MAP_IS_HERE)
    early = [name for name in martha.page.evaluate(EARLY) if "/components/" not in name]
    assert early
    assert not [name for name in early for late in LATE if late in name]


def test_a_silent_robot_is_never_shown_as_stopped(person: Come, calm: Installation) -> None:
    martha = person("operator")
    martha.operate("weeder-01")
    calm.fault("weeder-01", "silence", http=True, deaf=True)
    martha.press_stop()
    martha.sees("stop", "not-confirmed", within_s=4)
    expect(martha.hook("link-banner").get_by_text("Use the red button on the machine")).to_be_visible()
    assert not calm.world("weeder-01")["latched"]
    calm.mend("weeder-01")
    martha.sees("stop", "standstill", within_s=15)
    assert calm.world("weeder-01")["latched"]


def test_stop_works_while_the_console_is_frozen(person: Come, calm: Installation) -> None:
    martha = person("operator")
    martha.operate("weeder-01")
    console = calm.pid("console")
    os.kill(console, signal.SIGSTOP)
    try:
        martha.press_stop()
        martha.sees("stop", "standstill", within_s=5)
        assert calm.world("weeder-01")["latched"]
    finally:
        os.kill(console, signal.SIGCONT)


def test_stop_works_with_the_broker_dead(person: Come, calm: Installation) -> None:
    martha = person("operator")
    martha.operate("weeder-01")
    broker = calm.pid("broker")
    os.kill(broker, signal.SIGSTOP)  # silent, as behind a dead link: nobody is told that it is gone
    try:
        martha.press_stop()
        martha.sees("stop", "standstill", within_s=8)
        assert calm.world("weeder-01")["latched"]
    finally:
        os.kill(broker, signal.SIGCONT)


def test_stop_all_counts_honestly_when_one_robot_is_silent(person: Come, calm: Installation) -> None:
    anna = person("supervisor")
    anna.open("/fleet")
    anna.sees("stop", "ready")
    calm.fault("weeder-02", "silence", http=True, deaf=True)
    anna.press_stop()
    anna.sees("stop", "not-confirmed", within_s=5)
    expect(anna.hook("stop")).to_have_attribute("data-standing", "2", timeout=5000)
    expect(anna.hook("stop")).to_have_attribute("data-total", "3")
    calm.mend("weeder-02")
    anna.sees("stop", "standstill", within_s=15)
    assert all(calm.world(robot)["latched"] for robot in ("weeder-01", "weeder-02", "weeder-03"))


def test_a_viewer_may_stop_too_and_by_key(person: Come, calm: Installation) -> None:
    lena = person("viewer")
    lena.operate("weeder-01")
    lena.page.keyboard.press("Control+.")
    lena.sees("stop", "standstill")
    assert calm.world("weeder-01")["latched"]


def test_an_enrolled_tablet_stops_from_the_sign_in_page(person: Come, calm: Installation) -> None:
    martha = person("operator", by_form=True)
    martha.page.evaluate(
        """async () => {
            const answer = await fetch('/api/v1/devices', {method: 'POST', body: JSON.stringify({name: 'Tablet 3'}),
                headers: {'Content-Type': 'application/json', 'X-Headland-CSRF': window.HEADLAND.csrf}});
            localStorage.setItem('headland.stop_token', (await answer.json()).stop_token);
        }"""
    )
    csrf = martha.page.evaluate("window.HEADLAND.csrf")
    martha.page.goto("about:blank")  # its page would go to the sign-in page by itself, at the same moment
    headers = {"X-Headland-CSRF": csrf, "Origin": calm.url}
    assert martha.context.request.delete("/api/v1/session", headers=headers).ok
    martha.page.goto("/login")
    martha.sees("stop", "ready", within_s=30)
    martha.press_stop()
    wait_for(lambda: calm.world("weeder-01")["latched"], within_s=3, what="stopped without sign-in")
