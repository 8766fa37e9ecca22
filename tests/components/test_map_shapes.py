"""Round obstacles, headings, previews and row directions on the drawing surface in Chromium."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import pytest
from playwright.sync_api import Browser, Page

from tests.components.editor_page import EditorPage, at_m, crowd, feature, ring
from tests.components.map_server import MapServer

# drawn on the real surface, one by one in `make test-long`
pytestmark = [pytest.mark.browser, pytest.mark.long]

FIELD = feature(
    "parcel-north",
    "parcel",
    "Polygon",
    [ring((0, 0), (100, 0), (100, 80), (0, 80))],
    title="Nordfeld 12",
    row_bearing_deg=11.5,
)
EAST = feature(
    "parcel-east", "parcel", "Polygon", [ring((110, 0), (190, 0), (190, 80), (110, 80))], row_bearing_deg=80.0
)
BARE = feature("parcel-bare", "parcel", "Polygon", [ring((0, 90), (100, 90), (100, 150), (0, 150))])
HOME = feature("home-1", "home", "Point", (50, 40), title="Hof", type="home")


@pytest.fixture(scope="module")
def server() -> Iterator[MapServer]:
    running = MapServer()
    yield running
    running.close()


@pytest.fixture
def surface(page: Page, server: MapServer) -> Iterator[EditorPage]:
    page.set_viewport_size({"width": 1280, "height": 800})
    opened = EditorPage(page, server)
    yield opened
    assert opened.problems == []


@pytest.fixture
def tablet(browser: Browser, server: MapServer) -> Iterator[EditorPage]:
    context = browser.new_context(viewport={"width": 1280, "height": 800}, has_touch=True)
    opened = EditorPage(context.new_page(), server)
    yield opened
    assert opened.problems == []
    context.close()


def made(surface: EditorPage) -> dict[str, Any]:
    """Return the one feature that was drawn."""
    [heard] = surface.heard("change")
    [change] = heard["changes"]
    assert change["before"] is None
    after: dict[str, Any] = change["after"]
    return after


def test_a_finger_draws_a_round_obstacle_from_its_middle_to_its_edge(tablet: EditorPage) -> None:
    tablet.open([FIELD])
    tablet.call("editor.setTool('circle')")
    (x, y), (ex, ey) = tablet.px(30, 30), tablet.px(42, 30)
    tablet.touch("touchStart", (x, y))
    for i in range(1, 7):
        tablet.touch("touchMove", (x + (ex - x) * i / 6, y + (ey - y) * i / 6))
    tablet.touch("touchEnd")
    pylon = made(tablet)
    assert pylon["properties"]["kind"] == "obstacle"
    assert pylon["properties"]["radius_m"] == pytest.approx(12, abs=0.3)
    assert math.dist(pylon["geometry"]["coordinates"], at_m(30, 30)) < 1e-5


def test_a_tapped_middle_takes_a_second_tap_or_a_typed_radius(tablet: EditorPage) -> None:
    tablet.open([FIELD])
    tablet.call("editor.setTool('circle')")
    assert tablet.call("return editor.setRadius(3)") is False
    tablet.tap(30, 30)
    assert tablet.heard("change") == []
    assert tablet.call("return editor.setRadius(3.5)") is True
    assert made(tablet)["properties"]["radius_m"] == 3.5


def test_a_second_finger_while_a_circle_is_drawn_draws_nothing(tablet: EditorPage) -> None:
    tablet.open([FIELD])
    tablet.call("editor.setTool('circle')")
    x, y = tablet.px(30, 30)
    tablet.touch("touchStart", (x, y))
    tablet.touch("touchMove", (x + 30, y))
    tablet.touch("touchStart", (x + 30, y), (x - 100, y + 100))
    tablet.touch("touchEnd")
    tablet.settle()
    assert tablet.heard("change") == []
    assert tablet.call("return editor.bench.pen.points.length") == 0


@pytest.mark.parametrize(
    ("pen", "told"),
    [
        ("garage", {"kind": "home", "type": "garage"}),
        ("charging", {"kind": "home", "type": "charging"}),
        ("gate", {"kind": "gate", "width_m": 4}),
    ],
)
def test_places_are_set_with_one_tap(tablet: EditorPage, pen: str, told: dict[str, Any]) -> None:
    tablet.open([FIELD])
    tablet.call(f"editor.setTool('{pen}')")
    tablet.tap(20, 20)
    place = made(tablet)
    assert place["geometry"]["type"] == "Point"
    assert place["properties"].items() >= told.items()


def test_a_crop_row_that_was_recorded_belongs_to_its_parcel(tablet: EditorPage) -> None:
    tablet.open([FIELD])
    tablet.call("editor.setSnap(false); editor.setTool('recorded')")
    for place in ((20, 10), (22, 40), (20, 70)):
        tablet.tap(*place)
    tablet.call("editor.bench.pen.finish()")
    row = made(tablet)["properties"]
    assert (row["kind"], row["type"], row["parcel_id"]) == ("rows", "recorded", "parcel-north")


def test_a_home_turns_by_its_arrow_and_keeps_the_heading_from_east(surface: EditorPage) -> None:
    surface.open([FIELD, HOME])
    surface.call("editor.select(['home-1']); editor.fit(['parcel-north'])")
    surface.settle()
    dial = surface.call("const { cx, cy, radius } = editor.bench.dial; return { cx, cy, radius }")
    surface.drag((dial["cx"], dial["cy"] - dial["radius"]), (dial["cx"] + dial["radius"], dial["cy"]))
    [heard] = surface.heard("change")
    [change] = heard["changes"]
    assert heard["label"] == "Heading 90.0°"
    assert change["after"]["properties"]["heading_deg"] == 0, "east is 0, as robots count"


def test_a_preview_is_drawn_over_the_shape_and_leaves_it_alone(surface: EditorPage) -> None:
    surface.open([FIELD])
    surface.call("editor.select(['parcel-north']); editor.fit(['parcel-north'])")
    inset = feature("parcel-north", "parcel", "Polygon", [ring((10, 10), (90, 10), (90, 70), (10, 70))])
    surface.call("editor.setTrial([it])", inset)
    surface.settle()
    surface.drag(
        surface.px(100, 80), surface.px(94, 74)
    )  # the first one moves the map: inwards, or it leaves the screen
    assert surface.heard("change") == []
    surface.call("editor.setTrial([])")
    surface.settle()
    surface.drag(surface.px(100, 80), surface.px(94, 74))
    assert len(surface.heard("change")) == 1


def test_the_turning_dial_tells_degrees_and_changes_nothing(surface: EditorPage) -> None:
    surface.open([FIELD])
    surface.call(
        "window.turns = []; editor.say.onTurn = (one) => turns.push(one);"
        "editor.select(['parcel-north']); editor.fit(['parcel-north']); editor.setTurning(0)"
    )
    surface.settle()
    dial = surface.call("const { cx, cy, radius } = editor.bench.dial; return { cx, cy, radius }")
    surface.drag((dial["cx"], dial["cy"] - dial["radius"]), (dial["cx"] - dial["radius"], dial["cy"]))
    assert surface.call("return turns.at(-1)") == -90
    assert surface.heard("change") == []


def test_parcels_that_are_not_in_hand_show_their_rows_where_they_have_a_direction(surface: EditorPage) -> None:
    surface.open([FIELD, EAST, BARE])
    surface.call("editor.fit()")
    surface.page.wait_for_function("Number(editor.host.dataset.strips) > 20")
    both = int(surface.call("return editor.host.dataset.strips"))
    surface.call("editor.select(['parcel-north'])")
    surface.page.wait_for_function("(n) => Number(editor.host.dataset.strips) < n", arg=both)
    assert int(surface.call("return editor.host.dataset.strips")) > 10


def test_a_thousand_parcels_lay_rows_for_what_is_in_view_only(surface: EditorPage) -> None:
    parcels = [{**one, "properties": {**one["properties"], "row_bearing_deg": 30.0}} for one in crowd(1000, 12)]
    surface.open(parcels)
    surface.call("editor.fit([it])", parcels[0]["id"])
    surface.page.wait_for_function("Number(editor.host.dataset.strips) > 0")
    assert int(surface.call("return editor.host.dataset.strips")) <= 5000


def test_the_first_point_is_told_as_well_as_the_last_one_taken_back(surface: EditorPage) -> None:
    surface.open([FIELD])
    surface.call("editor.setSnap(false); editor.setTool('road')")
    assert surface.call("return editor.isDrawing") is False
    surface.click(20, 20)
    assert surface.heard("measure") == [""]
    assert surface.call("return editor.isDrawing") is True
    surface.call("editor.undoPoint()")
    assert surface.heard("measure")[-1] == ""
    assert surface.call("return editor.isDrawing") is False


def test_the_button_shows_one_site_whole_and_pressed_again_the_next(surface: EditorPage) -> None:
    abroad = feature("parcel-abroad", "parcel", "Polygon", [ring((1e6, 0), (1e6, 60), (1e6 + 60, 60), (1e6 + 60, 0))])
    surface.open([FIELD, EAST, BARE, abroad])

    def middle() -> list[float]:
        at = surface.call(
            "const { clientWidth, clientHeight } = editor.host;"
            "return editor.bench.surface.toLonLat([clientWidth / 2, clientHeight / 2])"
        )
        return list(at)

    home = middle()
    assert math.dist(home, at_m(95, 75)) < 0.01, "it begins at the site with the largest parcel"
    surface.call("editor.fit(['parcel-abroad', 'parcel-north', 'parcel-east'])")
    assert math.dist(middle(), at_m(95, 75)) < 0.01, "of what was imported in two places one is seen"
    surface.call("editor.fit(['parcel-north'])")
    button = surface.page.get_by_test_id("map-fit")
    button.click()
    assert middle() == pytest.approx(home), "the site at hand, whole"
    button.click()
    assert math.dist(middle(), at_m(1e6 + 30, 30)) < 0.01
    button.click()
    assert middle() == pytest.approx(home)
