"""The rest sheet in a browser: ground drawn with a finger is planned around, and sent only after it was shown."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
import shapely
from playwright.sync_api import Locator, Page, expect

from hmi.domain.mission_rest import Progress, RestWish, pieces_of
from hmi.planning.mission_map import mission_geojson
from hmi.planning.rest import plan_rest
from tests.hmi.missions.rig import FRAME
from tests.hmi.pages.test_missions import PLANNED, Played, mission

Look = Callable[..., Page]
AT = Progress(PLANNED.sha256, 3, 1.0, 1, 6, 100.0, 20.0)


class PlayedRest(Played):
    """REST of one running mission; the rest is really planned."""

    def __init__(self, page: Page) -> None:
        super().__init__(page, [mission("m-1", "running", progress=AT.as_json())])

    rolls_on = 0
    """How many previews come before the robot stands."""

    def reply(self, method: str, path: str) -> tuple[int, Any]:
        """Answer what the sheet asks, else as usual."""
        if path.endswith("/rest/preview") and self.rolls_on:
            self.rolls_on -= 1
            return 409, {"code": "not_standing", "text": "Weeder 07 must stand still first."}
        if path.endswith("/rest/preview"):
            wish = RestWish(base=PLANNED.document, base_sha256=PLANNED.sha256, revision=2, progress=AT)
            made = plan_rest(wish)
            shape = mission_geojson(made.document)
            return 200, {"sha256": made.sha256, **made.difference, "progress": AT.as_json(), "geometry": shape}
        if path.endswith("/rest"):
            return 200, self.rest() if method == "GET" else {"outcome": "accepted", "code": "ok", "text": ""}
        return super().reply(method, path)

    @staticmethod
    def rest() -> dict[str, Any]:
        """Return what is left."""
        pieces = pieces_of(PLANNED.document, AT)
        listed = [
            {"number": one.number, "name": one.name, "kind": one.kind, "row": one.row, "length_m": 9.0,
             "is_present": one.is_present}
            for one in pieces
        ]  # fmt: skip
        return {**mission("m-1", "running"), "progress": AT.as_json(), "pieces": listed, "areas": [], "forgets": ""}


@pytest.fixture
def sheet(look: Look) -> Callable[..., tuple[Page, PlayedRest]]:
    """Open the rest sheet from the mission's detail."""

    def open_sheet(size: str = "landscape") -> tuple[Page, PlayedRest]:
        page = look("/fleet", role="supervisor", size=size)
        played = PlayedRest(page)
        page.get_by_test_id("nav-missions").click()
        if size == "portrait":
            page.get_by_test_id("mission-row-m-1").click()
        page.get_by_test_id("mission-change").click()
        expect(page.get_by_test_id("rest-said")).to_have_attribute("data-state", "ready")
        return page, played

    return open_sheet


def drag_around(page: Page, picture: Locator, size_px: float = 30.0) -> None:
    """Draw a square around the picture's middle without lifting the finger."""
    picture.scroll_into_view_if_needed()
    box = picture.bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    corners = [(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -0.8)]
    page.mouse.move(x - size_px, y - size_px)
    page.mouse.down()
    for dx, dy in corners[1:]:
        page.mouse.move(x + dx * size_px, y + dy * size_px, steps=6)
    page.mouse.up()


def test_an_obstacle_drawn_with_a_finger_is_planned_around_and_then_sent(
    sheet: Callable[..., tuple[Page, PlayedRest]],
) -> None:
    page, played = sheet()
    page.get_by_test_id("rest-draw-obstacle").click()
    drag_around(page, page.get_by_test_id("rest-map"))
    expect(page.get_by_test_id("rest-area-0")).to_contain_text("Obstacle 1")
    expect(page.get_by_test_id("rest-send")).to_be_disabled()
    page.get_by_test_id("rest-clear-0").select_option("2")
    expect(page.get_by_test_id("rest-said")).to_have_attribute("data-state", "ready")
    (area,) = played.asked[-1][2]["areas"]
    assert (area["kind"], area["clearance_m"]) == ("obstacle", 2)
    outline = FRAME.to_local(area["outline"])
    field = FRAME.to_local(PLANNED.document["parcel"][0])
    assert shapely.Polygon(field).contains(shapely.Polygon(outline))
    assert len(outline) == pytest.approx(4, abs=2)
    page.get_by_test_id("rest-send").click()
    expect(page.get_by_test_id("toast")).to_contain_text("read the new rest back")


