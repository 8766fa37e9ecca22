"""Fleet: every robot with its state, why it waits, link and battery."""

from __future__ import annotations

from components.live_element import LiveElement
from hmi.pages import demo_button
from hmi.pages.services import PageServices
from hmi.security.session_info import SessionInfo


def build(services: PageServices, session: SessionInfo) -> None:
    """Lay out the list; the rows come from the live lane."""
    with LiveElement(
        "hl-screen", classes="h-screen", data_screen="fleet", data_title="Fleet", data_code=demo_button.code(services)
    ):
        demo_button.place(services)
        LiveElement("hl-fleet", classes="h-scroll h-fleet", hook="fleet")
        LiveElement(
            "hl-dock-hint", classes="h-dockbar", data_text="Open a robot to operate it.|This corner stops all robots."
        )
