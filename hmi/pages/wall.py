"""Wall mode: the fleet in big type beside its map, read across a room. It only shows; STOP works as everywhere."""

from __future__ import annotations

from nicegui import ui

from components.live_element import LiveElement
from components.live_map import LiveMap
from hmi.pages import bundle
from hmi.pages.services import PageServices
from hmi.security.session_info import SessionInfo


def build(services: PageServices, _session: SessionInfo) -> None:
    """Lay out list, map and figures."""
    with LiveElement(
        "hl-screen",
        classes="h-screen w-screen",
        data_screen="wall",
        data_title="Fleet",
        data_code=f"{bundle.script_url('fleet_ground')} {bundle.script_url('fleet')}",
        data_fleet_style=bundle.screen_style_url("fleet"),
    ):
        LiveElement("hl-wall", classes="w-side", hook="wall")
        with ui.element("section").classes("f-map").props('aria-label="Map"'):
            LiveMap(mode="fleet", has_buttons=False, engine=services.map_engine(is_near=False)).classes("h-mapfill")
            LiveElement("hl-fleet-layers", classes="w-hidden")
            LiveElement("hl-fleet-stop", classes="h-card f-stopcard", hook="fleet-stop", role="status", hidden="")
            LiveElement("hl-fleet-kpis", classes="h-card f-kpis", hook="fleet-kpis")
