"""Navigation by role: only screens that exist, only those a role may open."""

from __future__ import annotations

from dataclasses import dataclass

from nicegui import ui

from components.icon import icon
from hmi.domain.role import Permission, Role, may
from hmi.security.session_info import SessionInfo


@dataclass(frozen=True, slots=True)
class Destination:
    """One entry of the rail; ``needs`` is the right that opens the screen."""

    name: str
    label: str
    icon: str
    path: str
    needs: Permission


DESTINATIONS = (
    Destination("operate", "Operate", "gamepad", "/operate", Permission.WATCH),
    Destination("fleet", "Fleet", "lists", "/fleet", Permission.WATCH),
    Destination("cameras", "Cameras", "grid_view", "/cameras", Permission.WATCH),
    Destination("maps", "Maps", "polyline", "/maps", Permission.WATCH),
    Destination("twin", "Twin", "deployed_code", "/twin", Permission.WATCH),
    Destination("missions", "Missions", "route", "/missions", Permission.WATCH),
    Destination("alarms", "Alarms", "notifications", "/alarms", Permission.WATCH),
    Destination("supervisor", "Supervisor", "account_tree", "/supervisor", Permission.WATCH),
    Destination("sensors", "Sensors", "sensors", "/sensors", Permission.WATCH),
    Destination("admin", "Admin", "tune", "/admin", Permission.MANAGE_USERS),
)


def destinations(role: Role) -> tuple[Destination, ...]:
    """Return what a role sees, in order."""
    return tuple(d for d in DESTINATIONS if may(role, d.needs))


def build(session: SessionInfo) -> None:
    """Lay out the rail; in portrait the style sheet moves it into the dock."""
    with ui.element("nav").classes("h-rail").props('aria-label="Main"'):
        for place in destinations(session.role):
            link = ui.element("a").classes("h-nav").props(f"href={place.path} data-nav={place.name}")
            with link.props(f"data-testid=nav-{place.name}"):
                ui.html(icon(place.icon), sanitize=False)
                ui.label(place.label)
