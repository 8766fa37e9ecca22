"""The twin in a real browser: it is drawn, it says when it is old, and STOP comes first."""

from __future__ import annotations

import re
import signal
import time
import zipfile
from collections.abc import Callable, Iterator
from datetime import UTC, datetime, timedelta
from os import kill
from pathlib import Path
from urllib.parse import urlencode, urlsplit

import pytest
from playwright.sync_api import Page, expect

from tests.e2e.berry import Berry
from tests.e2e.caller import Caller
from tests.e2e.cuttable import CuttableLine
from tests.e2e.installation import Installation
from tests.e2e.person import Person, wait_for

pytestmark = [pytest.mark.browser, pytest.mark.broker]
Come = Callable[..., Person]
ROBOT = "weeder-01"
FIRST_PICTURE_S = 60.0  # drawn in software, on a busy machine


def media_is_there(running: Installation) -> None:
    """Wait until the media process serves; nobody else waits for it."""
    wait_for(lambda: running.keeper()["media"]["state"] == "ok", within_s=40, what="the media process serves")


@pytest.fixture
def berry(calm: Installation) -> Iterator[Berry]:
    """A berry picker that is accepted on the farm."""
    media_is_there(calm)
    admin = Caller(calm.url, "admin")
    with Berry(calm.keeper()["broker"]["url"]) as picker:
        admin.post("/robots", {"id": picker.id, "name": "Berry picker 1", "family": "other"})
        yield picker
        admin.delete(f"/robots/{picker.id}")
    admin.close()


def picture(page: Page) -> bytes:
    """Return what the middle of the picture looks like now."""
    box = page.locator("iframe.t-frame").bounding_box()
    assert box is not None
    width, height = box["width"], box["height"]
    clip = {"x": box["x"] + 0.35 * width, "y": box["y"] + 0.3 * height, "width": 0.3 * width, "height": 0.35 * height}
    return page.screenshot(clip=clip)  # type: ignore[arg-type]


def test_without_webgl_the_map_is_shown_and_said_why(person: Come, calm: Installation) -> None:
    media_is_there(calm)
    martha = person("operator")
    martha.open(f"/twin/{ROBOT}")
    martha.sees("twin", "unavailable", within_s=20)
    expect(martha.hook("twin")).to_contain_text("3D is not available here. Showing the map.")
    expect(martha.page.locator(".t-map .hl-map, .t-map hl-map, .t-map canvas").first).to_be_visible()
    assert martha.covers_of_stop() == []


@pytest.mark.long
def test_a_robot_is_seen_and_nothing_leaves_the_origin(person: Come, calm: Installation) -> None:
    media_is_there(calm)
    martha = person("viewer", has_webgl=True)
    asked: list[str] = []
    martha.page.on("request", lambda request: asked.append(request.url))
    martha.page.on("websocket", lambda socket: asked.append(socket.url))
    martha.open(f"/twin/{ROBOT}")
    martha.sees("twin", "live", within_s=FIRST_PICTURE_S)
    ours = {urlsplit(calm.url).hostname, None}
    assert {urlsplit(one).hostname for one in asked if not one.startswith(("data:", "blob:"))} <= ours
    assert any("/viser/" in one for one in asked)
    press(martha, "twin-replay")
    expect(martha.hook("toast")).to_contain_text("Replay needs the supervisor role.")
    assert martha.covers_of_stop() == []


@pytest.mark.long
def test_the_stop_key_works_while_the_picture_has_the_focus(person: Come, calm: Installation) -> None:
    media_is_there(calm)
    martha = person("operator", has_webgl=True)
    martha.open(f"/twin/{ROBOT}")
    martha.sees("twin", "live", within_s=FIRST_PICTURE_S)
    x, y, wide, high = picture_box(martha)
    martha.page.mouse.click(x + wide / 2, y + high / 2)
    martha.page.keyboard.press("Pause")
    wait_for(lambda: calm.world(ROBOT)["latched"], within_s=20, what="the robot is stopped by the key")


@pytest.mark.long
def test_joints_are_seen_to_move_and_age_and_come_back(person: Come, berry: Berry, tmp_path: Path) -> None:
    martha = person("admin", has_webgl=True)
    martha.open(f"/twin/{berry.id}")
    martha.sees("twin", "live", within_s=FIRST_PICTURE_S)
    upload(martha, berry, tmp_path)
    press(martha, "twin-view-follow")
    before = picture(martha.page)
    wait_for(lambda: picture(martha.page) != before, within_s=20, what="the arm moves on the screen")
    expect(martha.hook("joint-lift")).to_have_attribute("data-value", re.compile(r"\d"))
    berry.be_silent()
    martha.sees("twin", "stale", within_s=6)
    expect(martha.hook("twin")).to_contain_text(re.compile(r"Pose is \d+(\.\d)? s old"))
    berry.speak()
    martha.sees("twin", "live", within_s=6)


