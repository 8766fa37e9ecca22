"""A draft on the maps screen: publishing, the lock, offline, going back."""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

from tests.hmi.pages.conftest import Theatre
from tests.hmi.pages.maps_screen import Show, choose, editing, saved, set_field
from tests.hmi.pages.maps_screen import show as show

pytestmark = pytest.mark.browser
SAVING_TAKES_LONG = """() => {
  const { api } = HL.port;
  HL.port.api = async (method, path, ...more) => {
    if (path.endsWith('/transactions')) await new Promise((done) => setTimeout(done, 1000));
    return api(method, path, ...more);
  };
}"""
NEWS_BEFORE_ANSWER = """() => {
  const { api } = HL.port;
  HL.port.api = async (method, path, ...more) => {
    const answer = await api(method, path, ...more);
    if (path.endsWith('/publish')) await document.querySelector('hl-maps').stillMine();
    return answer;
  };
}"""
"""The live lane tells everybody that a map was published, and may be faster than the answer to who published."""


def test_publishing_asks_for_a_note_and_makes_the_next_version(show: Show, theatre: Theatre) -> None:
    page = editing(show())
    expect(page.get_by_test_id("editor-reason")).to_have_text("Nothing is changed yet.")
    choose(page, "nordfeld")
    page.evaluate(SAVING_TAKES_LONG)
    set_field(page, "feature-status", "BBCH 16")
    page.get_by_test_id("editor-publish").click()
    expect(page.get_by_test_id("publish-note")).to_have_value("Nordfeld 12: status BBCH 14 to BBCH 16")
    page.get_by_test_id("publish-note").fill("Second weeding")
    page.evaluate(NEWS_BEFORE_ANSWER)
    page.get_by_test_id("publish-go").click()
    expect(page.get_by_test_id("toast")).to_contain_text("v15 is published")
    expect(page.get_by_text("This draft is closed.")).to_have_count(0)
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


@pytest.mark.long
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
