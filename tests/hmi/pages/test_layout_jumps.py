"""What is on a screen stays where it came first: no jump while styles and first values arrive late."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Page, Route, expect

from tests.hmi.pages.conftest import Theatre

pytestmark = pytest.mark.browser
Look = Callable[..., Page]
MOST = 0.05
WATCH = """window.shifts = 0; new PerformanceObserver((list) => {
  for (const one of list.getEntries()) if (!one.hadRecentInput) window.shifts += one.value;
}).observe({ type: "layout-shift", buffered: true });"""


@pytest.mark.parametrize(
    ("path", "style", "there"),
    [
        ("/fleet", "fleet", "[data-testid=fleet-kpis] b"),
        ("/wall", "fleet", "[data-testid=wall-sum]:not(:empty)"),
        ("/twin/planter-09", "twin", ".t-over button"),
    ],
)
def test_nothing_jumps_when_the_style_of_a_screen_comes_late(
    look: Look, theatre: Theatre, path: str, style: str, there: str
) -> None:
    theatre.play("running")
    theatre.machine(mode="auto")
    page = look("/operate/weeder-07", role="supervisor", is_new=True)
    page.add_init_script(WATCH)
    held: list[Route] = []
    is_open = False
    page.route(f"**/bundle/{style}.css*", lambda route: route.continue_() if is_open else held.append(route))
    page.goto(path, wait_until="commit")
    page.wait_for_function("() => customElements.get('hl-screen')")
    for _ in range(3):  # frames are laid out meanwhile
        page.evaluate("() => new Promise(requestAnimationFrame)")
    is_open = True
    while held:
        held.pop().continue_()
    expect(page.locator(there).first).to_be_visible()
    shifts: Any = page.evaluate("window.shifts")
    theatre.machine(off=True)
    assert shifts < MOST


def test_the_values_below_the_mission_stay_where_they_are_when_it_comes(look: Look, theatre: Theatre) -> None:
    theatre.play("running")
    page = look("/fleet", is_new=True)
    page.add_init_script(
        "addEventListener('DOMContentLoaded', () => { const watch = () => {"
        " const one = document.querySelector('.h-tiles');"
        " if (one) (window.tops ??= new Set()).add(Math.round(one.getBoundingClientRect().top));"
        " requestAnimationFrame(watch); }; watch(); });"
    )
    page.goto("/operate/weeder-07")
    expect(page.get_by_test_id("value-row")).not_to_have_text("")
    tops: list[int] = page.evaluate("[...window.tops]")
    assert max(tops) - min(tops[1:] or tops) <= 60, tops
