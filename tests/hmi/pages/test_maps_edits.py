"""What a planner does to shapes on the maps screen."""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

from tests.hmi.pages.conftest import Theatre
from tests.hmi.pages.maps_screen import Show, choose, editing, saved, set_field
from tests.hmi.pages.maps_screen import show as show

pytestmark = pytest.mark.browser


@pytest.mark.long
def test_the_chosen_parcel_shows_its_measures_and_attributes(show: Show) -> None:
    page = editing(show())
    choose(page, "nordfeld")
    expect(page.get_by_test_id("feature-name")).to_have_value("Nordfeld 12")
    area = float(page.get_by_test_id("editor-area").get_attribute("data-value") or 0)
    assert area == pytest.approx(11_960, rel=0.01)
    expect(page.get_by_test_id("editor-area")).to_contain_text("1.20ha")
    expect(page.get_by_test_id("feature-row-spacing-m")).to_have_value("45")
    expect(page.get_by_test_id("feature-row-bearing-deg")).to_have_value("11.5")


def test_a_field_tapped_far_down_the_list_is_read_from_its_name_on(show: Show) -> None:
    page = show()
    side = page.get_by_role("complementary", name="Details")
    side.evaluate("node => { node.style.height = '120px'; node.style.flex = 'none'; node.scrollTop = 40; }")
    expect(page.get_by_test_id("feature-row-nordfeld")).to_be_visible()
    assert side.evaluate("node => node.scrollTop") == 40
    page.evaluate("document.querySelector('[data-testid=feature-row-nordfeld]').click()")
    expect(page.get_by_test_id("feature-name")).to_be_visible()
    assert side.evaluate("node => node.scrollTop") == 0


MORE_FIELDS = """() => {
  const corners = [[11.6, 48.2], [11.601, 48.2], [11.601, 48.201], [11.6, 48.2]];
  const one = (n) => ({ type: 'Feature', id: `more-${n}`, geometry: { type: 'Polygon', coordinates: [corners] },
    properties: { id: `more-${n}`, kind: 'parcel', name: `Long field ${n}`, crop: n === 7 ? 'Celeriac' : 'Leek' } });
  const changes = Array.from({ length: 14 }, (_, n) => ({ id: `more-${n}`, before: null, after: one(n) }));
  surface.draw('Fourteen fields drawn', changes);
}"""


def test_a_farm_with_many_fields_is_searched_by_name_crop_and_kind(show: Show) -> None:
    page = editing(show())
    find, rows = page.get_by_test_id("feature-find"), page.locator(".m-list [data-testid^=feature-row-]")
    expect(find).to_be_hidden()
    page.evaluate(MORE_FIELDS)
    find.fill("celer")
    expect(rows).to_have_count(1)
    expect(rows).to_contain_text("Long field 7")
    find.fill("long field 1")
    expect(rows).to_have_count(5)
    rows.first.click()
    page.evaluate("surface.tap()")
    expect(find).to_have_value("long field 1")
    find.fill("road")
    assert {row.split("\n")[-1] for row in rows.all_inner_texts()} == {"Road"}
    find.fill("nowhere")
    expect(page.get_by_test_id("feature-none")).to_be_visible()


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


