"""A whole screen that says one thing: empty, not allowed, or not found, and what to do."""

from __future__ import annotations

from nicegui import ui

from components.icon import icon as glyph
from components.live_element import LiveElement


def build(screen: str, icon: str, head: str, text: str, href: str = "", action: str = "") -> None:
    """Lay out the notice; ``href`` and ``action`` add the one way on."""
    with (
        LiveElement("hl-screen", classes="h-screen", data_screen=screen, data_title=head),
        ui.element("div").classes("h-notice h-card").props("data-testid=notice"),
    ):
        ui.html(glyph(icon, "l"), sanitize=False)
        ui.label(head).classes("h-t22 h-b")
        ui.label(text).classes("h-t16 h-2")
        if href:
            with ui.element("a").classes("h-btn").props(f"href={href}"):
                ui.label(action)
