"""A page-opening storm: what a console that builds a heavy page every half second does to its own loop."""

from __future__ import annotations

PERIOD_S = 0.5
ROWS = 300  # builds in about 0.3 s


def heavy_page() -> None:
    """Build one heavy page, as a screen with a long table would be, and throw it away."""
    from nicegui import Client, ui
    from nicegui.page import page

    with Client(page("/storm"), request=None) as client:
        for number in range(ROWS):
            with ui.row():
                ui.label(f"row {number}")
                ui.button(f"button {number}")
    client.delete()