@pytest.mark.long
def test_a_hole_and_a_cut_are_made_by_the_server(show: Show, theatre: Theatre) -> None:
    page = editing(show())
    page.get_by_test_id("editor-tool-split").click()
    expect(page.get_by_test_id("editor-hint")).to_contain_text("Tap a line across the parcel, then Done.")
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
    choose(page, "nordfeld")
    expect(page.get_by_test_id("editor-hint")).to_contain_text("1 chosen. Tap what it is merged with.")
    kinds = "[...surface.features.values()].filter((one) => surface.several(one)).map((one) => one.properties.kind)"
    assert set(page.evaluate(kinds)) == {"parcel"}, "neither obstacles nor the farm around them"
    choose(page, "nordfeld", "westschlag")
    expect(page.get_by_test_id("editor-hint")).to_contain_text("2 chosen")
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
    side = page.get_by_role("complementary", name="Details")
    side.evaluate("node => { node.style.height = '120px'; node.style.flex = 'none'; }")
    expect(checks).not_to_be_in_viewport()
    page.get_by_test_id("editor-to-checks").click()
    expect(checks).to_be_in_viewport()
    page.get_by_test_id("finding-near").get_by_test_id("finding-show").click()
    expect(page.get_by_test_id("map-editor")).to_have_attribute("data-fit", "nordfeld")
    page.get_by_test_id("finding-crosses").get_by_test_id("finding-fix").click()
    expect(checks).not_to_contain_text("publishing")
    saved(page, theatre, "Edge untangled")
    expect(page.get_by_test_id("editor-publish")).to_be_enabled()
    expect(page.get_by_test_id("editor-to-checks")).to_be_hidden()


def test_a_change_of_shape_is_looked_at_before_it_is_done(show: Show, theatre: Theatre) -> None:
    page = editing(show())
    choose(page, "nordfeld")
    page.get_by_test_id("feature-reshape").click()
    effect, apply = page.get_by_test_id("reshape-effect"), page.get_by_test_id("reshape-apply")
    expect(effect).to_have_text("1.22 ha to 1.14 ha")
    expect(page.get_by_test_id("map-editor")).to_have_attribute("data-trial", "1")
    page.get_by_test_id("reshape-simplify").click()
    expect(effect).to_have_text("42 of 180 corners stay, at most 0.08 m off")
    page.get_by_test_id("reshape-inset").click()
    page.get_by_test_id("reshape-value").fill("900")
    expect(effect).to_have_text("Nothing would be left. Choose less, or delete it.")
    expect(apply).to_be_disabled()
    expect(page.get_by_test_id("map-editor")).to_have_attribute("data-trial", "0")
    page.get_by_test_id("reshape-value").fill("2,5")
    apply.click()
    heard = saved(page, theatre, "Shape grown")
    assert heard["draft"]["nordfeld"]["properties"]["done"] == ["buffer", {"distance_m": -2.5}]
    expect(page.get_by_test_id("reshape")).to_be_hidden()


@pytest.mark.long
def test_a_shape_is_turned_only_when_it_is_unlocked(show: Show, theatre: Theatre) -> None:
    page = editing(show())
    choose(page, "nordfeld")
    page.get_by_test_id("feature-reshape").click()
    page.get_by_test_id("reshape-turn").click()
    expect(page.get_by_test_id("reshape-apply")).to_be_disabled()
    page.get_by_test_id("reshape-unlock").click()
    page.evaluate("surface.options.onTurn(12.5)")
    expect(page.get_by_test_id("reshape-value")).to_have_value("12.5")
    page.get_by_test_id("reshape-apply").click()
    assert saved(page, theatre, "Shape turned")["draft"]["nordfeld"]["properties"]["done"] == [
        "turn",
        {"angle_deg": 12.5},
    ]
    choose(page, "hangacker")
    page.locator(".m-more summary").click()
    expect(page.get_by_test_id("feature-unlock")).not_to_be_checked()


@pytest.mark.long
def test_one_edge_is_straightened_between_two_tapped_corners(show: Show) -> None:
    page = editing(show())
    choose(page, "nordfeld")
    page.get_by_test_id("feature-reshape").click()
    page.get_by_test_id("reshape-straighten").click()
    for index in (1, 3):
        page.evaluate(
            "(n) => { surface.vertex = { index: n, position: [11.5 + n / 1e4, 48.1] };"
            " surface.options.onPoint(surface.vertex.position); }",
            index,
        )
    expect(page.get_by_test_id("reshape-from")).to_have_value("2")
    expect(page.get_by_test_id("reshape-to")).to_have_value("4")
    expect(page.get_by_test_id("reshape-one-edge")).to_be_checked()