HERE = """() => {
  const root = document.querySelector('[data-testid=rest-map] svg');
  const here = root.querySelector('[data-testid=picture-here]');
  const [, x, y] = here.getAttribute('transform').match(/translate\\((\\S+) (\\S+)\\)/).map(Number);
  return { at: root.frame.unflat([x, y]), done: root.querySelector('.done').getAttribute('d').match(/M/g).length };
}"""


def test_the_picture_of_the_rest_shows_what_is_done_and_where_the_robot_was(
    sheet: Callable[..., tuple[Page, PlayedRest]],
) -> None:
    page, _ = sheet()
    path = shapely.LineString(PLANNED.document["segments"][AT.segment]["points"])
    shown = page.evaluate(HERE)
    (at,) = FRAME.to_local([shown["at"]])
    assert path.interpolate(AT.segment_s_m).distance(shapely.Point(at)) < 0.05
    worked = [one for one in PLANNED.document["segments"][: AT.segment + 1] if one["kind"] in ("row", "headland")]
    assert shown["done"] == sum(one["tool_on"] for one in worked)
    expect(page.get_by_test_id("rest-legend")).to_have_text(
        "Grey is done. The arrow is where Weeder 07 was when this was planned."
    )


def test_resume_later_shows_what_was_drawn_and_offers_no_change_of_it(
    sheet: Callable[..., tuple[Page, PlayedRest]], monkeypatch: pytest.MonkeyPatch
) -> None:
    page, played = sheet()
    page.keyboard.press("Escape")
    outline = [[9.4, 53.4], [9.41, 53.4], [9.41, 53.41]]
    rest = {**PlayedRest.rest(), "areas": [{"kind": "obstacle", "outline": outline, "clearance_m": 1}]}
    monkeypatch.setattr(played, "rest", lambda: rest)
    page.evaluate("HL.rest.later({ id: 'm-1', name: 'Nordfeld 12', robot_id: 'weeder-07' })")
    expect(page.get_by_test_id("rest-said")).to_have_attribute("data-state", "ready")
    expect(page.get_by_test_id("rest-legend")).to_have_text("Grey is done. The arrow is where it goes on.")
    expect(page.get_by_test_id("rest-area-0")).to_be_attached()
    expect(page.get_by_test_id("rest-area-0")).to_be_hidden()


@pytest.mark.long
def test_a_robot_that_rolls_out_is_waited_for(sheet: Callable[..., tuple[Page, PlayedRest]]) -> None:
    page, played = sheet()
    played.rolls_on = 2
    page.get_by_test_id("rest-order").select_option("turned")
    expect(page.get_by_test_id("rest-said")).to_have_text(
        "Weeder 07 must stand still first. It is planned as soon as it stands."
    )
    expect(page.get_by_test_id("rest-said")).to_have_attribute("data-state", "ready")
    expect(page.get_by_test_id("rest-send")).to_be_enabled()


@pytest.mark.long
def test_corners_are_tapped_one_taken_back_and_an_area_taken_away(
    sheet: Callable[..., tuple[Page, PlayedRest]],
) -> None:
    page, _ = sheet("portrait")
    page.get_by_test_id("rest-draw-area").click()
    picture = page.get_by_test_id("rest-map")
    picture.scroll_into_view_if_needed()
    box = picture.bounding_box()
    assert box is not None
    middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    for dx, dy in ((-60, -60), (60, -60), (60, 30), (0, 90)):
        page.mouse.click(middle[0] + dx, middle[1] + dy)
    page.get_by_test_id("area-undo").click()
    page.get_by_test_id("area-done").click()
    expect(page.get_by_test_id("rest-area-0")).to_have_attribute("data-state", "leave_out")
    page.get_by_test_id("rest-area-remove-0").click()
    expect(page.get_by_test_id("rest-area-0")).to_have_count(0)


@pytest.mark.long
def test_the_arrow_keys_draw_too(sheet: Callable[..., tuple[Page, PlayedRest]]) -> None:
    page, _ = sheet()
    page.get_by_test_id("rest-draw-area").click()
    for keys in (["Enter"], ["ArrowRight"] * 4 + ["Enter"], ["ArrowDown"] * 4 + ["Enter"]):
        for key in keys:
            page.keyboard.press(key)
    page.get_by_test_id("area-done").click()
    expect(page.get_by_test_id("rest-area-0")).to_be_visible()
