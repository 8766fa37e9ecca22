"""Files in and out of the maps screen, and walking an edge."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import Page, expect

from tests.hmi.pages.conftest import Theatre
from tests.hmi.pages.maps_screen import Show, editing, saved
from tests.hmi.pages.maps_screen import show as show

pytestmark = pytest.mark.browser
WALKED = """({ accuracy_m, missing = [] }) => {
  const { recording } = HL.maps;
  const { lon, lat, at_s } = recording.heard.at(-1);
  const corners = [[0, 0], [0, 1e-3], [5e-4, 1e-3], [1e-3, 1e-3], [1e-3, 0]];
  let seconds = 0;
  corners.slice(1).forEach(([x, y], i) => {
    for (let step = 0; step < 100; step += 1) {
      const [x0, y0] = corners[i];
      const part = (step + 1) / 100;
      seconds += 1;
      if (missing.includes(i) && step && step < 99) continue;
      recording.take({ lon: lon + x0 + (x - x0) * part, lat: lat + y0 + (y - y0) * part, accuracy_m, at_s: at_s + seconds });
    }
  });
  recording.look = () => {};
  recording.heardMs = Date.now() + 3600000;
}"""  # noqa: E501
"""One position a second at about 1 m/s, and none after it; ``missing``: sides of which nothing was heard."""
WAKE_LOCK = """window.locks = []; Object.defineProperty(navigator, 'wakeLock', {value: {request: async () => {
    const lock = new EventTarget(); lock.isOn = true;
    lock.release = async () => { lock.isOn = false; lock.dispatchEvent(new Event('release')); };
    window.locks.push(lock); return lock; }}})"""


def walking(page: Page, missing: tuple[int, ...] = ()) -> None:
    """Begin a walk with the robot and let it go around."""
    page.get_by_test_id("editor-walk").click()
    page.get_by_test_id("walk-start").click()
    expect(page.get_by_test_id("walk")).to_have_attribute("data-value", "1")
    page.evaluate(WALKED, {"accuracy_m": 0.014, "missing": missing})
    expect(page.get_by_test_id("walk-finish")).to_be_enabled()


def test_an_import_is_looked_through_before_it_is_taken(show: Show, theatre: Theatre) -> None:
    page = show()
    with page.expect_file_chooser() as chooser:
        page.get_by_test_id("editor-import").click()
    chooser.value.set_files({"name": "nordfeld.geojson", "mimeType": "application/json", "buffer": b"{}" * 400})
    sheet = page.get_by_test_id("import-sheet")
    expect(sheet.get_by_test_id("import-take")).to_have_text("Take 5 of 8")
    expect(sheet).to_contain_text("It overlaps Hangacker 5 by 14 m².")
    expect(sheet.get_by_test_id("import-skipped")).to_have_text("Import skipped 2 of 8 shapes")
    expect(sheet).to_contain_text("Draw it again in the program it is from.")
    sheet.get_by_test_id("import-item-5").check()
    sheet.get_by_test_id("import-kind-0").select_option("no-go")
    sheet.get_by_test_id("import-take").click()
    expect(sheet).not_to_be_visible()
    heard = saved(page, theatre, "Imported 6 shapes")
    assert heard["draft"]["new-0"]["properties"]["kind"] == "no-go"
    expect(page.get_by_test_id("map-editor")).to_have_attribute("data-features", "14")


@pytest.mark.long
def test_an_import_that_was_taken_without_an_answer_is_not_offered_again(show: Show, theatre: Theatre) -> None:
    page = show()
    page.route("**/imports/*/take", lambda route: (route.fetch(), route.abort()))
    with page.expect_file_chooser() as chooser:
        page.get_by_test_id("editor-import").click()
    chooser.value.set_files({"name": "nordfeld.geojson", "mimeType": "application/json", "buffer": b"{}" * 400})
    page.get_by_test_id("import-take").click()
    expect(page.get_by_test_id("import-sheet")).not_to_be_visible()
    expect(page.locator("hl-toasts")).to_contain_text("The step whose answer was lost is done.")
    saved(page, theatre, "Imported 5 shapes")
    expect(page.get_by_test_id("map-editor")).to_have_attribute("data-features", "13")


@pytest.mark.long
def test_a_file_dropped_on_the_map_is_imported_and_an_unreadable_one_is_explained(show: Show) -> None:
    page = editing(show())
    drop = """() => {
      const dataTransfer = new DataTransfer();
      dataTransfer.items.add(new File(['x'], 'notes.txt'));
      document.querySelector('.m-map').dispatchEvent(new DragEvent('drop', { dataTransfer, bubbles: true }));
    }"""
    page.evaluate(drop)
    expect(page.get_by_test_id("import-failed")).to_contain_text("notes.txt is no map file.")
    expect(page.get_by_test_id("import-failed")).to_contain_text("Save it as GeoJSON and try again.")


@pytest.mark.long
def test_an_upload_can_be_cancelled(show: Show, theatre: Theatre) -> None:
    page = editing(show())
    theatre.play_map(slow_s=20.0)
    page.get_by_test_id("import-file").set_input_files({"name": "a.kml", "mimeType": "text/xml", "buffer": b"x"})
    page.get_by_test_id("import-progress").get_by_text("Cancel").click()
    expect(page.get_by_test_id("toast")).to_contain_text("Import cancelled")
    expect(page.get_by_test_id("import-progress")).to_have_count(0)


@pytest.mark.long
def test_export_gives_the_draft_and_the_published_map_in_each_format(show: Show) -> None:
    page = editing(show())
    page.get_by_test_id("editor-export").click()
    for of in ("draft", "published"):
        for name in ("geojson", "kml", "kmz", "shapefile", "isoxml", "gpx", "fiware"):
            link = page.get_by_test_id(f"editor-export-{of}-{name}")
            expect(link).to_have_attribute("href", f"/api/v1/map/export?format={name}&of={of}")
    with page.expect_download() as download:
        page.get_by_test_id("editor-export-published-isoxml").click()
    assert download.value.suggested_filename == "farm.isoxml"


@pytest.mark.long
def test_walking_the_edge_makes_a_parcel_of_positions_heard(show: Show, theatre: Theatre) -> None:
    page = editing(show())
    page.get_by_test_id("editor-walk").click()
    expect(page.get_by_test_id("walk-facts")).to_contain_text("±1 cm")
    page.get_by_test_id("walk-start").click()
    expect(page.get_by_test_id("walk")).to_have_attribute("data-value", "1")
    expect(page.get_by_test_id("walk-finish")).to_be_disabled()
    page.evaluate(WALKED, {"accuracy_m": 0.014})
    page.get_by_test_id("walk-finish").click()
    heard = saved(page, theatre, "Edge walked with Weeder 07")
    [walked] = [one for one in heard["draft"].values() if one["properties"]["name"] == "Walked with Weeder 07"]
    assert len(walked["geometry"]["coordinates"][0]) == 5, "a corner on a straight edge is left out"
    assert walked["properties"]["accuracy_m"] == 0.014


@pytest.mark.long
def test_a_side_that_nobody_heard_is_told_before_it_becomes_an_edge(show: Show, theatre: Theatre) -> None:
    page = editing(show())
    walking(page, missing=(3,))
    expect(page.get_by_test_id("walk-note")).to_contain_text("Not recorded: 1 stretch, 110 m.")
    expect(page.locator(".m-track .bridge")).to_have_attribute("d", re.compile("^M.+L"))
    page.get_by_test_id("walk-finish").click()
    expect(page.get_by_test_id("walk-gaps").locator("li")).to_have_text(re.compile(r"110 m in 1:3\d, from [\d.]+° N, "))
    page.get_by_test_id("walk-gaps").get_by_text("Not yet").click()
    assert theatre.heard_map()["labels"] == []
    page.get_by_test_id("walk-finish").click()
    page.get_by_test_id("walk-gaps").get_by_text("Take it so").click()
    saved(page, theatre, "Edge walked with Weeder 07")


@pytest.mark.long
def test_a_walk_goes_on_while_another_screen_is_shown_and_keeps_the_tablet_awake(show: Show, theatre: Theatre) -> None:
    page = show(is_new=True)
    page.context.add_init_script(WAKE_LOCK)
    expect(page.get_by_test_id("editor-edit")).to_be_visible()  # or it is another screen that is loaded again
    page.reload()
    editing(page)
    page.get_by_test_id("editor-walk").click()
    page.get_by_test_id("walk-start").click()
    page.wait_for_function("window.locks.some((lock) => lock.isOn)")
    page.get_by_test_id("nav-fleet").click()
    expect(page.get_by_test_id("toast")).to_contain_text("The walk with Weeder 07 goes on.")
    expect(page.get_by_test_id("maps")).to_have_count(0)
    heard = page.evaluate("HL.maps.recording.heard.length")
    page.wait_for_function("(heard) => HL.maps.recording.heard.length > heard", arg=heard)
    page.get_by_test_id("nav-maps").click()
    expect(page.get_by_test_id("walk-finish")).to_be_visible()
    page.get_by_test_id("walk-cancel").click()
    page.wait_for_function("window.locks.every((lock) => !lock.isOn)")


@pytest.mark.long
def test_a_walk_is_offered_again_after_a_reload(show: Show, theatre: Theatre) -> None:
    page = editing(show(is_new=True))
    walking(page)
    points = page.get_by_test_id("walk").get_attribute("data-value")
    page.reload()
    expect(page.get_by_test_id("walk-facts")).to_contain_text(f"{points} points kept from ")
    expect(page.get_by_test_id("walk-robot")).to_be_disabled()
    page.get_by_test_id("walk-start").click()
    expect(page.get_by_test_id("walk-start")).not_to_be_visible()
    page.get_by_test_id("walk-cancel").click()
    page.reload()
    expect(page.get_by_test_id("maps")).to_have_attribute("data-state", "draft")
    expect(page.get_by_test_id("walk")).not_to_be_visible()


@pytest.mark.long
def test_a_guide_line_is_walked_from_end_to_end_and_says_what_was_left_out(show: Show, theatre: Theatre) -> None:
    page = editing(show())
    page.get_by_test_id("editor-walk").click()
    page.get_by_test_id("walk-what").select_option("rows")
    page.get_by_test_id("walk-start").click()
    expect(page.get_by_test_id("walk-note")).to_contain_text("strays less than 10 cm from a straight line is left out")
    expect(page.get_by_test_id("walk-what")).to_be_disabled()
    page.evaluate(WALKED, {"accuracy_m": 0.014})
    page.get_by_test_id("walk-finish").click()
    expect(page.get_by_test_id("toast")).to_contain_text(
        re.compile(r"4 points from \d+ positions, ±1 cm; strays below 10 cm are left out\.")
    )
    heard = saved(page, theatre, "Line walked with Weeder 07")
    [walked] = [one for one in heard["draft"].values() if one["properties"]["name"] == "Walked with Weeder 07"]
    assert (walked["properties"]["kind"], walked["properties"]["type"]) == ("rows", "curve")
    assert walked["geometry"]["type"] == "LineString"
    assert len(walked["geometry"]["coordinates"]) == 4


@pytest.mark.long
def test_a_file_of_thousands_of_shapes_stays_usable(show: Show) -> None:
    page = editing(show())
    page.get_by_test_id("import-file").set_input_files(
        {"name": "district.geojson", "mimeType": "application/json", "buffer": b"{}"}
    )
    take = page.get_by_test_id("import-take")
    expect(take).to_have_text("Take 5000 of 5000")
    assert page.get_by_test_id("import-list").locator(".m-item").count() < 300
    page.get_by_test_id("import-parcels").click()
    expect(take).to_have_text("Take 4500 of 5000")
    page.get_by_test_id("import-none").click()
    expect(take).to_be_disabled()
    page.get_by_test_id("import-search").fill("Perceel 4321")
    page.get_by_test_id("import-item-4321").check()
    expect(take).to_have_text("Take 1 of 5000")
    page.get_by_test_id("import-all").click()
    expect(take).to_have_text("Take 5000 of 5000")


@pytest.mark.long
def test_reading_on_the_server_shows_how_far_it_is_and_is_cancelled_there_too(show: Show, theatre: Theatre) -> None:
    page = editing(show())
    theatre.play_map(slow_s=4.0)
    page.get_by_test_id("import-file").set_input_files({"name": "a.kml", "mimeType": "text/xml", "buffer": b"x"})
    expect(page.get_by_test_id("import-state")).to_have_text("Reading the file, 40 %, 2400 shapes so far", timeout=9000)
    page.get_by_test_id("import-progress").get_by_text("Cancel").click()
    expect(page.get_by_test_id("toast")).to_contain_text("Import cancelled")
    theatre.play_map(slow_s=0)
    page.wait_for_timeout(0)
    assert any(one["method"] == "DELETE" for one in theatre.heard_map()["asked"])


@pytest.mark.long
def test_a_format_that_leaves_something_out_says_so_first(show: Show) -> None:
    page = editing(show())
    page.get_by_test_id("editor-export").click()
    page.get_by_test_id("editor-export-draft-fiware").click()
    expect(page.get_by_test_id("export-losses").locator("li")).to_have_text(["Home 1", "Hedge"])
    with page.expect_download() as download:
        page.get_by_text("Export without").click()
    assert download.value.suggested_filename == "farm.fiware"


@pytest.mark.long
def test_the_tablet_s_own_position_walks_an_edge_with_its_accuracy(show: Show, theatre: Theatre) -> None:
    page = show(is_new=True)
    page.context.grant_permissions(["geolocation"])
    page.context.set_geolocation({"latitude": 48.1375, "longitude": 11.5755, "accuracy": 6})
    editing(page)
    page.get_by_test_id("editor-walk").click()
    page.get_by_test_id("walk-robot").select_option("tablet")
    expect(page.get_by_test_id("walk-facts")).to_have_text("±3.0 m")
    page.get_by_test_id("walk-start").click()
    expect(page.get_by_test_id("walk")).to_have_attribute("data-value", "1")
    page.evaluate(WALKED, {"accuracy_m": 3})
    page.get_by_test_id("walk-finish").click()
    heard = saved(page, theatre, "Edge walked with this tablet")
    [walked] = [one for one in heard["draft"].values() if one["properties"]["name"] == "Walked with this tablet"]
    assert walked["properties"]["accuracy_m"] == 3


@pytest.mark.long
def test_on_plain_http_the_tablet_says_what_its_position_needs(show: Show) -> None:
    page = show()
    page.evaluate("Object.defineProperty(window, 'isSecureContext', { value: false })")
    editing(page)
    page.get_by_test_id("editor-walk").click()
    page.get_by_test_id("walk-robot").select_option("tablet")
    expect(page.get_by_test_id("walk-note")).to_contain_text("needs a secure address (https)")
    expect(page.get_by_test_id("walk-start")).to_be_disabled()
