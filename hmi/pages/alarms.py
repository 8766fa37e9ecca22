"""Alarms: figures, the list, one in detail, journal and statistics.

The list comes from the live lane, everything else from REST, which asks for the right again at every act.
"""

from __future__ import annotations

from components.live_element import LiveElement
from hmi.domain.role import Permission
from hmi.pages import bundle
from hmi.pages.services import PageServices
from hmi.security.session_info import SessionInfo

MAY_NOT_SHELVE = "Shelving needs the supervisor role."
MAY_NOT_ACKNOWLEDGE = "You can watch alarms. Acknowledging needs the operator role."


def build(services: PageServices, session: SessionInfo) -> None:
    """Lay out the screen; what a person may not do stays in place with its reason."""
    with LiveElement(
        "hl-screen",
        classes="h-screen",
        data_screen="alarms",
        data_title="Alarms",
        data_code=f"{bundle.script_url('bell')} {bundle.script_url('alarms')}",
    ):
        LiveElement(
            "hl-alarm-screen",
            classes="al-screen",
            hook="alarms",
            data_style=bundle.screen_style_url("alarms"),
            data_may_ack="" if services.refusal(session, Permission.ACKNOWLEDGE_ALARM) else "yes",
            data_may_shelve="" if services.refusal(session, Permission.SHELVE_ALARM) else "yes",
            data_no_ack=MAY_NOT_ACKNOWLEDGE,
            data_no_shelve=MAY_NOT_SHELVE,
        )