def press(martha: Person, hook: str) -> None:
    """Press without waiting for two frames that are alike: drawn in software on a busy machine, that takes minutes."""
    martha.hook(hook).dispatch_event("click")


def picture_box(martha: Person) -> tuple[float, float, float, float]:
    """Return where the picture is: left, top, width, height, in px."""
    box = martha.page.locator("iframe.t-frame").bounding_box()
    assert box is not None
    return box["x"], box["y"], box["width"], box["height"]


def open_model(martha: Person) -> None:
    """Open the sheet of the robot's own model."""
    if not martha.hook("twin-model").is_visible():
        press(martha, "twin-layers")
    press(martha, "twin-model")


def upload(martha: Person, berry: Berry, folder: Path) -> None:
    """Give the robot its own model on the screen."""
    berry.script.write_model(folder / "own.zip")
    open_model(martha)
    martha.hook("twin-model-file").set_input_files(folder / "own.zip")
    said = martha.hook("twin-model-said")
    expect(said).to_contain_text("berry_picker: 4 links", timeout=30_000)
    expect(said).to_contain_text("Joints: turn, lift, reach.")
    martha.page.keyboard.press("Escape")


BASE = '<link name="base"><visual><geometry><box size="1 1 1"/></geometry></visual></link>'
ARM = '<link name="arm"><visual><geometry><mesh filename="{}"/></geometry></visual></link>'
HINGE = '<joint name="lift" type="revolute"><parent link="{}"/><child link="{}"/><limit lower="-1" upper="{}"/></joint>'
LIFT = HINGE.format("base", "arm", 1)
BAD = {
    "traversal": (BASE + ARM.format("../../../etc/passwd") + LIFT, 'Link "arm": "../../../etc/passwd" lies outside'),
    "cyclic": (
        BASE + '<link name="arm"/>' + LIFT + HINGE.format("arm", "base", 1).replace("lift", "back"),
        "form a loop",
    ),
    "nan": (BASE + '<link name="arm"/>' + HINGE.format("base", "arm", "nan"), "'nan' is not a finite number"),
    "huge": (BASE.replace("1 1 1", "9000 1 1"), "URDF counts in metres"),
    "xacro": ('<xacro:macro xmlns:xacro="http://www.ros.org/wiki/xacro" name="a"/>' + BASE, "This is xacro, not URDF"),
}


@pytest.mark.long
def test_bad_models_are_refused_on_the_screen_by_link_and_a_missing_mesh_is_said(
    person: Come, berry: Berry, tmp_path: Path
) -> None:
    martha = person("admin", has_webgl=True)
    martha.open(f"/twin/{berry.id}")
    martha.sees("twin", "live", within_s=FIRST_PICTURE_S)
    open_model(martha)
    said = martha.hook("twin-model-said")
    for name, (inside, refusal) in BAD.items():
        martha.hook("twin-model-file").set_input_files(zipped(tmp_path / f"{name}.zip", inside))
        expect(said).to_contain_text(refusal, timeout=30_000)
        expect(said).to_contain_text("Not used.")
    martha.hook("twin-model-file").set_input_files(zipped(tmp_path / "gap.zip", BASE + ARM.format("gone.stl") + LIFT))
    expect(said).to_contain_text('Link "arm": there is no "gone.stl" in the upload. A box stands in for it.')
    martha.page.keyboard.press("Escape")
    martha.sees("twin", "live", within_s=20)
    open_model(martha)
    press(martha, "twin-model-remove")
    expect(said).to_contain_text("It has no model of its own.")


def zipped(path: Path, inside: str) -> Path:
    """Return a zip of one URDF with these elements."""
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("robot.urdf", f'<robot name="bad">{inside}</robot>')
    return path


def moments(running: Installation, robot_id: str) -> int:
    """Return how many postures of the last minutes are on record."""
    until = datetime.now(UTC)
    span = urlencode({"from": (until - timedelta(minutes=5)).isoformat(), "to": until.isoformat()})
    admin = Caller(running.url, "admin")
    try:
        return len(admin.get(f"/robots/{robot_id}/replay?{span}")["t"])
    finally:
        admin.close()