@pytest.mark.long
def test_each_tool_offers_what_else_it_draws(show: Show) -> None:
    page = editing(show())
    pens = {
        "obstacle": ["circle", "no-go", "slow", "building", "water"],
        "road": ["yard", "hedge"],
        "home": ["garage", "charging", "gate"],
        "rows": ["curve", "recorded"],
    }
    for tool, offered in pens.items():
        page.get_by_test_id(f"editor-tool-{tool}").click()
        expect(page.get_by_test_id("map-editor")).to_have_attribute("data-tool", tool)
        for pen in offered:
            page.get_by_test_id(f"editor-pen-{pen}").click()
            expect(page.get_by_test_id("map-editor")).to_have_attribute("data-tool", pen)
    page.get_by_test_id("editor-tool-obstacle").click()
    expect(page.get_by_test_id("editor-tool-measure")).not_to_have_attribute("aria-disabled", "true")
    expect(page.get_by_test_id("editor-radius")).to_be_hidden()
    page.get_by_test_id("editor-pen-circle").click()
    page.get_by_test_id("editor-radius").fill("2,5")
    page.get_by_test_id("editor-radius-set").click()
    assert page.evaluate("surface.calls.at(-1)") == ["radius", 2.5]
    page.evaluate("surface.drawingReason = 'Drawing needs WebGL.'; surface.tap('nordfeld')")
    for tool in ("parcel", "merge", "measure"):  # a tablet without graphics says so before somebody taps in vain
        expect(page.get_by_test_id(f"editor-tool-{tool}")).to_have_attribute("data-reason", "Drawing needs WebGL.")
    expect(page.get_by_test_id("editor-tool-select")).not_to_have_attribute("aria-disabled", "true")


@pytest.mark.long
def test_history_tells_what_changed_and_takes_the_day_a_value_holds_from(show: Show, theatre: Theatre) -> None:
    page = editing(show())
    choose(page, "nordfeld")
    page.get_by_test_id("feature-history").click()
    sheet = page.get_by_test_id("history")
    expect(sheet.get_by_test_id("history-crop-14")).to_contain_text("Crop: Maize to Sugar beet")
    expect(sheet.get_by_test_id("history-crop-14")).to_contain_text("valid from 9 Apr 2026")
    expect(sheet.get_by_test_id("history-row_spacing_m-13")).to_contain_text("Row spacing: 45 cm")
    sheet.get_by_test_id("history-choice").select_option("crop")
    expect(sheet.get_by_test_id("history-row_spacing_m-13")).to_have_count(0)
    sheet.get_by_test_id("valid-from-crop").fill("2026-04-01")
    sheet.get_by_test_id("valid-from-crop").press("Enter")
    page.keyboard.press("Escape")
    heard = saved(page, theatre, "Crop valid from 2026-04-01")
    assert heard["draft"]["nordfeld"]["properties"]["valid_from"] == {"crop": "2026-04-01"}
    set_field(page, "feature-crop", "Leek")
    heard = saved(page, theatre, "Crop valid from 2026-04-01", "Crop Sugar beet to Leek")
    assert "valid_from" not in heard["draft"]["nordfeld"]["properties"], "a day of the old crop"


def test_a_drawing_is_done_by_a_button_and_not_thrown_away_unasked(show: Show) -> None:
    page = editing(show())
    page.get_by_test_id("editor-tool-road").click()
    done, leave = page.get_by_test_id("editor-finish"), page.get_by_test_id("editor-leave")
    expect(page.get_by_test_id("editor-hint")).to_contain_text("then Done")
    expect(done).to_be_hidden()
    page.evaluate("surface.canFinish = true; surface.options.onMeasure('20 m')")
    leave.click()
    page.get_by_test_id("unfinished").get_by_role("button", name="Done").click()
    assert page.evaluate("surface.calls.at(-1)") == ["finish"]
    expect(page.get_by_test_id("editor-tool-select")).to_have_attribute("aria-pressed", "true")
    page.get_by_test_id("editor-tool-road").click()
    page.evaluate("surface.canFinish = true; surface.options.onMeasure('20 m'); surface.calls.length = 0")
    page.get_by_test_id("editor-tool-parcel").click()
    page.get_by_test_id("unfinished").get_by_role("button", name="Throw it away").click()
    expect(page.get_by_test_id("map-editor")).to_have_attribute("data-tool", "parcel")
    assert page.evaluate("surface.calls") == []
    page.evaluate("surface.canFinish = true; surface.options.onMeasure('20 m')")
    done.click()
    assert page.evaluate("surface.calls") == [["finish"]]


