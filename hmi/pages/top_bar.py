"""Top bar: logo, robot, mode, state, mission; sound, link delay, alarms, theme, clock, person."""

from __future__ import annotations

from nicegui import ui

from components.live_element import LiveElement
from components.mode_chip import ModeChip
from hmi.pages import bundle
from hmi.pages.services import PageServices
from hmi.security.session_info import SessionInfo

LOGO = (
    '<svg width="40" height="40" viewBox="0 0 40 40" fill="none" stroke="currentColor" stroke-width="3.4" '
    'stroke-linecap="round" role="img" aria-label="Headland"><path d="M7 33V14a6.5 6.5 0 0 1 13 0v12a6.5 6.5 0 0 0 '
    '13 0V7"/><path d="M28.5 10.5 33 5.5l4.5 5" stroke-linejoin="round"/></svg>'
)


def build(services: PageServices, session: SessionInfo | None) -> None:
    """Lay out the bar; without a person only name, link, theme and clock."""
    with ui.element("header").classes("h-top"):
        ui.html(LOGO, sanitize=False).classes("h-logo")
        if session is not None:
            LiveElement("hl-robot-switch")
            ModeChip()
            LiveElement("hl-mission-name", classes="h-2 h-t14 h-ell")
        title = LiveElement("hl-title", classes="h-title h-t18 h-b", data_farm=services.settings.farm_name)
        if session is None:
            title.props("data-fixed=Headland")
        ui.element("span").classes("h-sp")
        if session is not None:
            LiveElement("hl-alarm-sound", hook="alarm-sound")
            LiveElement("hl-link")
            LiveElement("hl-alarms", hook="alarm-counts", data_code=bundle.script_url("bell"))
        LiveElement("hl-theme")
        LiveElement("hl-clock")
        if session is not None:
            LiveElement("hl-user")
