"""What the cloud wants changed, on the maps screen: listed, taken into a draft, refused."""

from __future__ import annotations

import re
from typing import Any

import pytest
from playwright.sync_api import expect

from tests.hmi.pages.conftest import Theatre
from tests.hmi.pages.maps_screen import Show
from tests.hmi.pages.maps_screen import show as show

pytestmark = pytest.mark.browser


def wish(feature_id: str, name: str, text: str, **more: Any) -> dict[str, Any]:
    """Return a proposal as REST tells it."""
    ring = [[8.0, 51.0], [8.01, 51.0], [8.01, 51.01], [8.0, 51.0]]
    after = {"type": "Feature", "id": feature_id, "geometry": {"type": "Polygon", "coordinates": [ring]},
             "properties": {"id": feature_id, "kind": "parcel", "name": name}}  # fmt: skip
    plain = {"id": feature_id, "kind": "parcel", "name": name, "what": "changed", "text": text, "problem": "",
             "in_draft_by": "", "utc": "2026-05-12T07:30:00+00:00", "before": after, "after": after}  # fmt: skip
    return {**plain, **more}


def test_a_change_from_the_cloud_is_taken_into_a_draft_by_a_person_and_by_nobody_else(
    show: Show, theatre: Theatre
) -> None:
    wishes = [
        wish("nordfeld", "Nordfeld", "Corner 2 moved 21 m"),
        wish("new-1", "Somewhere", "", problem="A parcel cannot be a Point.", what="added", before=None),
    ]
    page = show(proposals=wishes)
    place = page.get_by_test_id("map-proposals")
    expect(place).to_contain_text("From the cloud: 2 changes")
    expect(page.get_by_test_id("proposal-nordfeld")).to_contain_text("Corner 2 moved 21 m")
    expect(page.get_by_test_id("proposal-new-1")).to_contain_text("Cannot be taken: A parcel cannot be a Point.")
    expect(page.get_by_test_id("proposal-take-new-1")).to_be_disabled()
    expect(page.get_by_test_id("maps")).to_have_attribute("data-state", "published")
    expect(place).to_contain_text("Nothing of it is on your map.")
    editor, look = page.get_by_test_id("map-editor"), page.get_by_test_id("proposal-show-nordfeld")
    look.click()
    expect(editor).to_have_attribute("data-trial", "1")  # the shape that the cloud has, beside ours
    expect(editor).to_have_attribute("data-fit", "nordfeld nordfeld")
    expect(look).to_have_text(re.compile("Hide"))
    look.click()
    expect(editor).to_have_attribute("data-trial", "0")
    look.click()
    page.get_by_test_id("proposal-take-nordfeld").click()
    expect(page.get_by_test_id("toast")).to_contain_text("Nordfeld is in your draft")
    expect(look).to_have_text(re.compile("Show"))  # what was looked at is on the map now
    expect(page.get_by_test_id("maps")).to_have_attribute("data-state", "draft")
    expect(page.get_by_test_id("proposal-nordfeld")).to_contain_text("it stays here until it is published")
    expect(page.get_by_test_id("editor-changes")).to_contain_text("From the cloud: Nordfeld")
    page.get_by_test_id("editor-undo").click()
    expect(page.get_by_test_id("proposal-nordfeld")).not_to_contain_text("In the draft")
    page.get_by_test_id("proposal-refuse-new-1").click()
    page.get_by_test_id("proposal-refuse").get_by_role("button", name="Refuse").click()
    expect(place).to_contain_text("From the cloud: 1 change")
    taken = [one["path"] for one in theatre.heard_map()["asked"] if one["path"].startswith("proposals/")]
    assert taken == ["proposals/nordfeld/take", "proposals/new-1/refuse"]
