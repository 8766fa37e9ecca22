"""Sensors: field stations on the map, what they measure and how old it is, and whether treatment may go on."""

from __future__ import annotations

from nicegui import ui

from components.live_element import LiveElement
from components.live_map import LiveMap
from hmi.domain.role import Permission
from hmi.pages import bundle, notice
from hmi.pages.services import PageServices
from hmi.security.session_info import SessionInfo


def build(services: PageServices, session: SessionInfo) -> None:
    """Lay out the screen; values come from REST every ten seconds while it is seen, and age in the browser."""
    problem = services.refusal(session, Permission.WATCH)
    if problem:
        notice.build(
            "sensors", "lock", "Sensors of this site are not shared with you.", problem, "/operate", "Choose a robot"
        )
        return
    with LiveElement(
        "hl-screen",
        classes="h-screen sn-screen",
        data_screen="sensors",
        data_title="Sensors",
        data_code=bundle.script_url("sensors"),
        data_screen_style=bundle.screen_style_url("sensors"),
        data_look="loading",
    ):
        LiveElement("hl-sensors", classes="sn-blankscreen")
        LiveElement("hl-sensor-gate", classes="sn-top", hidden="")
        with ui.element("section").classes("sn-map").props('aria-label="Map of stations"'):
            LiveMap(mode="stations", engine=services.map_engine(is_near=True)).classes("h-mapfill")
        LiveElement("hl-sensor-list", classes="sn-side", hook="sensors")
        LiveElement("hl-sensor-values", classes="sn-values")
        LiveElement(
            "hl-sensor-dock", classes="h-dockbar h-actions sn-dock", role="group", aria_label="Actions", hidden=""
        )
