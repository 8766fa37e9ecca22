"""The maps screen as it is looked at: states, layers, sizes, and one drag on the real surface."""

from __future__ import annotations

import pytest
from playwright.sync_api import Browser, expect

from tests.hmi.pages.conftest import TABLETS, Theatre
from tests.hmi.pages.maps_screen import Show, choose, editing
from tests.hmi.pages.maps_screen import show as show

pytestmark = pytest.mark.browser


def test_nothing_is_exported_before_the_map_is_there(show: Show) -> None:
    page = show()
    expect(page.get_by_test_id("editor-export")).to_be_enabled()
    made = "() => { const bar = new HL.maps.Bar({}, {}); return [bar.exportButton.disabled, bar.versions.disabled]; }"
    assert page.evaluate(made) == [True, True], "a bar that was told of no map yet"


def test_the_published_map_is_shown_read_only_until_somebody_edits(show: Show) -> None:
    page = show()
    expect(page.get_by_test_id("map-editor")).to_have_attribute("data-features", "8")
    assert page.evaluate("surface.options.readOnly") is True
    expect(page.get_by_test_id("editor-tool-parcel")).to_have_attribute("aria-disabled", "true")
    editing(page)
    assert page.evaluate("surface.options.readOnly") is False
    expect(page.get_by_test_id("editor-lock")).to_contain_text("Only you can edit until ")
    expect(page.get_by_test_id("editor-tool-parcel")).not_to_have_attribute("aria-disabled", "true")


@pytest.mark.long
def test_a_viewer_only_looks(show: Show) -> None:
    page = show(role="viewer")
    expect(page.get_by_test_id("editor-reason")).to_have_text("You cannot publish maps. Needs the planner role.")
    for hook in ("editor-edit", "editor-publish", "editor-undo", "editor-import", "editor-discard"):
        expect(page.get_by_test_id(hook)).not_to_be_visible()
    page.get_by_test_id("feature-row-nordfeld").click()
    expect(page.get_by_test_id("feature-crop")).to_have_value("Sugar beet")
    expect(page.get_by_test_id("feature-crop")).to_be_disabled()
    expect(page.get_by_test_id("feature-delete")).to_be_disabled()


@pytest.mark.long
def test_hidden_layers_are_not_drawn_and_stay_hidden(show: Show) -> None:
    page = show(role="viewer")
    expect(page.get_by_test_id("map-editor")).to_have_attribute("data-features", "8")
    page.get_by_test_id("editor-layers").click()
    page.get_by_test_id("editor-layer-roads").uncheck()
    expect(page.get_by_test_id("map-editor")).to_have_attribute("data-features", "5")
    page.reload()
    expect(page.get_by_test_id("map-editor")).to_have_attribute("data-features", "5")


@pytest.mark.long
def test_an_empty_map_says_how_to_begin(show: Show) -> None:
    page = show(is_empty=True)
    expect(page.get_by_test_id("maps-empty")).to_contain_text("Draw a field, walk its edge, or import")
    page.get_by_test_id("empty-draw").click()
    expect(page.get_by_test_id("map-editor")).to_have_attribute("data-tool", "parcel")
    expect(page.get_by_test_id("maps-empty")).to_have_count(0)


def test_an_empty_map_goes_to_where_the_tablet_is_or_says_why_not(show: Show) -> None:
    page = show(is_empty=True, is_new=True)
    page.context.grant_permissions([])
    page.get_by_test_id("empty-here").click()
    expect(page.locator(".h-toast")).to_contain_text("This tablet may not tell its position. Allow it")
    page.context.grant_permissions(["geolocation"])
    page.context.set_geolocation({"latitude": 52.1, "longitude": 5.3})
    page.get_by_test_id("empty-here").click()
    page.wait_for_function("surface.fitted?.[0]?.geometry")
    (west, south), (east, north) = page.evaluate("surface.fitted[0].geometry.coordinates")
    assert west < 5.3 < east
    assert south < 52.1 < north
    assert east - west < 0.01


@pytest.mark.long
def test_an_error_gives_a_way_to_try_again(show: Show, theatre: Theatre) -> None:
    page = show(is_down=True)
    expect(page.get_by_test_id("maps-error")).to_contain_text("Map did not load")
    theatre.play_map(is_down=False)
    page.get_by_test_id("maps-error").get_by_text("Try again").click()
    expect(page.get_by_test_id("map-editor")).to_have_attribute("data-features", "8")
    theatre.play_map(is_down=True)
    page.reload()
    expect(page.get_by_test_id("maps-error")).to_contain_text("Showing v14 from this tablet.")
    expect(page.get_by_test_id("map-editor")).to_have_attribute("data-features", "8")


