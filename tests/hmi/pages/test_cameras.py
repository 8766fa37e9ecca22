"""Cameras: a wall that says how old each picture is, and a picture on Operate that driving depends on."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Locator, Page, expect

from tests.hmi.pages.conftest import TABLETS, Theatre
from tests.hmi.pages.fingers import hold
from tests.hmi.pages.test_shell import is_stop_on_top

pytestmark = pytest.mark.browser
Look = Callable[..., Page]
SHOWN = re.compile("^(live|stills)$")


@pytest.fixture
def cameras(theatre: Theatre) -> Callable[..., None]:
    """Set what cameras do; begins with all of them giving pictures."""
    theatre.play("running")
    theatre.cameras(anew=True)
    return theatre.cameras


def tile(page: Page, name: str) -> Locator:
    """Return the tile of a camera once it shows pictures."""
    found = page.get_by_test_id(f"camera-{name.replace('/', '-')}")
    expect(found).to_have_attribute("data-state", SHOWN)
    return found


def covers(page: Page, inner: str, outer: str) -> Any:
    """Return by how many px one box sticks out of another."""
    return page.evaluate(
        """([inner, outer]) => {
          const [a, b] = [inner, outer].map((one) => document.querySelector(one).getBoundingClientRect());
          return Math.round(Math.max(0, b.left - a.left, b.top - a.top, a.right - b.right, a.bottom - b.bottom));
        }""",
        [inner, outer],
    )


def apart(page: Page, one: str, other: str) -> Any:
    """Say whether two boxes do not lie over each other."""
    return page.evaluate(
        """([one, other]) => {
          const [a, b] = [one, other].map((name) => document.querySelector(name).getBoundingClientRect());
          return a.right <= b.left + 1 || b.right <= a.left + 1 || a.bottom <= b.top + 1 || b.bottom <= a.top + 1;
        }""",
        [one, other],
    )


def test_each_picture_says_its_delay_and_a_frozen_one_how_old_it_is(look: Look, cameras: Callable[..., None]) -> None:
    page = look("/cameras")
    front = tile(page, "weeder-07/front")
    expect(front).to_have_attribute("data-fps", re.compile(r"^[3-6]\."))
    assert 80 <= float(front.get_attribute("data-delay-ms") or "nan") < 1000
    expect(front.locator(".c-head .end")).to_have_text(re.compile(r"^\d+ ms, [3-6] fps$"))
    expect(front.locator(".c-foot .end")).to_have_text(re.compile("^(Single pictures)?$"))
    expect(page.get_by_test_id("cameras-sum")).to_have_text("4 streams, 3.6 Mbit/s.")
    down = {"state": "failed", "reason": "Node camera_rear is in error", "restarts": 3}
    cameras(frozen=["weeder-07/front"], cameras={"planter-02/head": down})
    expect(front).to_have_attribute("data-state", "frozen", timeout=4000)
    expect(front.locator(".c-head .end")).to_have_text(re.compile(r"^frozen \d+ s$"))
    expect(front.locator(".c-foot .end")).to_have_text(re.compile(r"^Last picture \d\d:\d\d:\d\d$"))
    cameras(frozen=[], cameras={})
    tile(page, "weeder-07/front")
    assert is_stop_on_top(page)


def test_who_steers_by_a_frozen_picture_does_not_drive_and_reads_why(
    look: Look, theatre: Theatre, cameras: Callable[..., None]
) -> None:
    page = look("/operate/weeder-07")
    page.get_by_test_id("pip-toggle").click()
    expect(page.get_by_test_id("pip")).to_have_attribute("data-state", SHOWN)
    assert covers(page, ".c-pip", ".h-map") == 0
    theatre.play("manual")
    page.get_by_test_id("drive-open").click()
    pad = page.get_by_test_id("drive-forward")
    expect(pad).to_have_attribute("data-state", "idle")
    hold(page, pad)
    cameras(frozen=["weeder-07/front"])
    expect(pad).to_have_attribute("data-state", "off", timeout=4000)
    expect(pad).to_have_text(re.compile(r"^videocam_off\s*Picture .* old$"))
    drives = theatre.heard()["drives"]
    assert drives[-1] == {"v": 0.0, "w": 0.0}
    assert all(one["picture"] <= 1000 for one in drives if one["v"])
    page.mouse.up()
    page.get_by_test_id("pip-close").click()
    expect(pad).to_have_attribute("data-state", "idle")
    assert is_stop_on_top(page)


@pytest.mark.parametrize("size", TABLETS)
def test_a_console_whose_cameras_are_not_up_yet_says_so_on_operate_until_they_come(
    look: Look, cameras: Callable[..., None], size: str
) -> None:
    cameras(down=True)
    page = look("/operate/weeder-07", size=size)
    note = page.get_by_test_id("cameras-starting")
    expect(note).to_have_text("Cameras are starting")
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert covers(page, "[data-testid=cameras-starting]", ".h-overlay") == 0
    cameras(anew=True)
    expect(page.get_by_test_id("pip-toggle")).to_be_visible(timeout=8000)
    expect(note).to_be_hidden()


@pytest.mark.parametrize("source", ["mjpeg", "rtsp"])
def test_who_steers_by_a_camera_that_tells_no_time_creeps_whatever_its_pictures_look_like(
    look: Look, theatre: Theatre, cameras: Callable[..., None], source: str
) -> None:
    cameras(cameras={"weeder-07/front": {"is_dated": False, "source": source}})
    page = look("/operate/weeder-07")
    page.get_by_test_id("pip-toggle").click()
    pip = page.get_by_test_id("pip")
    expect(pip).to_have_attribute("data-state", SHOWN)
    expect(pip).to_contain_text("delay unknown")
    theatre.play("manual")
    page.get_by_test_id("drive-open").click()
    pad = page.get_by_test_id("drive-forward")
    expect(pad).to_have_attribute("data-state", "idle")
    hold(page, pad)
    expect(page.get_by_text("This camera tells no time: Creep only.")).to_be_visible()
    page.mouse.up()
    moved = [one for one in theatre.heard()["drives"] if one["v"]]
    assert moved
    assert all(one["v"] <= 0.2 and 500 < one["picture"] <= 1000 for one in moved)


@pytest.mark.long
@pytest.mark.parametrize("size", TABLETS)
def test_the_wall_fits_every_size_and_its_buttons_can_be_hit(
    look: Look, cameras: Callable[..., None], size: str
) -> None:
    page = look("/cameras", size=size)
    tile(page, "weeder-07/front")
    for n in (2, 3, 4):
        page.get_by_test_id(f"cameras-size-{n}").click()
        tile(page, "weeder-07/front")
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    small = page.evaluate(
        """[...document.querySelectorAll('.c-screen button:not([hidden])')].map((b) => [b, b.getBoundingClientRect()])
        .filter(([, box]) => box.width && (box.width < 46 || box.height < 46)).map(([b]) => b.dataset.testid)"""
    )
    assert small == []
    assert is_stop_on_top(page)


@pytest.mark.long
def test_only_pictures_that_can_be_seen_are_fetched_and_none_after_leaving(
    look: Look, theatre: Theatre, cameras: Callable[..., None]
) -> None:
    page = look("/cameras")
    tile(page, "weeder-07/front")
    assert len(theatre.heard_cameras()["watched"]) == 4
    page.get_by_test_id("camera-weeder-07-front").dblclick()
    expect(page.get_by_test_id("cameras-sum")).to_have_text(re.compile("^1 stream, .* Off-screen streams pause."))
    page.keyboard.press("Escape")
    tile(page, "weeder-01/front")
    page.keyboard.press("g")
    page.keyboard.press("f")
    expect(page.get_by_test_id("fleet")).to_be_visible()
    page.wait_for_function("!HL.camera.socket.count()")
    assert theatre.heard_cameras()["watched"] == []


@pytest.mark.long
def test_a_camera_that_is_down_says_why_and_can_be_started_again_by_those_who_may(
    look: Look, theatre: Theatre, cameras: Callable[..., None]
) -> None:
    cameras(cameras={"planter-02/head": {"state": "failed", "reason": "Node camera_head is in error", "restarts": 3}})
    page = look("/cameras")
    head = page.get_by_test_id("camera-planter-02-head")
    expect(head).to_have_attribute("data-state", "off")
    expect(head).to_contain_text("Node camera_head is in error. Restarted 3 times.")
    page.get_by_test_id("camera-restart-planter-02-head").click()
    expect(page.get_by_test_id("toast")).to_contain_text("The camera is being started again.")
    assert "planter-02/head/restart" in theatre.heard_cameras()["asked"]
    viewer = look("/cameras", role="viewer")
    expect(viewer.get_by_test_id("camera-planter-02-head")).to_contain_text("No picture for")
    expect(viewer.get_by_test_id("camera-restart-planter-02-head")).to_be_hidden()


@pytest.mark.long
def test_the_way_to_start_it_again_is_whole_in_small_tiles_and_not_there_for_one_that_sends_by_itself(
    look: Look, cameras: Callable[..., None]
) -> None:
    down = {"state": "failed", "reason": "The camera sends elsewhere, which is not followed", "restarts": 7}
    cameras(cameras={"planter-02/head": down, "weeder-01/front": {**down, "source": "upload"}})
    page = look("/cameras")
    button, foot = (
        page.get_by_test_id("camera-restart-planter-02-head"),
        page.locator("[data-testid=camera-planter-02-head] .c-foot"),
    )
    for size in (3, 4):
        page.get_by_test_id(f"cameras-size-{size}").click()
        expect(page.get_by_test_id("camera-planter-02-head")).to_have_attribute("data-state", "off")
        box, below = button.bounding_box(), foot.bounding_box()
        assert box is not None
        assert below is not None
        assert box["height"] >= 44
        assert box["y"] + box["height"] <= below["y"]
    expect(page.get_by_test_id("camera-weeder-01-front")).to_have_attribute("data-state", "off")
    expect(page.get_by_test_id("camera-restart-weeder-01-front")).to_be_hidden()


@pytest.mark.long
def test_the_screen_says_what_is_wrong_when_there_is_no_wall(look: Look, cameras: Callable[..., None]) -> None:
    cameras(none=True)
    page = look("/cameras")
    expect(page.get_by_test_id("cameras-notice")).to_contain_text("No camera yet")
    cameras(anew=True, status=403)
    page.reload()
    expect(page.get_by_test_id("cameras-notice")).to_contain_text("Video of this site is not shared with you.")
    cameras(anew=True, down=True)
    page.reload()
    expect(page.get_by_test_id("cameras-notice")).to_contain_text("Cameras are starting")
    cameras(anew=True)
    tile(page, "weeder-07/front")
    cameras(anew=True, status=500)
    page.reload()
    expect(page.get_by_test_id("cameras-notice")).to_contain_text("Cameras do not answer")
    cameras(anew=True)
    tile(page, "weeder-07/front")
    cameras(down=True)
    expect(page.get_by_test_id("camera-weeder-07-front")).to_have_attribute("data-state", "frozen", timeout=4000)
    cameras(anew=True)
    tile(page, "weeder-07/front")


@pytest.mark.long
def test_a_snapshot_is_kept_and_found_under_pictures(
    look: Look, theatre: Theatre, cameras: Callable[..., None]
) -> None:
    page = look("/cameras")
    tile(page, "weeder-07/front").click()
    page.get_by_test_id("camera-snapshot").click()
    expect(page.get_by_test_id("toast")).to_contain_text("It is under Cameras, Pictures.")
    page.get_by_test_id("cameras-pictures").click()
    kept = page.get_by_test_id("picture-p-0")
    expect(kept).to_contain_text("Weeder 07, front")
    expect(kept).to_contain_text("51.750000, 5.750000")
    expect(page.get_by_test_id("picture-download-p-0")).to_have_attribute("href", re.compile(r"download=true$"))
    page.get_by_test_id("picture-mark-p-0").click()
    expect(page.get_by_test_id("picture-mark-p-0")).to_have_attribute("aria-pressed", "true")
    page.get_by_test_id("picture-note-p-0").click()
    page.get_by_test_id("picture-note-text-p-0").fill("Stone in row 4")
    page.get_by_test_id("picture-note-save-p-0").click()
    expect(kept).to_contain_text("Stone in row 4")
    page.get_by_test_id("pictures-robot").select_option("weeder-01")
    expect(kept).to_have_count(0)
    page.get_by_test_id("pictures-robot").select_option("weeder-07")
    expect(kept).to_contain_text("Stone in row 4")
    expect(page.get_by_test_id("picture-delete-p-0")).to_have_count(0)
    assert is_stop_on_top(page)


@pytest.mark.long
def test_pictures_says_of_which_robots_the_minute_before_a_stop_is_kept(
    look: Look, cameras: Callable[..., None]
) -> None:
    cameras(cameras={"weeder-07/front": {"is_kept": True}})
    page = look("/cameras")
    tile(page, "weeder-07/front")
    page.get_by_test_id("cameras-pictures").click()
    said = page.get_by_test_id("pictures-kept-now")
    expect(said).to_contain_text("The minute before a STOP is being kept of Weeder 07. Not of ")
    cameras(cameras={})
    page.reload()
    tile(page, "weeder-07/front")
    page.get_by_test_id("cameras-pictures").click()
    expect(said).to_contain_text("The minute before a STOP is kept of no robot now.")


def test_an_admin_deletes_a_picture_by_a_second_tap(look: Look, theatre: Theatre, cameras: Callable[..., None]) -> None:
    page = look("/cameras", role="admin")
    tile(page, "weeder-07/front").click()
    page.get_by_test_id("camera-snapshot").click()
    expect(page.get_by_test_id("toast")).to_contain_text("It is under Cameras, Pictures.")
    page.get_by_test_id("cameras-pictures").click()
    page.get_by_test_id("picture-delete-p-0").click()
    expect(page.get_by_test_id("picture-delete-p-0")).to_contain_text("Delete for good?")
    page.get_by_test_id("picture-delete-p-0").click()
    expect(page.get_by_test_id("picture-p-0")).to_have_count(0)
    assert theatre.heard_cameras()["pictures"] == 0


@pytest.mark.long
def test_my_wall_is_kept_and_keys_walk_it(look: Look, cameras: Callable[..., None]) -> None:
    page = look("/cameras")
    tile(page, "weeder-07/front")
    page.get_by_test_id("cameras-mode-mine").click()
    page.get_by_test_id("my-wall-weeder-07-rear").click()
    page.get_by_test_id("my-wall-weeder-01-front").click()
    page.get_by_role("button", name="Use these").click()
    tile(page, "weeder-07/rear")
    expect(page.locator(".c-tile")).to_have_count(2)
    page.reload()
    tile(page, "weeder-07/rear")
    expect(page.locator(".c-tile")).to_have_count(2)
    page.keyboard.press("j")
    expect(page.get_by_test_id("camera-weeder-07-rear")).to_have_attribute("aria-pressed", "true")
    page.keyboard.press("Enter")
    page.wait_for_url("**/operate/weeder-07")


@pytest.mark.long
@pytest.mark.parametrize("size", TABLETS)
def test_the_small_picture_moves_to_a_corner_swaps_with_the_map_and_covers_nothing_that_stops(
    look: Look, theatre: Theatre, cameras: Callable[..., None], size: str
) -> None:
    page = look("/operate/weeder-07", size=size)
    page.get_by_test_id("pip-toggle").click()
    pip = page.get_by_test_id("pip")
    expect(pip).to_have_attribute("data-state", SHOWN)
    expect(pip).to_have_attribute("data-corner", "bottom-left")
    head, area = page.locator(".c-piphead").bounding_box(), page.locator(".h-map").bounding_box()
    assert head is not None
    assert area is not None
    page.mouse.move(head["x"] + 16, head["y"] + 20)
    page.mouse.down()
    page.mouse.move(area["x"] + area["width"] - 60, area["y"] + 40, steps=6)
    page.mouse.up()
    expect(pip).to_have_attribute("data-corner", "top-right")
    page.reload()
    expect(pip).to_have_attribute("data-corner", "top-right")
    assert covers(page, ".c-pip", ".h-map") == 0
    page.get_by_test_id("view-camera").click()
    expect(pip).to_have_class(re.compile("big"))
    assert covers(page, ".h-mapfill", ".h-map") == 0
    theatre.alarms(put={"link-lost.weeder-07": {}})
    expect(page.get_by_test_id("alarm-strip")).to_be_visible()
    for part in (".c-tools", "hl-alarm-strip"):
        assert apart(page, ".h-mapfill", part), f"the small map lies over {part}"
    theatre.alarms(drop=["link-lost.weeder-07"])
    page.get_by_test_id("pip-swap").click()
    expect(pip).not_to_have_class(re.compile("big"))
    page.get_by_test_id("pip-close").click()
    expect(pip).to_have_count(0)
    assert is_stop_on_top(page)


@pytest.mark.long
def test_a_slow_picture_lets_only_creep(look: Look, theatre: Theatre, cameras: Callable[..., None]) -> None:
    cameras(lag_ms=520)
    page = look("/operate/weeder-07")
    page.get_by_test_id("pip-toggle").click()
    expect(page.get_by_test_id("pip")).to_have_attribute("data-state", SHOWN)
    theatre.play("manual")
    page.get_by_test_id("drive-open").click()
    page.get_by_test_id("drive-speed-slow").click()
    expect(page.locator("hl-drive")).to_have_attribute("data-picture", "slow")
    expect(page.locator(".h-drivecard")).to_contain_text("Creep only.")
    hold(page, page.get_by_test_id("drive-forward"))
    page.wait_for_timeout(300)
    page.mouse.up()
    moved = [one["v"] for one in theatre.heard()["drives"] if one["v"]]
    assert moved
    assert set(moved) == {0.2}


@pytest.mark.long
def test_lamp_and_zoom_begin_at_what_the_robot_says(look: Look, theatre: Theatre, cameras: Callable[..., None]) -> None:
    zoom = {"ptz": {"pan": None, "tilt": None, "zoom": [1.0, 4.0]}}
    cameras(setting={"lamp": True, "zoom": 2.0}, cameras={"weeder-07/front": zoom})
    theatre.play("manual")
    page = look("/operate/weeder-07")
    page.get_by_test_id("view-camera").click()
    expect(page.get_by_test_id("pip")).to_have_attribute("data-state", SHOWN)
    expect(page.get_by_test_id("camera-lamp")).to_have_attribute("aria-pressed", "true")
    page.get_by_test_id("camera-zoom-in").click()
    expect(page.get_by_test_id("toast")).to_contain_text("Zoom 3.0 ×")
    page.get_by_test_id("camera-lamp").click()
    expect(page.get_by_test_id("camera-lamp")).to_have_attribute("aria-pressed", "false")


@pytest.mark.long
def test_what_a_triggered_camera_takes_is_kept(look: Look, theatre: Theatre, cameras: Callable[..., None]) -> None:
    cameras(cameras={"weeder-07/front": {"has_trigger": True}})
    theatre.play("manual")
    page = look("/operate/weeder-07")
    page.get_by_test_id("view-camera").click()
    page.get_by_test_id("camera-trigger").click()
    expect(page.get_by_test_id("toast").filter(has_text="It is under Cameras, Pictures.")).to_be_visible()


def test_the_whole_rail_of_an_admin_is_seen_on_a_tablet(look: Look, cameras: Callable[..., None]) -> None:
    page = look("/cameras", role="admin")
    expect(page.get_by_test_id("nav-admin")).to_be_visible()
    assert covers(page, "[data-nav=admin]", ".h-rail") == 0
