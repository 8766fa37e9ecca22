"""What a person does with a finger, on a machine that may be busy."""

from __future__ import annotations

from playwright.sync_api import Locator, Page, expect

TRIES = 6
HELD_MS = 1500


def hold(page: Page, pad: Locator) -> None:
    """Put a finger on a pad of hold-to-run and leave it there once the pad is held.

    A press at a moment at which the page was late is refused, as it must be, and a person presses again.
    """
    for _ in range(TRIES):
        pad.hover()  # waits until it has come to rest
        page.mouse.down()
        try:
            expect(pad).to_have_attribute("data-state", "held", timeout=HELD_MS)
        except AssertionError:
            page.mouse.up()
        else:
            return
    raise AssertionError(f"it is not held: {pad.inner_text()}")
