"""Cameras: the pictures of all robots on one wall, attention first, each as old as it says."""

from __future__ import annotations

from components.live_element import LiveElement
from hmi.domain.role import Permission
from hmi.pages import bundle, notice
from hmi.pages.services import PageServices
from hmi.security.session_info import SessionInfo

CODE = ("fleet_ground", "machine", "camera", "cameras")


def build(services: PageServices, session: SessionInfo) -> None:
    """Lay out wall and dock; the pictures come over a socket of their own, and only those that can be seen."""
    problem = services.refusal(session, Permission.WATCH)
    if problem:
        notice.build("cameras", "lock", "Video of this site is not shared with you.", problem, "/fleet", "Fleet")
        return
    with LiveElement(
        "hl-screen",
        classes="h-screen c-screen",
        data_screen="cameras",
        data_title="Cameras",
        data_code=" ".join(map(bundle.script_url, CODE)),
        data_screen_style=bundle.screen_style_url("cameras"),
    ):
        LiveElement("hl-cameras", classes="c-wall", hook="cameras")
        LiveElement("hl-cameras-dock", classes="h-dockbar h-actions c-dock", role="group", aria_label="Actions")
