"""Sign-in: a person and a PIN on enrolled tablets, a name and a password everywhere."""

from __future__ import annotations

from components.live_element import LiveElement
from hmi.pages.services import PageServices


def build(services: PageServices) -> None:
    """Lay out the form; the browser posts it to ``/api/v1/session`` and reloads, so that the cookie is set first."""
    with LiveElement("hl-screen", classes="h-screen h-loginscreen", data_screen="login", data_title="Sign in"):
        LiveElement("hl-login", classes="h-login h-card", data_farm=services.settings.farm_name)
        LiveElement(
            "hl-dock-hint",
            classes="h-dockbar",
            data_text="STOP works before sign-in on enrolled tablets.|Reset and resume need a person.",
        )
