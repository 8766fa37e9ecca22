"""The one page of the console: frame, banners, STOP root and live lane; screens change inside it.

Moving between screens replaces only what is in the middle. STOP, the sockets and the banner stay.
"""

from __future__ import annotations

import json
from collections.abc import Callable

from nicegui import ui

from components import stop_slab
from components.live_element import LiveElement
from hmi.domain.role import PERMISSIONS
from hmi.pages import (
    admin,
    alarms,
    bundle,
    cameras,
    fleet,
    login,
    maps,
    missions,
    operate,
    rail,
    sensors,
    supervisor,
    top_bar,
    twin,
    wall,
)
from hmi.pages.routed import RoutedScreens
from hmi.pages.services import PageServices
from hmi.security.session_info import SessionInfo

TITLE = "Headland"
RECONNECT_S = 30.0  # a draft survives a ten second outage; our own heartbeat shows the outage after one second


def shell(services: PageServices) -> Callable[[], None]:
    """Return the root function for ``ui.run_with``."""

    def root() -> None:
        session = services.session()
        _head(services, session)
        with ui.element("div").classes("h-app").props(f"data-screen={_first(session)}"):
            top_bar.build(services, session)
            if session is not None:
                rail.build(session)
            with ui.element("main").classes("h-main"):
                LiveElement("hl-link-banner", hook="link-banner", data_state="ok", role="alert")
                _screens(services, session)
            ui.element("footer").classes("h-dock")
        if session is not None:
            LiveElement("hl-alarm-voice", classes="h-vh")
        LiveElement("hl-toasts", classes="h-toasts", hook="toast", role="status", aria_live="polite")

    return root


def _first(session: SessionInfo | None) -> str:
    """Return what the frame is laid out for until the screen has announced itself: a wall screen has no rail."""
    if session is None:
        return "login"
    request = ui.context.client.request
    return "wall" if request is not None and request.url.path == "/wall" else "start"


def _screens(services: PageServices, session: SessionInfo | None) -> None:
    if session is None:
        login.build(services)
        return
    RoutedScreens(
        {
            "/": lambda: operate.pick(services, session),
            "/operate": lambda: operate.pick(services, session),
            "/operate/{robot}": lambda robot: operate.build(services, session, robot),
            "/fleet": lambda: fleet.build(services, session),
            "/wall": lambda: wall.build(services, session),
            "/cameras": lambda: cameras.build(services, session),
            "/maps": lambda: _maps(services, session),
            "/missions": lambda: _missions(services, session),
            "/alarms": lambda: alarms.build(services, session),
            "/supervisor": lambda: supervisor.pick(services, session),
            "/supervisor/{robot}": lambda robot, mission="": supervisor.build(services, session, robot, mission),
            "/sensors": lambda: sensors.build(services, session),
            "/twin": lambda: twin.pick(services, session),
            "/twin/{robot}": lambda robot: twin.build(services, session, robot),
            "/admin": lambda: admin.build(services, session),
            "/login": lambda: operate.pick(services, session),
        }
    )


def _maps(services: PageServices, session: SessionInfo) -> None:
    code = bundle.script_url("maps")
    with LiveElement("hl-screen", classes="h-screen", data_screen="maps", data_title="Maps", data_code=code):
        maps.build(services, session)


def _missions(services: PageServices, session: SessionInfo) -> None:
    code = f"{bundle.script_url('run')} {bundle.script_url('draw')} {bundle.script_url('missions')}"
    with LiveElement("hl-screen", classes="h-screen", data_screen="missions", data_title="Missions", data_code=code):
        missions.build(services, session)


def _head(services: PageServices, session: SessionInfo | None) -> None:
    text = json.dumps(_config(services, session)).replace("<", "\\u003c")
    ui.add_head_html(
        f"<script>window.HEADLAND={text}</script>"
        f'<script src="{bundle.versioned("js/boot.js")}"></script>'
        f'<link rel="stylesheet" href="{bundle.style_url()}">{bundle.case_links()}'
        f'<link rel="preload" href="{bundle.versioned("fonts/inter-latin.woff2")}" as="font" crossorigin>'
        f"{stop_slab.head_html(_stop(services, session), address=bundle.versioned)}"
        f'<script defer src="{bundle.versioned("js/lane.js")}"></script>'
        f'<script defer src="{bundle.script_url()}"></script>'
    )


def _stop(services: PageServices, session: SessionInfo | None) -> stop_slab.StopConfig:
    """STOP has its own way out; it works on the sign-in page of an enrolled tablet too."""
    return stop_slab.StopConfig(
        base=services.stop.public_url or "",
        port=services.stop.port,
        csrf=session.csrf if session else "",
        note="" if session else "no sign-in needed",
    )


def _config(services: PageServices, session: SessionInfo | None) -> dict[str, object]:
    settings = services.settings
    return {
        "user": session and {"id": session.user_id, "name": session.user_name, "role": session.role.value},
        "rights": sorted(p.value for p in PERMISSIONS[session.role]) if session else [],
        "session": session.session_id if session else "",
        "csrf": session.csrf if session else "",
        "device": session.device_name if session else "",
        "lanePath": "/live",
        "apiPath": "/api/v1",
        "farm": settings.farm_name,
        "demo": settings.demo,
        **({"watermark": True} if settings.picture_watermark else {}),
    }
