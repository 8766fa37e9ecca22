"""Cameras in a real browser: true delay from the pixels, a blocked way, a dead server, and nothing left behind."""

from __future__ import annotations

import re
import signal
from collections.abc import Callable, Iterator
from os import kill

import pytest
from playwright.sync_api import Page, expect

from tests.e2e.caller import Caller
from tests.e2e.installation import Installation
from tests.e2e.person import Person, wait_for

# the demo of the regular run has no cameras: each STOP would open one, draw it and encode it beside the stories
pytestmark = [pytest.mark.browser, pytest.mark.broker, pytest.mark.long]
Come = Callable[..., Person]
ROBOT, CAMERA = "weeder-01", "front"
FIRST_S = 20.0  # the camera process and its worker start when somebody first looks
NO_UDP = "RTCPeerConnection.prototype.addIceCandidate = async () => {};" + (
    "const answer = RTCPeerConnection.prototype.setRemoteDescription;"
    "RTCPeerConnection.prototype.setRemoteDescription = function (d) {"
    " return answer.call(this, { type: d.type, sdp: d.sdp.replace(/a=candidate:.*\\r\\n/g, '') }); };"
)
READ_CODE = """() => {
  const view = document.querySelector('.c-pip .c-view');
  const source = view.classList.contains('direct') ? view.querySelector('video') : view.querySelector('canvas');
  const width = source.videoWidth || source.width, height = source.videoHeight || source.height;
  const copy = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true });
  copy.drawImage(source, 0, 0);
  const side = Math.max(4, width / 80);
  const at = (n) => Math.round((n + .5) * side);
  const light = (i, row) => copy.getImageData(at(i), at(row), 1, 1).data[1] > 127;
  let code = 0;
  for (let i = 0; i < 24; i += 1) {
    if (light(i, 0) === light(i, 1)) return null;
    code = code * 2 + (light(i, 0) ? 1 : 0);
  }
  const shown = Number(document.querySelector('.c-pip').dataset.delayMs);
  return { trueMs: ((Date.now() % 2 ** 24) - code + 2 ** 24) % 2 ** 24, shownMs: shown };
}"""

# the light of the picture in 16 x 12 fields, without the time code above and the caption below
READ_LIGHT = """() => {
  const view = document.querySelector('.c-pip .c-view');
  const source = view.classList.contains('direct') ? view.querySelector('video') : view.querySelector('canvas');
  const copy = new OffscreenCanvas(16, 16).getContext('2d', { willReadFrequently: true });
  copy.drawImage(source, 0, 0, 16, 16);
  const { data } = copy.getImageData(0, 2, 16, 12);
  return Array.from({ length: 192 }, (_, i) => (data[4 * i] + data[4 * i + 1] + data[4 * i + 2]) / 3);
}"""

# closed after 0 to 450 ms: before the offer, before the answer, while the way opens, while pictures come
OPEN_AND_CLOSE = """async ([begun, count]) => {
  const button = document.querySelector('[data-testid=pip-toggle]');
  const isThere = () => document.querySelector('[data-testid=pip]') !== null;
  const until = async (wanted) => { while (isThere() !== wanted) await new Promise(requestAnimationFrame); };
  for (let i = begun; i < begun + count; i += 1) {
    button.click();
    await until(false);
    button.click();
    await until(true);
    await new Promise((done) => setTimeout(done, 50 * (i % 10)));
  }
}"""


def watch(someone: Person) -> Page:
    """Open the picture on Operate and wait until it shows something."""
    someone.open(f"/operate/{ROBOT}")
    someone.hook("pip-toggle").click()
    someone.sees("pip", "live|stills", within_s=FIRST_S)
    return someone.page


@pytest.fixture
def viewers(calm: Installation) -> Iterator[Callable[[], int]]:
    """Say how many watch the robot's cameras, as the server counts."""
    caller = Caller(calm.url, "viewer")
    yield lambda: sum(one["viewers"] for one in caller.get(f"/cameras?robot={ROBOT}")["cameras"])
    caller.close()


def codes(page: Page, count: int = 5) -> list[dict[str, float]]:
    """Read the time code of several pictures."""
    found: list[dict[str, float]] = []
    for _ in range(100):
        if len(found) == count:
            break
        if read := page.evaluate(READ_CODE):
            found.append(read)
        page.wait_for_timeout(70)
    assert len(found) == count, "the time code cannot be read"
    return found


def test_the_delay_on_the_screen_is_the_one_the_pixels_tell_and_leaving_frees_the_server(
    person: Come, viewers: Callable[[], int]
) -> None:
    martha = person("operator")
    page = watch(martha)
    expect(martha.hook("pip")).to_have_attribute("data-way", "direct", timeout=FIRST_S * 1000)
    expect(martha.hook("pip")).to_have_attribute("data-delay-ms", re.compile(r"\d"))
    apart = sorted(abs(one["trueMs"] - one["shownMs"]) for one in codes(page))
    # two pictures at 15 a second; a page that is slow to read its pixels reads them late
    assert apart[0] < 150, f"shown and true delay differ: {apart}"
    assert martha.covers_of_stop() == []
    assert viewers() > 0
    page.close()
    wait_for(lambda: viewers() == 0, within_s=2.0 * 3, what="the server lets go of the page")