def test_the_tool_in_hand_again_goes_on_drawing_and_no_point_is_taken_back_before_one_is_set(show: Show) -> None:
    page = editing(show())
    page.get_by_test_id("editor-tool-road").click()
    expect(page.get_by_test_id("editor-undo-point")).to_be_disabled()
    page.evaluate("surface.isDrawing = true; surface.options.onMeasure('')")
    expect(page.get_by_test_id("editor-undo-point")).to_be_enabled()
    page.evaluate(
        "surface.canFinish = true; surface.options.onMeasure('20 m'); surface.host.dataset.tool = 'as it was'"
    )
    page.get_by_test_id("editor-tool-road").click()
    expect(page.get_by_test_id("unfinished")).to_have_count(0)
    expect(page.get_by_test_id("map-editor")).to_have_attribute("data-tool", "as it was")


def test_a_drawing_begun_meanwhile_is_not_left_by_the_answer_to_a_cut(show: Show, theatre: Theatre) -> None:
    page = editing(show())
    page.get_by_test_id("editor-tool-split").click()
    theatre.play_map(slow_s=1.5)
    line = [[11.57, 48.137], [11.58, 48.138]]
    page.evaluate(
        "(coordinates) => { surface.options.onDrawn({tool: 'split', coordinates, target: 'hangacker'}); }", line
    )
    page.get_by_test_id("editor-tool-parcel").click()
    page.evaluate("() => { surface.select = (ids) => surface.calls.push(['select', ids]); }")
    expect(page.get_by_test_id("map-editor")).to_have_attribute("data-features", "9")
    # what follows the answer runs before the next frame but one
    page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    assert page.evaluate("surface.calls.filter(([name]) => name === 'select')") == []


def test_an_emptied_coordinate_moves_nothing(show: Show) -> None:
    page = editing(show())
    choose(page, "nordfeld")
    page.evaluate("surface.choose([11.5754, 48.1374])")
    set_field(page, "corner-lat", "")
    expect(page.get_by_test_id("corner-lat")).to_have_value("48.1374")
    assert page.evaluate("surface.calls.filter(([name]) => name === 'vertex')") == []


def test_a_field_with_the_longest_name_is_copied(show: Show, theatre: Theatre) -> None:
    page = editing(show(rename={"hangacker": "H" * 80}))
    choose(page, "hangacker")
    page.get_by_test_id("feature-copy").click()
    expect(page.get_by_test_id("feature-name")).to_have_value("H" * 75 + " copy")


def test_rows_are_given_to_a_field_and_only_recorded_ones_are_counted(show: Show, theatre: Theatre) -> None:
    page = editing(show())
    page.evaluate(
        """() => {
          const geometry = {type: 'LineString', coordinates: [[11.5754, 48.1374], [11.5756, 48.1376]]};
          const properties = {id: 'ab', kind: 'rows', name: 'A-B', type: 'a-b'};
          const after = {type: 'Feature', id: 'ab', properties, geometry};
          surface.draw('Row line drawn', [{id: 'ab', before: null, after}]);
          surface.tap('ab');
        }"""
    )
    field = page.get_by_test_id("feature-parcel-id")
    assert field.locator("option").all_inner_texts() == ["No field", "Hangacker 5", "Nordfeld 12", "Westschlag 3"]
    field.select_option("nordfeld")
    heard = saved(page, theatre, "Row line drawn", "Field set to Nordfeld 12")
    assert heard["draft"]["ab"]["properties"]["parcel_id"] == "nordfeld"
    choose(page, "nordfeld")
    expect(page.get_by_test_id("editor-rows")).to_contain_text("fit")
    choose(page, "ab")
    page.get_by_test_id("feature-type").select_option("recorded")
    choose(page, "nordfeld")
    expect(page.get_by_test_id("editor-rows")).to_have_attribute("data-value", "1")