@pytest.mark.long
def test_a_slow_map_says_that_it_is_loading(show: Show) -> None:
    page = show(slow_s=1.5)
    expect(page.get_by_test_id("maps-loading")).to_contain_text("Loading map")
    expect(page.get_by_test_id("map-editor")).to_have_attribute("data-features", "8")


def test_hostile_names_stay_text(show: Show) -> None:
    name = "<img src=x onerror=alert(1)>"
    page = editing(show(rename={"nordfeld": name}))
    expect(page.get_by_test_id("feature-row-nordfeld")).to_contain_text(name)
    expect(page.locator("hl-maps img")).to_have_count(0)


REACH = """() => [...document.querySelectorAll('hl-maps button, hl-maps input, hl-maps select, hl-maps a')]
  .filter((one) => one.checkVisibility() && one.closest('.m-side') === null).map((one) => {
    const box = one.getBoundingClientRect();
    const isInside = box.left >= 0 && box.right <= innerWidth && box.bottom <= innerHeight;
    return [one.dataset.testid ?? one.textContent, isInside, Math.round(box.height)];
  })"""


@pytest.mark.parametrize("size", TABLETS)
def test_everything_is_in_reach_and_nothing_scrolls_sideways(show: Show, size: str) -> None:
    page = editing(show(size=size, rename={"hangacker": "Hangacker crossed"}))
    choose(page, "nordfeld")
    expect(page.get_by_test_id("finding-crosses")).to_be_attached()
    sides = "[...document.querySelectorAll('.m-side, .m-bar, .m-tools, .m-dock')]"
    for theme in ("day", "sunlight"):
        page.evaluate(f"HL.preferences.set('theme', '{theme}')")
        for name, is_inside, height in page.evaluate(REACH):
            assert is_inside, (theme, name)
            assert height >= 46, (theme, name)
        assert page.evaluate("document.scrollingElement.scrollWidth <= innerWidth")
        assert page.evaluate(f"{sides}.map((one) => one.scrollWidth - one.clientWidth)") == [0, 0, 0, 0]
    page.get_by_test_id("editor-export").click()
    menu, dock = page.locator(".m-exports").bounding_box(), page.locator(".h-dock").bounding_box()
    assert menu is not None
    assert dock is not None
    assert menu["y"] + menu["height"] <= dock["y"]
    map_box, side_box = page.locator(".m-map").bounding_box(), page.locator(".m-side").bounding_box()
    assert map_box is not None
    assert side_box is not None
    assert side_box["y"] > map_box["y"] if size == "portrait" else side_box["x"] > map_box["x"]
    assert map_box["width"] * map_box["height"] > 280_000


@pytest.mark.long
def test_a_corner_is_dragged_on_the_real_surface(browser: Browser, theatre: Theatre) -> None:
    """With WebGL: the surface that draws, in the screen that saves."""
    theatre.play("running")
    theatre.play_map(anew=True)
    context = browser.new_context(viewport={"width": 1280, "height": 800}, base_url=theatre.url)
    context.add_cookies([{"name": "stage", "value": "planner", "url": theatre.url}])
    page = context.new_page()
    page.goto("/maps")
    editing(page)
    page.evaluate("document.querySelector('hl-maps').show(['nordfeld'])")
    expect(page.get_by_test_id("feature-name")).to_have_value("Nordfeld 12")
    spot = """() => {
      const { editor, client } = document.querySelector('hl-maps');
      const box = editor.host.getBoundingClientRect();
      const [x, y] = editor.project(client.features.get('nordfeld').geometry.coordinates[0][1]);
      return [box.left + x, box.top + y];
    }"""
    x, y = page.evaluate(spot)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 12, y + 9, steps=4)
    page.mouse.move(x + 25, y + 18, steps=4)
    page.mouse.up()
    expect(page.get_by_test_id("editor-changes").locator("li[data-state=saved]")).to_contain_text("moved")
    expect(page.get_by_test_id("feature-corner")).to_be_visible()
    before = theatre.heard_map()["published"]["nordfeld"]["geometry"]["coordinates"][0]
    after = theatre.heard_map()["draft"]["nordfeld"]["geometry"]["coordinates"][0]
    assert [a == b for a, b in zip(before, after, strict=True)].count(False) == 1
    context.close()
