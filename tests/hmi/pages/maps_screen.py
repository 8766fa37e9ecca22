"""The maps screen in a browser, on a played map; the drawing surface is a stand-in but where drawing is asked."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Page, Route, expect

from tests.hmi.pages.conftest import Theatre

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
  fit(all) { this.host.dataset.fit = (all ?? []).map((one) => one.id ?? one).join(' '); this.fitted = all; }
  setFindings(all) { this.host.dataset.findings = all.length; }
  setSnap(isOn) { this.calls.push(['snap', isOn]); }
  unlockBody(isOn) { this.calls.push(['unlock', isOn]); }
  nudge(x, y) { this.calls.push(['nudge', x, y]); }
  setVertex(place) { this.calls.push(['vertex', ...place]); }
  removeVertex() { this.calls.push(['remove']); }
  setTrial(all) { this.host.dataset.trial = all.length; }
  setTurning(degrees) { this.calls.push(['turning', degrees]); }
  setRadius(metres) { this.calls.push(['radius', metres]); return true; }
  finish() { this.calls.push(['finish']); this.canFinish = false; }
  undoPoint() { this.calls.push(['undoPoint']); }
  destroy() { this.host.replaceChildren(); }
}
"""


def stand_in(route: Route) -> None:
    """Answer with a surface that hears and tells, and draws nothing."""
    kind = "text/css" if route.request.url.endswith(".css") else "application/javascript"
    route.fulfill(content_type=kind, body="" if kind == "text/css" else SURFACE)


@pytest.fixture
def show(look: Look, theatre: Theatre) -> Show:
    """Open the maps screen of a map that was set first."""

    def open_screen(*, role: str = "planner", size: str = "landscape", is_new: bool = False, **wish: Any) -> Page:
        theatre.play("running")
        theatre.play_map(anew=True, **wish)
        page = look("/fleet", role=role, size=size, is_new=is_new)
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
    """Tap shapes on the surface."""
    page.evaluate("(ids) => surface.tap(...ids)", list(ids))


def set_field(page: Page, hook: str, value: str) -> None:
    """Enter a value in the panel."""
    page.get_by_test_id(hook).fill(value)
    page.get_by_test_id(hook).press("Enter")


def saved(page: Page, theatre: Theatre, *labels: str) -> dict[str, Any]:
    """Wait until the draft has these changes, oldest first."""
    expect(page.get_by_test_id("editor-changes").locator("li[data-state=saved]")).to_have_count(len(labels))
    heard = theatre.heard_map()
    assert heard["labels"] == list(labels)
    return heard