def test_where_udp_is_closed_single_pictures_are_shown_and_said(person: Come) -> None:
    martha = person("operator")
    martha.page.add_init_script(NO_UDP)
    page = watch(martha)
    expect(martha.hook("pip")).to_have_attribute("data-state", "stills", timeout=8000)
    expect(martha.hook("pip")).to_have_attribute("data-way", "jpeg")
    expect(page.locator(".c-note")).to_have_text("Single pictures")
    assert len(codes(page, 2)) == 2


def test_a_killed_camera_process_leaves_a_frozen_picture_that_comes_back(person: Come, calm: Installation) -> None:
    martha = person("operator")
    page = watch(martha)
    kill(calm.pid("cameras"), signal.SIGKILL)
    martha.sees("pip", "frozen", within_s=5)
    expect(page.locator(".c-piphead .end")).to_have_text(re.compile(r"^frozen \d+ s$"))
    martha.sees("pip", "live|stills", within_s=40)
    expect(martha.hook("pip")).to_have_attribute("data-way", "direct", timeout=40_000)
    assert martha.covers_of_stop() == []


def test_two_hundred_openings_leave_no_connection_behind(person: Come, viewers: Callable[[], int]) -> None:
    martha = person("operator")
    page = watch(martha)
    for begun in range(0, 200, 20):
        page.evaluate(OPEN_AND_CLOSE, [begun, 20])
        martha.sees("pip", "live|stills", within_s=FIRST_S)  # none of them took its way from the next
        expect(martha.hook("pip")).to_have_attribute("data-way", "direct", timeout=FIRST_S * 1000)
    martha.hook("pip-toggle").click()
    page.wait_for_function("HL.camera.directs.size === 0")
    wait_for(lambda: viewers() == 0, within_s=10, what="the server lets go of all of them")


def light(page: Page) -> list[float]:
    """Return the light of the picture that is shown, field by field."""
    found: list[float] = page.evaluate(READ_LIGHT)
    return found


def apart(one: list[float], other: list[float]) -> float:
    """Return by how much two pictures differ, of 255."""
    return sum(abs(a - b) for a, b in zip(one, other, strict=True)) / len(one)


def test_what_is_done_to_a_camera_is_seen_in_its_picture(person: Come) -> None:
    """Zoom and lamp, each by its button; each ends as it began, and the lamp is known after a reload."""
    martha = person("operator")
    page = watch(martha)
    martha.hook("lease-request").click()
    martha.hook("view-camera").click()
    expect(martha.hook("camera-zoom-in")).not_to_have_attribute("aria-disabled", "true", timeout=10_000)
    expect(martha.hook("pip")).to_have_attribute("data-way", "direct", timeout=FIRST_S * 1000)

    def settled() -> list[float]:
        page.wait_for_timeout(1200)  # two pictures a second at the least, and the encoder's last refinement
        return light(page)

    usual = settled()
    assert apart(usual, settled()) < 3, "a robot that stands still sees the same"
    martha.hook("camera-zoom-in").click()
    wait_for(lambda: apart(usual, light(page)) > 5, within_s=6, what="the zoom in the picture")
    martha.hook("camera-zoom-out").click()
    wait_for(lambda: apart(usual, light(page)) < 3, within_s=6, what="the zoom back")
    martha.hook("camera-lamp").click()
    low = slice(112, 192)
    wait_for(lambda: sum(light(page)[low]) > 1.05 * sum(usual[low]), within_s=6, what="the lamp on the ground")
    expect(martha.hook("camera-lamp")).to_have_attribute("aria-pressed", "true")
    page.reload()
    martha.sees("pip", "live|stills", within_s=FIRST_S)
    expect(martha.hook("camera-lamp")).to_have_attribute("aria-pressed", "true", timeout=10_000)
    martha.hook("camera-lamp").click()
    wait_for(lambda: apart(usual, light(page)) < 3, within_s=6, what="the lamp off")
    assert martha.covers_of_stop() == []


def test_a_camera_moves_while_its_pad_is_held_and_stays_there(person: Come) -> None:
    martha = person("operator")
    page = watch(martha)
    martha.hook("lease-request").click()
    martha.hook("view-camera").click()
    expect(martha.hook("pip")).to_have_attribute("data-way", "direct", timeout=FIRST_S * 1000)
    page.wait_for_timeout(1200)
    usual = light(page)
    martha.hook("camera-move").click()
    # a press before the first look at link and picture moves nothing, and has to be let go first
    expect(martha.hook("camera-move-end")).to_have_text("End")
    page.wait_for_function("HL.jog.isMine() && performance.now() - HL.jog.begunAt > 300 && !HL.jog.blockedBy")
    martha.hook("camera-move-left").hover()
    page.mouse.down()
    wait_for(lambda: apart(usual, light(page)) > 5, within_s=10, what="the turning head in the picture")
    expect(martha.hook("camera-move-left")).to_have_attribute("data-state", "held")
    page.mouse.up()
    page.wait_for_timeout(1200)
    turned = light(page)
    page.wait_for_timeout(1200)
    assert apart(turned, light(page)) < 3, "nobody moves it"
    martha.hook("camera-move-end").click()
    wait_for(lambda: apart(usual, light(page)) < 3, within_s=10, what="the head looks ahead again")
