"""Missions: those stored, one in detail with its field, and planning a new one.

The browser draws it from REST, which asks for the right again at every change.
"""

from __future__ import annotations

from components.live_element import LiveElement
from hmi.domain.role import Permission
from hmi.pages import bundle
from hmi.pages.services import PageServices
from hmi.security.session_info import SessionInfo

MAY_NOT_SEND = "You can watch missions. Sending needs the operator role."
MAY_NOT_EDIT = "You can start missions, not change them."


def build(services: PageServices, session: SessionInfo) -> None:
    """Lay out the screen; what a person may not do stays in place with its reason."""
    LiveElement(
        "hl-missions",
        classes="h-missions",
        hook="missions",
        data_may_edit="" if services.refusal(session, Permission.EDIT_MISSION) else "yes",
        data_may_send="" if services.refusal(session, Permission.SEND_MISSION) else "yes",
        data_has_cloud="yes" if services.settings.cloud_url else "",
        data_plan_style=bundle.screen_style_url("plan"),
        data_no_edit=MAY_NOT_EDIT,
        data_no_send=MAY_NOT_SEND,
        data_style=bundle.screen_style_url("queue"),
    )
    LiveElement(
        "hl-dock-hint",
        classes="h-dockbar",
        data_text="Sending does not move the robot: the person on site starts it with a slide.|"
        "This corner stops all robots.",
    )
