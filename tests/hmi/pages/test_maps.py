"""The maps screen in a browser, on a played map; the drawing surface is a stand-in but where drawing is asked."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, Route, expect

from tests.hmi.pages.conftest import SIZES, Theatre

pytestmark = pytest.mark.browser
Look = Callable[..., Page]
Show = Callable[..., Page]

SURFACE = """
export class MapEditor {
  constructor(host, options) {
    Object.assign(this, { host, options, features: new Map(), calls: [], selected: [], vertex: null });
  }
  async start() { window.surface = this; this.host.dataset.state = 'ready'; }
  setFeatures(all) { this.features = new Map(all.map((one) => [one.id, one])); this.#count(); }
  patch(changes) {
    for (const { id, after } of changes) after ? this.features.set(id, after) : this.features.delete(id);
    this.#count();
  }
  #count() { this.host.dataset.features = this.features.size; }
  draw(label, changes) { this.patch(changes); this.options.onChange({ label, changes }); }
  tap(...ids) { this.selected = ids; this.vertex = null; this.options.onSelect(ids); }
  choose(position) { this.vertex = { position }; this.options.onPoint(position); }
  setTool(name) { this.host.dataset.tool = name; }
  select(ids) { this.selected = ids; this.host.dataset.selected = ids.join(' '); }
  fit(ids) { this.host.dataset.fit = (ids ?? []).join(' '); }
  setFindings(all) { this.host.dataset.findings = all.length; }
  setSnap(isOn) { this.calls.push(['snap', isOn]); }
  setSeveral(isOn) { this.calls.push(['several', isOn]); }
  unlockBody(isOn) { this.calls.push(['unlock', isOn]); }
  nudge(x, y) { this.calls.push(['nudge', x, y]); }
  setVertex(place) { this.calls.push(['vertex', ...place]); }
  removeVertex() { this.calls.push(['remove']); }
  undoPoint() { this.calls.push(['undoPoint']); }
  destroy() { this.host.replaceChildren(); }
}
"""


def stand_in(route: Route) -> None:
    kind = "text/css" if route.request.url.endswith(".css") else "application/javascript"
    route.fulfill(content_type=kind, body="" if kind == "text/css" else SURFACE)


@pytest.fixture
def show(look: Look, theatre: Theatre) -> Show:
    """Open the maps screen of a map that was set first."""

    def open_screen(*, role: str = "planner", size: str = "landscape", **wish: Any) -> Page:
        theatre.play("running")
        theatre.play_map(anew=True, **wish)
        page = look("/fleet", role=role, size=size)
        page.route("**/editor/*", stand_in)
        page.get_by_test_id("nav-maps").click()
        return page

    return open_screen


def editing(page: Page) -> Page:
    """Begin a draft."""
    page.get_by_test_id("editor-edit").click()
    expect(page.get_by_test_id("maps")).to_have_attribute("data-state", "draft")
    expect(page.get_by_test_id("map-editor")).to_have_attribute("data-state", "ready")
    return page


def choose(page: Page, *ids: str) -> None:
    page.evaluate("(ids) => surface.tap(...ids)", list(ids))


def set_field(page: Page, hook: str, value: str) -> None:
    page.get_by_test_id(hook).fill(value)
    page.get_by_test_id(hook).press("Enter")


def saved(page: Page, theatre: Theatre, *labels: str) -> dict[str, Any]:
    """Wait until the draft has these changes, oldest first."""
    expect(page.get_by_test_id("editor-changes").locator("li[data-state=saved]")).to_have_count(len(labels))
    heard = theatre.heard_map()
    assert heard["labels"] == list(labels)
    return heard


def test_the_published_map_is_shown_read_only_until_somebody_edits(show: Show) -> None:
    page = show()
    expect(page.get_by_test_id("map-editor")).to_have_attribute("data-features", "8")
    assert page.evaluate("surface.options.readOnly") is True
    expect(page.get_by_test_id("editor-tool-parcel")).to_have_attribute("aria-disabled", "true")
    editing(page)
    assert page.evaluate("surface.options.readOnly") is False
    expect(page.get_by_test_id("editor-lock")).to_contain_text("Only you can edit until ")
    expect(page.get_by_test_id("editor-tool-parcel")).not_to_have_attribute("aria-disabled", "true")


def test_a_viewer_only_looks(show: Show) -> None:
    page = show(role="viewer")
    expect(page.get_by_test_id("editor-reason")).to_have_text("You cannot publish maps. Needs the planner role.")
    for hook in ("editor-edit", "editor-publish", "editor-undo", "editor-import", "editor-discard"):
        expect(page.get_by_test_id(hook)).not_to_be_visible()
    page.get_by_test_id("feature-row-nordfeld").click()
    expect(page.get_by_test_id("feature-crop")).to_have_value("Sugar beet")
    expect(page.get_by_test_id("feature-crop")).to_be_disabled()
    expect(page.get_by_test_id("feature-delete")).to_be_disabled()


def test_the_chosen_parcel_shows_its_measures_and_attributes(show: Show) -> None:
    page = editing(show())
    choose(page, "nordfeld")
    expect(page.get_by_test_id("feature-name")).to_have_value("Nordfeld 12")
    area = float(page.get_by_test_id("editor-area").get_attribute("data-value") or 0)
    assert area == pytest.approx(11_960, rel=0.01)
    expect(page.get_by_test_id("editor-area")).to_contain_text("1.20ha")
    expect(page.get_by_test_id("feature-row-spacing-m")).to_have_value("45")
    expect(page.get_by_test_id("feature-row-bearing-deg")).to_have_value("11.5")


def test_an_attribute_is_saved_as_a_change_that_can_be_undone_and_redone(show: Show, theatre: Theatre) -> None:
    page = editing(show())
    choose(page, "nordfeld")
    set_field(page, "feature-row-bearing-deg", "9")
    heard = saved(page, theatre, "Row direction 11.5 to 9.0")
    assert heard["draft"]["nordfeld"]["properties"]["row_bearing_deg"] == 9.0
    assert heard["published"]["nordfeld"]["properties"]["row_bearing_deg"] == 11.5
    expect(page.get_by_test_id("editor-saved")).to_contain_text("Draft, saved ")
    page.get_by_test_id("editor-undo").click()
    expect(page.get_by_test_id("feature-row-bearing-deg")).to_have_value("11.5")
    expect(page.get_by_test_id("editor-undo")).to_be_disabled()
    page.get_by_test_id("editor-redo").click()
    expect(page.get_by_test_id("feature-row-bearing-deg")).to_have_value("9.0")


@pytest.mark.long
def test_row_spacing_is_entered_in_centimetres_and_kept_in_metres(show: Show, theatre: Theatre) -> None:
    page = editing(show())
    choose(page, "nordfeld")
    set_field(page, "feature-row-spacing-m", "50")
    heard = saved(page, theatre, "Row spacing 45 to 50 cm")
    assert heard["draft"]["nordfeld"]["properties"]["row_spacing_m"] == 0.5


@pytest.mark.long
def test_a_value_out_of_bounds_is_refused_with_the_bounds(show: Show, theatre: Theatre) -> None:
    page = editing(show())
    choose(page, "nordfeld")
    set_field(page, "feature-row-spacing-m", "4500")
    expect(page.get_by_test_id("toast")).to_contain_text("Row spacing: 1 to 1000 cm")
    expect(page.get_by_test_id("feature-row-spacing-m")).to_have_value("45")
    assert theatre.heard_map()["labels"] == []


def test_what_is_drawn_is_saved_copied_and_deleted(show: Show, theatre: Theatre) -> None:
    page = editing(show())
    page.keyboard.press("p")
    expect(page.get_by_test_id("map-editor")).to_have_attribute("data-tool", "parcel")
    page.evaluate(
        """() => {
          const properties = { id: 'new-1', kind: 'parcel' };
          const after = { ...surface.features.get('westschlag'), id: 'new-1', properties };
          surface.draw('Parcel drawn', [{ id: 'new-1', before: null, after }]);
          surface.tap('new-1');
          surface.options.onDrawn(after);
        }"""
    )
    expect(page.get_by_test_id("editor-tool-select")).to_have_attribute("aria-pressed", "true")
    set_field(page, "feature-name", "Westschlag 4")
    page.get_by_test_id("feature-copy").click()
    expect(page.get_by_test_id("feature-name")).to_have_value("Westschlag 4 copy")
    page.get_by_test_id("feature-delete").click()
    labels = ("Parcel drawn", "Parcel renamed Westschlag 4", "Westschlag 4 copied", "Westschlag 4 copy deleted")
    heard = saved(page, theatre, *labels)
    assert len(heard["draft"]) == 9


def test_a_hole_and_a_cut_are_made_by_the_server(show: Show, theatre: Theatre) -> None:
    page = editing(show())
    page.get_by_test_id("editor-tool-split").click()
    expect(page.get_by_test_id("editor-hint")).to_contain_text("Tap a line across the parcel.")
    line = [[11.57, 48.137], [11.58, 48.138]]
    page.evaluate("(coordinates) => surface.options.onDrawn({tool: 'split', coordinates, target: 'hangacker'})", line)
    saved(page, theatre, "Hangacker 5 split")
    expect(page.get_by_test_id("map-editor")).to_have_attribute("data-features", "9")
    expect(page.get_by_test_id("editor-tool-select")).to_have_attribute("aria-pressed", "true")
    [asked] = [one for one in theatre.heard_map()["asked"] if one["path"] == "draft/operations"]
    assert (asked["op"], asked["features"], asked["args"]) == ("split", ["hangacker"], {"line": line})


@pytest.mark.long
def test_parcels_are_chosen_and_merged(show: Show, theatre: Theatre) -> None:
    page = editing(show())
    page.get_by_test_id("editor-tool-merge").click()
    expect(page.get_by_test_id("editor-merge")).to_be_disabled()
    choose(page, "nordfeld", "westschlag")
    expect(page.get_by_test_id("editor-hint")).to_contain_text("2 parcels chosen")
    page.get_by_test_id("editor-merge").click()
    saved(page, theatre, "Parcels merged")
    expect(page.get_by_test_id("map-editor")).to_have_attribute("data-features", "7")


@pytest.mark.long
def test_the_chosen_corner_is_moved_by_steps_and_by_numbers(show: Show) -> None:
    page = editing(show())
    choose(page, "nordfeld")
    expect(page.get_by_test_id("feature-corner")).not_to_be_visible()
    page.evaluate("surface.choose([11.5754, 48.1374])")
    expect(page.get_by_test_id("corner-lat")).to_have_value("48.1374")
    page.get_by_test_id("corner-up").click()
    set_field(page, "corner-lon", "11.5755")
    page.get_by_test_id("corner-remove").click()
    calls = page.evaluate("surface.calls.filter(([name]) => name !== 'snap')")
    assert calls == [["nudge", 0, 0.1], ["vertex", 11.5755, 48.1374], ["remove"]]


def test_checks_block_publishing_until_their_fix_is_tapped(show: Show, theatre: Theatre) -> None:
    page = editing(show(rename={"hangacker": "Hangacker crossed"}))
    checks = page.get_by_test_id("editor-checks")
    expect(checks).to_contain_text("1 blocks publishing")
    expect(checks).to_contain_text("2 to look at")
    expect(page.get_by_test_id("map-editor")).to_have_attribute("data-findings", "3")
    expect(page.get_by_test_id("editor-publish")).to_be_disabled()
    expect(page.get_by_test_id("editor-reason")).to_have_text("Fix 1 blocking check first.")
    page.get_by_test_id("finding-near").get_by_test_id("finding-show").click()
    expect(page.get_by_test_id("map-editor")).to_have_attribute("data-fit", "nordfeld")
    page.get_by_test_id("finding-crosses").get_by_test_id("finding-fix").click()
    expect(checks).not_to_contain_text("publishing")
    saved(page, theatre, "Edge untangled")
    expect(page.get_by_test_id("editor-publish")).to_be_enabled()


def test_publishing_asks_for_a_note_and_makes_the_next_version(show: Show, theatre: Theatre) -> None:
    page = editing(show())
    expect(page.get_by_test_id("editor-reason")).to_have_text("Nothing is changed yet.")
    choose(page, "nordfeld")
    set_field(page, "feature-status", "BBCH 16")
    page.get_by_test_id("editor-publish").click()
    expect(page.get_by_test_id("publish-note")).to_have_value("Status BBCH 14 to BBCH 16")
    page.get_by_test_id("publish-note").fill("Second weeding")
    page.get_by_test_id("publish-go").click()
    expect(page.get_by_test_id("toast")).to_contain_text("v15 is published")
    expect(page.get_by_test_id("maps")).to_have_attribute("data-state", "published")
    heard = theatre.heard_map()
    assert (heard["version"], heard["note"]) == (15, "Second weeding")


def test_a_map_that_shrinks_is_asked_about_with_numbers(show: Show, theatre: Theatre) -> None:
    page = editing(show())
    choose(page, "nordfeld", "hangacker", "pylon", "road-2", "hedge")
    page.get_by_test_id("feature-delete").click()
    page.get_by_test_id("editor-publish").click()
    page.get_by_test_id("publish-go").click()
    expect(page.get_by_test_id("publish-shrinks")).to_contain_text("8 to 3")
    expect(page.get_by_test_id("publish-shrinks")).to_contain_text("3.08 ha to 0.86 ha")
    page.get_by_test_id("publish-smaller").get_by_text("Publish it so").click()
    expect(page.get_by_test_id("maps")).to_have_attribute("data-state", "published")
    assert len(theatre.heard_map()["published"]) == 3


def test_the_draft_of_another_is_locked_and_a_supervisor_may_take_it(show: Show) -> None:
    page = show(editor="somebody", name="Jonas Weber")
    expect(page.get_by_test_id("editor-lock")).to_contain_text("Jonas Weber edits until ")
    expect(page.get_by_test_id("editor-edit")).to_be_disabled()
    expect(page.get_by_test_id("editor-take")).not_to_be_visible()
    page = show(role="supervisor", editor="somebody", name="Jonas Weber")
    page.get_by_test_id("editor-take").click()
    expect(page.get_by_test_id("editor-lock")).to_contain_text("Only you can edit until ")


@pytest.mark.long
def test_losing_the_lock_keeps_what_is_not_saved(show: Show, theatre: Theatre) -> None:
    page = editing(show())
    theatre.play_map(editor="somebody", name="Jonas Weber")
    choose(page, "nordfeld")
    set_field(page, "feature-crop", "Maize")
    expect(page.get_by_test_id("editor-lock")).to_contain_text("Jonas Weber edits until ")
    expect(page.get_by_test_id("maps")).to_have_attribute("data-state", "published")
    expect(page.get_by_test_id("editor-unsaved")).to_have_text("cloud_offNot saved yet: 1 change")
    page.get_by_test_id("editor-unsaved").click()
    page.get_by_test_id("unsaved").get_by_text("Drop them").click()
    expect(page.get_by_test_id("editor-unsaved")).not_to_be_visible()


def test_changes_made_offline_survive_a_reload_and_go_out_in_order(show: Show, theatre: Theatre) -> None:
    page = editing(show())
    page.route("**/api/v1/map/draft/transactions", lambda route: route.abort())
    choose(page, "nordfeld")
    set_field(page, "feature-crop", "Maize")
    set_field(page, "feature-headland-m", "4")
    set_field(page, "feature-headland-m", "6")
    expect(page.get_by_test_id("editor-unsaved")).to_contain_text("Not saved yet: 3 changes")
    page.get_by_test_id("editor-undo").click()
    expect(page.get_by_test_id("editor-unsaved")).to_contain_text("Not saved yet: 2 changes")
    expect(page.get_by_test_id("feature-headland-m")).to_have_value("4")
    page.reload()
    expect(page.get_by_test_id("editor-unsaved")).to_contain_text("Not saved yet: 2 changes")
    assert theatre.heard_map()["labels"] == []
    page.unroute("**/api/v1/map/draft/transactions")
    expect(page.get_by_test_id("editor-unsaved")).not_to_be_visible()
    saved(page, theatre, "Crop Sugar beet to Maize", "Headland width 3.5 to 4 m")


def test_a_change_that_does_not_fit_any_more_is_named_and_the_draft_loaded_again(show: Show, theatre: Theatre) -> None:
    page = editing(show())
    theatre.play_map(rename={"nordfeld": "Nordfeld 13"}, in_draft=True)
    choose(page, "nordfeld")
    set_field(page, "feature-crop", "Maize")
    expect(page.get_by_test_id("refused-list")).to_have_text("Crop Sugar beet to Maize")
    page.get_by_test_id("refused").get_by_text("Close").click()
    choose(page, "nordfeld")
    expect(page.get_by_test_id("feature-name")).to_have_value("Nordfeld 13")
    expect(page.get_by_test_id("feature-crop")).to_have_value("Sugar beet")


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
def test_compare_lists_differences_and_a_tap_shows_one(show: Show, theatre: Theatre) -> None:
    page = editing(show())
    choose(page, "westschlag")
    set_field(page, "feature-crop", "Leek")
    saved(page, theatre, "Crop Onions to Leek")
    page.get_by_test_id("editor-compare").click()
    expect(page.get_by_test_id("compare").locator("[data-state]")).to_have_count(1)
    page.get_by_test_id("difference-westschlag").click()
    expect(page.get_by_test_id("compare")).to_have_count(0)
    expect(page.get_by_test_id("map-editor")).to_have_attribute("data-fit", "westschlag")


@pytest.mark.long
def test_an_older_version_comes_back_as_a_draft(show: Show, theatre: Theatre) -> None:
    page = show()
    page.get_by_test_id("editor-versions").click()
    expect(page.get_by_test_id("version-14")).to_contain_text("In use")
    page.get_by_test_id("version-restore-13").click()
    expect(page.get_by_test_id("maps")).to_have_attribute("data-state", "draft")
    saved(page, theatre, "Content of v13")
    expect(page.get_by_test_id("map-editor")).to_have_attribute("data-features", "7")


@pytest.mark.long
def test_a_draft_is_discarded_after_one_question(show: Show, theatre: Theatre) -> None:
    page = editing(show())
    choose(page, "nordfeld")
    set_field(page, "feature-crop", "Maize")
    page.get_by_test_id("editor-discard").click()
    expect(page.get_by_test_id("discard")).to_contain_text("v14 stays as it is.")
    page.get_by_test_id("discard").get_by_text("Discard draft", exact=True).click()
    expect(page.get_by_test_id("maps")).to_have_attribute("data-state", "published")
    assert theatre.heard_map()["draft"] is None


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
def test_walking_the_edge_makes_a_parcel_of_positions_heard(show: Show, theatre: Theatre) -> None:
    page = editing(show())
    page.get_by_test_id("editor-walk").click()
    expect(page.get_by_test_id("walk-facts")).to_contain_text("±1 cm")
    page.get_by_test_id("walk-start").click()
    expect(page.get_by_test_id("walk")).to_have_attribute("data-value", "1")
    expect(page.get_by_test_id("walk-finish")).to_be_disabled()
    page.evaluate(
        """() => {
          const { walk } = document.querySelector('hl-maps');
          const [lon, lat] = walk.points[0];
          for (const [x, y] of [[0, 1e-3], [5e-4, 1e-3], [1e-3, 1e-3], [1e-3, 0]]) walk.add([lon + x, lat + y], 0.014);
        }"""
    )
    page.get_by_test_id("walk-finish").click()
    heard = saved(page, theatre, "Edge walked with Weeder 07")
    [walked] = [one for one in heard["draft"].values() if one["properties"]["name"] == "Walked with Weeder 07"]
    assert len(walked["geometry"]["coordinates"][0]) == 5, "a corner on a straight edge is left out"
    assert walked["properties"]["accuracy_m"] == 0.014


@pytest.mark.long
def test_an_empty_map_says_how_to_begin(show: Show) -> None:
    page = show(is_empty=True)
    expect(page.get_by_test_id("maps-empty")).to_contain_text("Draw a field, walk its edge, or import")
    page.get_by_test_id("empty-draw").click()
    expect(page.get_by_test_id("map-editor")).to_have_attribute("data-tool", "parcel")
    expect(page.get_by_test_id("maps-empty")).to_have_count(0)


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


@pytest.mark.parametrize("size", SIZES)
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
