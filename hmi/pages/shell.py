"""The one page of the console: frame, banners, STOP root and live lane; screens change inside it.

Moving between screens replaces only what is in the middle. STOP, the sockets and the banner stay.
"""

from __future__ import annotations

import json
from collections.abc import Callable

from nicegui import ui

from components.live_element import LiveElement
from hmi.domain.role import PERMISSIONS
from hmi.pages import admin, bundle, fleet, login, operate, rail, top_bar
from hmi.pages.services import PageServices, Visitor

TITLE = "Headland"
RECONNECT_S = 30.0  # a draft survives a ten second outage; our own heartbeat shows the outage after one second


def shell(services: PageServices) -> Callable[[], None]:
    """Return the root function for ``ui.run_with``."""

    def root() -> None:
        visitor = services.visitor(ui.context.client.request)
        _head(services, visitor)
        with ui.element("div").classes("h-app").props(f'data-screen={"start" if visitor else "login"}'):
            top_bar.build(services, visitor)
            if visitor is not None:
                rail.build(visitor)
            with ui.element("main").classes("h-main"):
                LiveElement("hl-link-banner", hook="link-banner", data_state="ok", role="alert")
                _screens(services, visitor)
            ui.element("footer").classes("h-dock")
        LiveElement("hl-toasts", classes="h-toasts", hook="toast", role="status", aria_live="polite")

    return root


def _screens(services: PageServices, visitor: Visitor | None) -> None:
    if visitor is None:
        login.build(services)
        return
    ui.sub_pages(
        {
            "/": lambda: operate.pick(services, visitor),
            "/operate": lambda: operate.pick(services, visitor),
            "/operate/{robot}": lambda robot: operate.build(services, visitor, robot),
            "/fleet": lambda: fleet.build(services, visitor),
            "/missions": lambda: _missions(services, visitor),
            "/admin": lambda: admin.build(services, visitor),
            "/login": lambda: operate.pick(services, visitor),
        }
    )


def _missions(services: PageServices, visitor: Visitor) -> None:
    from hmi.pages import missions

    with LiveElement("hl-screen", classes="h-screen", data_screen="missions", data_title="Missions"):
        missions.build(services, visitor)


def _head(services: PageServices, visitor: Visitor | None) -> None:
    text = json.dumps(_config(services, visitor)).replace("<", "\\u003c")
    ui.add_head_html(
        f"<script>window.HEADLAND={text}</script>"
        f'<script src="{bundle.versioned("js/boot.js")}"></script>'
        f'<link rel="stylesheet" href="{bundle.style_url()}">'
        f'<link rel="preload" href="{bundle.versioned("fonts/inter-latin.woff2")}" as="font" crossorigin>'
        f'<script defer src="{bundle.versioned("js/lane.js")}"></script>'
        f'<script defer src="{bundle.script_url()}"></script>'
    )


def _config(services: PageServices, visitor: Visitor | None) -> dict[str, object]:
    settings = services.settings
    return {
        "user": visitor and {"id": visitor.user_id, "name": visitor.user_name, "role": visitor.role.value},
        "rights": sorted(p.value for p in PERMISSIONS[visitor.role]) if visitor else [],
        "session": visitor.session_id if visitor else "",
        "csrf": visitor.csrf if visitor else "",
        "device": visitor.device_name if visitor else "",
        "lane": "/live",
        "api": "/api/v1",
        "stop": {"url": services.stop.public_url, "port": services.stop.port},
        "farm": settings.farm_name,
        "demo": settings.demo,
    }
