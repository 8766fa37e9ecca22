"""Fleet: every robot on the map and in the list, what several of them are asked, and who is responsible."""

from __future__ import annotations

from nicegui import ui

from components.live_element import LiveElement
from components.live_map import LiveMap
from hmi.pages import bundle, demo_button
from hmi.pages.services import PageServices
from hmi.security.session_info import SessionInfo


def build(services: PageServices, _session: SessionInfo) -> None:
    """Lay out map and list; rows, figures and marks come from the live lane, what is changed goes through REST."""
    style = bundle.screen_style_url("fleet")
    with LiveElement(
        "hl-screen",
        classes="h-screen f-screen",
        data_screen="fleet",
        data_title="Fleet",
        data_code=f"{bundle.script_url('fleet_ground')} {bundle.script_url('fleet')}",
        data_late=demo_button.code(services),
        data_fleet_style=style,
    ):
        with ui.element("section").classes("f-map").props('aria-label="Map"'):
            LiveMap(mode="fleet", engine=services.map_engine(is_near=False)).classes("h-mapfill")
            with ui.element("div").classes("f-over"):
                LiveElement("hl-fleet-layers")
                demo_button.place(services)
            LiveElement("hl-fleet-stop", classes="h-card f-stopcard", hook="fleet-stop", role="status", hidden="")
            LiveElement("hl-fleet-kpis", classes="h-card f-kpis", hook="fleet-kpis")
        with ui.element("aside").classes("f-side").props('aria-label="Robots"'):
            LiveElement("hl-fleet", classes="f-fleet", hook="fleet")
        LiveElement("hl-fleet-dock", classes="h-dockbar f-dock", hook="fleet-dock")