def test_what_a_draft_removed_is_shown_where_it_was(show: Show) -> None:
    page = editing(show())
    choose(page, "hangacker")
    page.get_by_test_id("feature-delete").click()
    page.get_by_test_id("editor-compare").click()
    page.get_by_test_id("difference-hangacker").click()
    expect(page.get_by_test_id("map-editor")).to_have_attribute("data-trial", "1")
    expect(page.get_by_test_id("map-editor")).to_have_attribute("data-fit", "hangacker")
    choose(page, "nordfeld")
    expect(page.get_by_test_id("map-editor")).to_have_attribute("data-trial", "0")


def test_another_kind_brings_what_it_needs(show: Show, theatre: Theatre) -> None:
    page = editing(show())
    choose(page, "home")
    page.get_by_test_id("feature-kind").evaluate("(node) => node.closest('details')?.setAttribute('open', '')")
    page.get_by_test_id("feature-kind").select_option("obstacle")
    heard = saved(page, theatre, "Kind home to obstacle")
    properties = heard["draft"]["home"]["properties"]
    assert properties["radius_m"] == 1
    assert "type" not in properties


def test_a_check_calls_a_shape_by_the_name_it_has_now(show: Show) -> None:
    page = editing(show())
    near = page.get_by_test_id("finding-near")
    expect(near).not_to_contain_text("Nordfeld Ost")
    named = page.evaluate(
        "document.querySelector('hl-maps').checks.findings.find((one) => one.code === 'near').feature_id"
    )
    choose(page, named)
    set_field(page, "feature-name", "Nordfeld Ost")
    expect(near).to_contain_text("Nordfeld Ost:")


def test_the_words_of_a_check_have_room_beside_its_buttons(show: Show) -> None:
    page = editing(show(rename={"hangacker": "Hangacker crossed"}))
    expect(page.get_by_test_id("editor-checks")).to_contain_text("1 blocks publishing")
    page.evaluate(
        """() => {
          const maps = document.querySelector('hl-maps');
          const [one] = maps.checks.findings;
          maps.found({ ...maps.checks, findings: [{ ...one, fix: { ...one.fix, label: 'Cut back Nordfeld 12' } }] });
        }"""
    )
    card = page.get_by_test_id("finding-crosses")
    card.scroll_into_view_if_needed()
    words, whole = card.locator("> .h-sp").bounding_box(), card.bounding_box()
    assert words is not None
    assert whole is not None
    assert words["width"] > 0.55 * whole["width"]
    assert card.evaluate("(node) => node.scrollWidth <= node.clientWidth")


@pytest.mark.long
def test_what_is_drawn_next_after_done_is_drawn_in_sight(show: Show) -> None:
    page = editing(show())
    page.get_by_test_id("editor-tool-rows").click()
    page.get_by_test_id("editor-pen-curve").click()
    line = "{ type: 'LineString', coordinates: [[1, 2], [2, 3]] }"
    page.evaluate(
        "surface.finish = () => { surface.canFinish = false; surface.options.onDrawn("
        f"{{ type: 'Feature', id: 'x', properties: {{}}, geometry: {line} }}) }};"
        " surface.canFinish = true; surface.options.onMeasure('20 m')"
    )
    page.get_by_test_id("editor-pen-recorded").click()
    page.get_by_test_id("unfinished").get_by_role("button", name="Done").click()
    expect(page.get_by_test_id("map-editor")).to_have_attribute("data-tool", "recorded")
    expect(page.get_by_test_id("editor-tool-rows")).to_have_attribute("aria-pressed", "true")
    expect(page.get_by_test_id("editor-hint")).to_be_visible()