@pytest.mark.long
def test_a_replay_moves_as_recorded_says_what_is_not_recorded_and_goes_back(
    person: Come, berry: Berry, calm: Installation
) -> None:
    martha = person("admin", has_webgl=True)
    martha.open(f"/twin/{berry.id}")
    martha.sees("twin", "live", within_s=FIRST_PICTURE_S)
    wait_for(lambda: moments(calm, berry.id) > 5, within_s=40, what="some seconds are on record")
    press(martha, "twin-replay")
    expect(martha.page.locator(".t-moment")).to_contain_text("recorded", timeout=20_000)
    lift = martha.hook("joint-lift")
    before = lift.get_attribute("data-value")
    wait_for(lambda: lift.get_attribute("data-value") != before, within_s=10, what="recorded joints move")
    if not martha.page.locator(".t-layers").is_visible():
        press(martha, "twin-layers")
    expect(martha.page.locator(".t-layer", has_text="Labels")).to_contain_text("not recorded")
    berry.be_silent()
    martha.page.wait_for_timeout(3500)
    martha.sees("twin", "live", within_s=20)  # the pose of now does not make a recorded one old
    press(martha, "twin-play")
    press(martha, "twin-live")
    martha.sees("twin", "stale", within_s=6)
    berry.speak()
    martha.sees("twin", "live", within_s=6)


@pytest.mark.long
def test_a_cut_picture_comes_back_without_focus(person: Come, calm: Installation) -> None:
    media_is_there(calm)
    martha = person("viewer", has_webgl=True)
    with CuttableLine(urlsplit(calm.url).port or 0) as line:
        martha.open(f"{line.url}/twin/{ROBOT}")
        martha.sees("twin", "live", within_s=FIRST_PICTURE_S)
        martha.page.evaluate(RECONNECT_WATCH)
        martha.hook("twin-view-side").focus()
        for _ in range(3):
            assert line.cut(b"GET /viser?") == 1
            wait_for(lambda: martha.page.evaluate("window.backAfterMs.length"), within_s=30, what="the picture is back")
            print(f"picture back after {martha.page.evaluate('window.backAfterMs.pop()'):.0f} ms")
            martha.page.wait_for_timeout(700)


RECONNECT_WATCH = """() => {
  window.backAfterMs = [];
  let gone = null;
  addEventListener('message', (event) => {
    if (event.data?.from !== 'headland-twin' || event.data.kind !== 'beat') return;
    if (!event.data.isConnected) gone ??= performance.now();
    else if (gone !== null) { window.backAfterMs.push(performance.now() - gone); gone = null; }
  });
}"""


@pytest.mark.long
def test_a_killed_media_process_disturbs_nobody_and_comes_back(person: Come, calm: Installation) -> None:
    media_is_there(calm)
    martha = person("operator", has_webgl=True)
    martha.open(f"/twin/{ROBOT}")
    martha.sees("twin", "live", within_s=FIRST_PICTURE_S)
    martha.page.evaluate(STATE_WATCH)
    killed = calm.pid("media")
    kill(killed, signal.SIGKILL)
    said = "window.twinStates.find((state) => state !== 'live')"
    wait_for(lambda: martha.page.evaluate(said), within_s=15, what="it says that it is not live")
    martha.sees("stop", "ready", within_s=20)
    martha.sees("link-banner", "ok", within_s=20)
    wait_for(lambda: calm.pid("media") != killed, within_s=20, what="it is started again")
    media_is_there(calm)
    martha.sees("twin", "live", within_s=FIRST_PICTURE_S)


STATE_WATCH = """() => {
  window.twinStates = []; // it may be back before anybody asks what it said meanwhile
  const twin = document.querySelector('[data-testid=twin]');
  const note = () => window.twinStates.push(twin.dataset.state);
  new MutationObserver(note).observe(twin, { attributeFilter: ['data-state'] });
}"""


@pytest.mark.long
def test_a_tap_on_a_tablet_says_what_was_touched(person: Come, calm: Installation) -> None:
    media_is_there(calm)
    martha = person("viewer", has_webgl=True)
    martha.open(f"/twin/{ROBOT}")
    martha.sees("twin", "live", within_s=FIRST_PICTURE_S)
    x, y, wide, high = picture_box(martha)
    deadline_s = time.monotonic() + 20
    while not martha.hook("twin-details").is_visible():
        assert time.monotonic() < deadline_s, "a tap says nothing"
        martha.page.touchscreen.tap(x + 0.6 * wide, y + 0.6 * high)
        martha.page.wait_for_timeout(700)
    assert re.search(r"Weeder 01|Ground", martha.hook("twin-details").inner_text())
