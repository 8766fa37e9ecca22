"""Admin: robots and new ones to accept, cameras, people, tablets, notifications, cloud, audit, diagnostics."""

from __future__ import annotations

from nicegui import ui

from components.icon import icon
from components.live_element import LiveElement
from hmi.domain.role import Permission
from hmi.pages import bundle, notice
from hmi.pages.services import PageServices
from hmi.security.session_info import SessionInfo

SECTIONS = (
    ("robots", "Robots", "smart_toy"),
    ("cameras", "Cameras", "videocam"),
    ("people", "People", "group"),
    ("tablets", "Tablets", "tablet"),
    ("notifications", "Notifications", "notifications"),
    ("limits", "Alarm limits", "tune"),
    ("cloud", "Cloud", "cloud"),
    ("audit", "Audit log", "history"),
    ("diagnostics", "Diagnostics", "monitoring"),
)


def build(services: PageServices, session: SessionInfo) -> None:
    """Lay out the sections; everything they change goes through REST, which asks for the right again."""
    if services.refusal(session, Permission.MANAGE_USERS):
        notice.build("admin", "lock", "Admins only", "Ask an admin of this farm.", "/operate", "Operate")
        return
    with LiveElement(
        "hl-screen",
        classes="h-screen h-admin",
        data_screen="admin",
        data_title="Admin",
        data_code=bundle.script_url("admin"),
    ):
        with ui.element("div").classes("h-tabs h-seg").props('role="group" aria-label="Section"'):
            for name, label, sign in SECTIONS:
                with ui.element("button").props(f"type=button data-tab={name} data-testid=admin-tab-{name}"):
                    ui.html(f"{icon(sign, 'm')}{label}", sanitize=False, tag="span").classes("h-row")
        LiveElement("hl-admin", classes="h-scroll", data_style=bundle.screen_style_url("admin"))
        LiveElement(
            "hl-dock-hint",
            classes="h-dockbar",
            data_text="Changes are written to the audit log.|This corner stops all robots.",
        )
