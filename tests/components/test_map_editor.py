"""The drawing surface of the map builder in Chromium: what a planner draws, and what leaves the surface for it."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, ViewportSize, expect

from tests.components.editor_page import EditorPage, at_m, crowd, feature, ring
from tests.components.map_server import STATIC, MapServer
from tests.components.screen_pixels import Pixels, is_close

# one by one in `make test-long`; `make test` draws on the real surface in tests/e2e/test_map.py and test_maps.py
pytestmark = [pytest.mark.browser, pytest.mark.long]

CODE = STATIC / "js" / "editor"
LANDSCAPE: ViewportSize = {"width": 1280, "height": 800}
PORTRAIT: ViewportSize = {"width": 800, "height": 1280}
SIZES = [LANDSCAPE, PORTRAIT]
MOST_LINES = 400

FIELD = feature(
    "parcel-north",
    "parcel",
    "Polygon",
    [ring((0, 0), (100, 0), (100, 80), (0, 80)), ring((60, 40), (60, 52), (72, 52), (72, 40))],
    title="Nordfeld 12",
    row_bearing_deg=11.5,
    headland_m=3.5,
    row_spacing_m=0.45,
    seeded="2026-04-09",
)
NEIGHBOUR = feature("parcel-east", "parcel", "Polygon", [ring((130, 0), (200, 0), (200, 90), (130, 90))], title="Ost 3")
ROAD = feature("road-south", "road", "LineString", [(-20, -15), (220, -15)], width_m=4)
HOME = feature("home-1", "home", "Point", (-30, 20), title="Hof", type="home")
FARM = feature("farm-1", "farm", "Polygon", [ring((-60, -40), (240, -40), (240, 120), (-60, 120))])
DRAFT = [FARM, FIELD, NEIGHBOUR, ROAD, HOME]


@pytest.fixture(scope="module")
def server() -> Iterator[MapServer]:
    running = MapServer()
    yield running
    running.close()


@pytest.fixture
def surface(page: Page, server: MapServer) -> Iterator[EditorPage]:
    page.set_viewport_size(LANDSCAPE)
    opened = EditorPage(page, server)
    yield opened
    assert opened.problems == []


@pytest.fixture(params=SIZES, ids=["landscape", "portrait"])
def tablet(browser: Browser, server: MapServer, request: pytest.FixtureRequest) -> Iterator[EditorPage]:
    context = browser.new_context(viewport=request.param, has_touch=True)
    opened = EditorPage(context.new_page(), server)
    yield opened
    assert opened.problems == []
    context.close()


def grab_field(surface: EditorPage, **options: Any) -> None:
    """Open the draft with the field selected and in view."""
    surface.open(DRAFT, **options)
    surface.call("editor.select(['parcel-north']); editor.fit(['parcel-north', 'parcel-east'])")
    surface.settle()


def only_change(surface: EditorPage) -> dict[str, Any]:
    """Return the one change of the one gesture."""
    [made] = surface.heard("change")
    [change] = made["changes"]
    return {"label": made["label"], **change}


def outer(change: dict[str, Any], of: int = 0) -> list[list[float]]:
    """Return a ring of what the feature became."""
    found: list[list[float]] = change["after"]["geometry"]["coordinates"][of]
    return found


def turn(shape: list[list[float]]) -> float:
    """Return above 0 for a ring that runs counter-clockwise."""
    return sum(
        (a[0] - shape[0][0]) * (b[1] - shape[0][1]) - (b[0] - shape[0][0]) * (a[1] - shape[0][1])
        for a, b in pairwise(shape)
    )


def test_a_parcel_is_drawn_with_taps_and_closed_on_its_first_corner(tablet: EditorPage) -> None:
    tablet.open(DRAFT)
    tablet.call("editor.setSnap(false); editor.setTool('parcel')")
    for corner in ((10, 20), (12, 70), (80, 65), (70, 18)):  # clockwise
        tablet.tap(*corner)
    assert tablet.heard("change") == []
    tablet.tap(10, 20)
    change = only_change(tablet)
    assert re.fullmatch(r"parcel-[0-9a-f]{8}", change["id"])
    assert (change["label"], change["before"]) == ("Parcel drawn", None)
    assert change["after"]["properties"] == {"id": change["id"], "kind": "parcel", "name": "Parcel 1"}
    shape = outer(change)
    assert len(shape) == 5
    assert shape[0] == shape[-1]
    assert turn(shape) > 0
    assert all(value == round(value, 8) for position in shape for value in position)
    assert tablet.heard("drawn") == [change["after"]]
    assert tablet.call("return editor.selected") == [change["id"]]
    for corner in ((10, 20), (12, 70), (80, 65), (70, 18)):
        assert min(math.dist(at_m(*corner), place) for place in shape) < 1e-5


def test_a_finger_that_drags_while_drawing_sets_the_corner_under_the_glass_and_two_fingers_move_the_map(
    tablet: EditorPage,
) -> None:
    tablet.open(DRAFT)
    tablet.call("editor.setTool('parcel')")
    x, y = tablet.px(30, 60)
    glass = tablet.page.get_by_test_id("edit-loupe")
    tablet.touch("touchStart", (x - 40, y + 40))
    for i in range(1, 5):
        tablet.touch("touchMove", (x - 40 + 10 * i, y + 40 - 10 * i))
    expect(glass).to_be_visible()
    tablet.touch("touchEnd")
    expect(glass).to_be_hidden()
    assert tablet.call("return editor.bench.pen.points.length") == 1
    before = tablet.place(at_m(30, 60))
    tablet.touch("touchStart", (x, y))
    tablet.touch("touchStart", (x, y), (x + 80, y))
    for i in range(1, 9):
        tablet.touch("touchMove", (x + 6 * i, y + 6 * i), (x + 80 + 6 * i, y + 6 * i))
    tablet.touch("touchEnd")
    tablet.settle()
    after = tablet.place(at_m(30, 60))
    assert math.dist(before, after) > 20
    assert tablet.call("return editor.bench.pen.points.length") == 1


def test_a_corner_dragged_by_touch_moves_once_under_a_glass(tablet: EditorPage) -> None:
    grab_field(tablet)
    tablet.call("editor.setSnap(false)")
    x, y = tablet.px(100, 80)
    tablet.touch("touchStart", (x + 14, y - 10))  # 24 px beside the middle still is the corner
    for i in range(1, 6):
        tablet.touch("touchMove", (x + 14 + 4 * i, y - 10 - 6 * i))
    expect(tablet.page.get_by_test_id("edit-loupe")).to_be_visible()
    assert tablet.heard("change") == []
    tablet.touch("touchEnd")
    change = only_change(tablet)
    assert change["before"] == FIELD
    assert re.fullmatch(r"Corner 3 moved \d+\.\d m", change["label"])
    assert outer(change)[2] != FIELD["geometry"]["coordinates"][0][2]
    assert outer(change)[1] == FIELD["geometry"]["coordinates"][0][1]
    assert outer(change, 1) == FIELD["geometry"]["coordinates"][1]
    assert change["after"]["properties"] == FIELD["properties"]


def test_a_dragged_corner_snaps_to_a_neighbours_corner_and_in_line_with_its_own_edge(surface: EditorPage) -> None:
    grab_field(surface)
    x, y = surface.px(130, 90)
    surface.drag(surface.px(100, 80), (x - 6, y + 5))
    change = only_change(surface)
    assert outer(change)[2] == at_m(130, 90)
    surface.call("editor.patch([{ id: it.id, before: it.after, after: it.before }])", change)
    surface.settle()
    x, y = surface.px(112, 80)
    surface.drag(surface.px(100, 80), (x, y - 7))
    label = surface.heard("change")[1]
    east, north = outer(label["changes"][0])[2]
    assert north == pytest.approx(at_m(0, 80)[1], abs=2e-8)
    assert east == pytest.approx(at_m(112, 0)[0], abs=2e-6)
    assert label["label"].startswith("Corner 3 moved 12.")


def test_without_snapping_a_corner_goes_where_the_mouse_goes(surface: EditorPage) -> None:
    grab_field(surface)
    surface.call("editor.setSnap(false)")
    x, y = surface.px(130, 90)
    surface.drag(surface.px(100, 80), (x - 6, y + 5))
    assert outer(only_change(surface))[2] != at_m(130, 90)


def test_a_mid_handle_adds_a_corner_and_del_removes_it(surface: EditorPage) -> None:
    grab_field(surface)
    surface.drag(surface.px(25, 0), surface.px(25, -8))
    made = only_change(surface)
    assert made["label"] == "Corner 2 added"
    assert len(outer(made)) == 6
    surface.page.keyboard.press("Delete")
    removed = surface.heard("change")[1]
    assert removed["label"] == "Corner 2 removed"
    assert removed["changes"][0]["before"] == made["after"]
    assert removed["changes"][0]["after"] == FIELD


def test_a_hole_keeps_three_corners(surface: EditorPage) -> None:
    hole = [ring((0, 0), (60, 0), (60, 60), (0, 60)), ring((20, 20), (20, 40), (40, 20))]
    surface.open([feature("parcel-1", "parcel", "Polygon", hole)])
    surface.call("editor.select(['parcel-1'])")
    surface.settle()
    surface.click(20, 40)
    assert surface.call("return editor.vertex.name") == "Corner 2 of hole 1"
    surface.call("editor.removeVertex()")
    assert surface.heard("change") == []
    assert surface.heard("notice") == ["A hole needs three corners. Remove the hole instead."]


def test_arrow_keys_nudge_the_chosen_corner_and_a_held_key_is_one_change(surface: EditorPage) -> None:
    grab_field(surface)
    surface.click(100, 0)
    keyboard = surface.page.keyboard
    for _ in range(3):
        keyboard.down("ArrowRight")
    keyboard.up("ArrowRight")
    change = only_change(surface)
    assert change["label"] == "Corner 2 moved 30 cm"
    assert outer(change)[1] == pytest.approx(at_m(100.3, 0), abs=1.1e-8)
    keyboard.press("Shift+ArrowUp")
    surface.call("editor.nudge(-0.3, -1)")
    assert outer(surface.heard("change")[2]["changes"][0])[1] == pytest.approx(at_m(100, 0), abs=2.1e-8)
    surface.call("editor.setVertex(it)", at_m(101, -1))
    assert outer(surface.heard("change")[3]["changes"][0])[1] == at_m(101, -1)


def test_a_shape_stays_where_it_is_until_it_is_unlocked(surface: EditorPage) -> None:
    grab_field(surface)
    surface.drag(surface.px(20, 60), surface.px(26, 60))
    assert surface.heard("change") == []
    surface.call("editor.fit(['parcel-north', 'parcel-east']); editor.unlockBody(true)")
    surface.settle()
    surface.drag(surface.px(20, 60), surface.px(26, 60))
    change = only_change(surface)
    assert change["label"] == "Nordfeld 12 moved 6.0 m"
    assert outer(change)[0] == pytest.approx(at_m(6, 0), abs=3e-7)


def test_holes_and_cuts_are_asked_for_and_not_made(surface: EditorPage) -> None:
    surface.open(DRAFT)
    surface.call("editor.setSnap(false); editor.setTool('hole')")
    for corner in ((20, 20), (30, 20), (30, 30)):
        surface.click(*corner)
    surface.page.keyboard.press("Enter")
    surface.call("editor.setTool('split')")
    surface.click(50, -10)
    surface.click(50, 95)
    surface.page.keyboard.press("Enter")
    hole, cut = surface.heard("drawn")
    assert (hole["tool"], hole["target"], len(hole["coordinates"])) == ("hole", "parcel-north", 4)
    assert turn(hole["coordinates"]) < 0
    assert (cut["tool"], cut["target"], len(cut["coordinates"])) == ("split", "parcel-north", 2)
    assert surface.heard("change") == []


def test_enter_needs_enough_corners_backspace_takes_one_back_and_escape_gives_up(surface: EditorPage) -> None:
    surface.open(DRAFT)
    surface.call("editor.setTool('no-go')")
    surface.click(10, 10)
    surface.click(30, 10)
    surface.page.keyboard.press("Enter")
    assert surface.heard("notice") == ["A keep-out zone needs three corners."]
    surface.page.keyboard.press("Backspace")
    assert surface.call("return editor.bench.pen.points.length") == 1
    assert surface.call("return [editor.undoPoint(), editor.undoPoint()]") == [True, False]
    surface.click(10, 10)
    surface.page.keyboard.press("Escape")
    assert surface.call("return editor.bench.pen.points.length") == 0
    assert surface.heard("change") == []


def test_roads_homes_and_row_lines_are_features_of_their_own(surface: EditorPage) -> None:
    surface.open(DRAFT)
    surface.call("editor.setTool('home')")
    surface.click(-40, 60)
    surface.call("editor.setTool('rows'); editor.setSnap(false)")
    surface.click(20, 10)
    surface.click(30, 70)  # an A-B line is done at its second point
    home, rows = surface.heard("drawn")
    assert (home["geometry"]["type"], home["properties"]["type"]) == ("Point", "home")
    assert rows["properties"]["parcel_id"] == "parcel-north"
    assert rows["properties"]["type"] == "a-b"
    assert [made["changes"][0]["before"] for made in surface.heard("change")] == [None, None]


def test_a_drawing_in_hand_outlives_an_answer_of_the_server_and_says_when_it_is_enough(surface: EditorPage) -> None:
    surface.open(DRAFT)
    surface.call("editor.setSnap(false); editor.setTool('road')")
    surface.click(-20, 100)
    assert surface.call("return editor.canFinish") is False
    surface.click(20, 100)
    after = {**FIELD, "properties": {**FIELD["properties"], "crop": "beet"}}
    surface.call("editor.patch([{ id: 'parcel-north', before: null, after: it }])", after)
    surface.call("editor.setFeatures(it)", [after, *DRAFT[2:]])
    surface.call("editor.select(['parcel-north'])")
    assert surface.call("return editor.canFinish") is True
    surface.click(60, 110)
    surface.call("editor.finish()")
    [road] = surface.heard("drawn")
    assert len(road["geometry"]["coordinates"]) == 3
    assert surface.call("return editor.canFinish") is False


def test_what_is_not_in_the_draft_is_shown_where_it_was(surface: EditorPage) -> None:
    surface.open(DRAFT)
    gone = feature("well", "obstacle", "Point", (400, 300), radius_m=2)
    surface.call("editor.setTrial([it]); editor.fit([it])", gone)
    surface.settle()
    x, y = surface.px(400, 300)
    assert 400 < x < 880
    assert 250 < y < 550
    assert surface.call("return editor.bench.draft.get('well')") is None


def test_measuring_says_lengths_and_changes_nothing(surface: EditorPage) -> None:
    surface.open(DRAFT)
    surface.call("editor.setSnap(false); editor.setTool('measure')")
    for corner in ((0, 0), (100, 0), (100, 80)):
        surface.click(*corner)
    surface.page.keyboard.press("Enter")
    length = float(surface.heard("measure")[-1].removesuffix(" m"))
    assert length == pytest.approx(180, abs=0.6)  # the mouse sets whole pixels
    assert surface.call("return editor.bench.pen.points.length") == 0
    assert surface.heard("change") == []


def test_the_dial_turns_rows_by_half_degrees(surface: EditorPage) -> None:
    surface.open(DRAFT)
    surface.call("editor.select(['parcel-north']); editor.fit(['parcel-north'])")
    surface.settle()
    dial = surface.call("const { cx, cy, radius, kx, ky } = editor.bench.dial; return { cx, cy, radius, kx, ky }")
    angle = math.radians(45.1)
    end = (dial["cx"] + dial["radius"] * math.sin(angle), dial["cy"] - dial["radius"] * math.cos(angle))
    surface.drag((dial["kx"], dial["ky"]), end)
    change = only_change(surface)
    assert change["after"]["properties"]["row_bearing_deg"] == 45
    assert change["label"] == "Row direction 11.5° to 45.0°"
    assert change["after"]["geometry"] == FIELD["geometry"]
    surface.page.keyboard.press("ArrowRight")
    surface.page.keyboard.press("ArrowLeft")
    surface.call("editor.setDirection('parcel-north', 9.1)")
    bearings = [made["changes"][0]["after"]["properties"]["row_bearing_deg"] for made in surface.heard("change")]
    assert bearings == [45, 45.5, 45, 9]


def test_a_tap_takes_the_smallest_a_second_one_the_next_and_shift_adds(surface: EditorPage) -> None:
    surface.open(DRAFT)
    surface.click(20, 60)
    surface.click(20, 60)
    surface.click(20, 60)
    surface.click(160, 50, is_shifted=True)
    surface.click(20, 60, is_shifted=True)
    surface.call("editor.several = (one) => one.properties.kind === 'parcel'")
    surface.click(100, -15)  # neither a road nor the farm around it
    surface.call("editor.several = true")
    surface.click(100, -15)
    surface.call("editor.several = false")
    surface.click(-55, 110)
    assert surface.heard("select") == [
        ["parcel-north"],
        ["farm-1"],
        ["parcel-north"],
        ["parcel-north", "parcel-east"],
        ["parcel-east"],
        ["parcel-east"],
        ["parcel-east", "road-south"],
        ["farm-1"],
    ]


def test_a_second_finger_gives_a_drag_up(tablet: EditorPage) -> None:
    grab_field(tablet)
    x, y = tablet.px(100, 80)
    tablet.touch("touchStart", (x, y))
    tablet.touch("touchMove", (x + 30, y))
    tablet.touch("touchStart", (x + 30, y), (x - 100, y + 100))
    tablet.touch("touchEnd")
    tablet.settle()
    assert tablet.heard("change") == []
    assert tablet.call("return editor.bench.inHand[0]") == FIELD


def test_a_new_draft_keeps_selection_and_view_and_a_patch_changes_what_is_held(surface: EditorPage) -> None:
    grab_field(surface)
    place = surface.px(0, 0)
    after = {**FIELD, "properties": {**FIELD["properties"], "crop": "beet"}}
    surface.call("editor.patch([{ id: 'parcel-north', before: null, after: it }])", after)
    surface.call("editor.setFeatures(it)", [after, *DRAFT[2:]])
    surface.settle()
    assert surface.px(0, 0) == place
    assert surface.call("return editor.selected") == ["parcel-north"]
    surface.drag(surface.px(100, 80), surface.px(104, 84))
    assert only_change(surface)["before"] == after
    surface.call("editor.patch([{ id: 'parcel-north', before: null, after: null }])")
    assert surface.call("return editor.selected") == []


def test_somebody_who_may_only_look_selects_and_moves_nothing(surface: EditorPage) -> None:
    grab_field(surface, readOnly=True)
    surface.drag(surface.px(100, 80), surface.px(106, 86))
    surface.call("editor.setTool('parcel'); editor.removeVertex(); editor.nudge(1, 1)")
    surface.call("editor.fit()")
    surface.settle()
    surface.click(160, 50)
    assert surface.heard("select") == [["parcel-east"]]
    assert surface.heard("change") == []
    assert surface.call("return editor.tool") == "select"


def test_findings_stand_at_their_place_and_crossing_edges_are_orange(surface: EditorPage) -> None:
    bow = feature("parcel-bow", "parcel", "Polygon", [ring((0, 0), (60, 60), (60, 0), (0, 60))])
    surface.open([bow])
    finding = {
        "code": "crosses",
        "level": 2,
        "feature_id": "parcel-bow",
        "at": at_m(30, 30),
        "text": "Edge crosses itself.",
    }
    surface.call("editor.setFindings([it])", finding)
    surface.settle()
    pixels = Pixels(surface.page)
    assert is_close(pixels.at(*surface.px(12, 12)), surface.token("--hl-p2"))
    x, y = surface.px(30, 30)
    assert is_close(pixels.at(x - 9, y + 9), surface.token("--hl-p2"))
    surface.click(30, 30)
    assert surface.heard("select") == [["parcel-bow"]]


@pytest.mark.parametrize("theme", ["night", "sunlight"])
def test_the_drawing_follows_the_theme(surface: EditorPage, theme: str) -> None:
    grab_field(surface)
    pixels = Pixels(surface.page)
    assert is_close(pixels.at(*surface.px(100, 80)), surface.token("--hl-raised"))
    surface.call("document.documentElement.dataset.theme = it", theme)
    surface.settle()
    pixels = Pixels(surface.page)
    assert is_close(pixels.at(*surface.px(100, 80)), surface.token("--hl-raised"))
    assert is_close(pixels.at(*surface.px(115, 30)), surface.token("--hl-m-ground"))


def test_a_map_of_10000_corners_is_loaded_and_edited(surface: EditorPage) -> None:
    surface.open(crowd(200, 50))
    surface.call("editor.select(['parcel-00000000']); editor.fit(['parcel-00000000']); editor.setSnap(false)")
    surface.settle()
    surface.drag(surface.px(40, 0), surface.px(46, 3))
    change = only_change(surface)
    assert len(outer(change)) == 51
    assert outer(change)[0] == pytest.approx(at_m(46, 3), abs=5e-6)


def test_without_webgl_the_map_is_shown_and_nothing_can_be_drawn(surface: EditorPage) -> None:
    surface.page.add_init_script(
        """const { getContext } = HTMLCanvasElement.prototype;
        HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
            return kind.startsWith('webgl') ? null : getContext.call(this, kind, ...rest);
        };"""
    )
    surface.open(DRAFT)
    assert surface.heard("notice") == ["Drawing needs WebGL. This device shows the map only."]
    expect(surface.page.get_by_test_id("map-editor")).to_have_attribute("data-engine", "canvas")
    surface.call("editor.setTool('parcel')")
    surface.click(20, 60)
    assert surface.heard("select") == [["parcel-north"]]
    assert surface.heard("change") == []
    pixels = Pixels(surface.page)
    assert is_close(pixels.at(*surface.px(150, 20)), surface.token("--hl-m-parcel"))


def test_after_its_end_nothing_of_the_surface_is_left(surface: EditorPage) -> None:
    surface.open(DRAFT)
    surface.call("editor.destroy()")
    assert surface.page.get_by_test_id("map-editor").evaluate("(host) => host.childElementCount") == 0


def test_the_scripts_stay_small_and_open_no_dialogs_above_stop() -> None:
    for path in [*CODE.glob("*.js"), *CODE.glob("*.css")]:
        text = path.read_text("utf-8")
        assert len(text.splitlines()) < MOST_LINES, path.name
        assert not re.search(r"showModal|showPopover|requestFullscreen|z-index|alert\(|confirm\(", text), path.name
        assert not re.search(r"#[0-9a-f]{3,8}\b(?=[;'\" ])", text), f"{path.name} has a colour of its own"
