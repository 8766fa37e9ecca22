"""The button that opens the demo panel; nothing outside the demo."""

from __future__ import annotations

from components.live_element import LiveElement
from hmi.pages import bundle
from hmi.pages.services import PageServices

SCRIPT = "demo"


def place(services: PageServices, robot_id: str = "") -> None:
    """Place the button; ``robot_id`` is chosen in the panel at first."""
    if services.settings.demo:
        LiveElement("hl-demo-button", data_robot=robot_id, data_style=bundle.screen_style_url(SCRIPT))


def code(services: PageServices, others: str = "") -> str:
    """Return the scripts of a screen, ``others`` first, with the panel's added in the demo."""
    return f"{others} {bundle.script_url(SCRIPT)}".strip() if services.settings.demo else others
