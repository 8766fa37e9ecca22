"""Maps: the farm map as it is published, and its draft with the drawing tools.

The browser draws it from REST, which asks for the right again at every change.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

from nicegui import __version__ as nicegui_version
from nicegui.dependencies import register_resource

from components.live_element import LiveElement
from hmi.domain.role import Permission
from hmi.pages import bundle
from hmi.pages.services import PageServices
from hmi.security.session_info import SessionInfo

MAY_NOT_EDIT = "You cannot publish maps. Needs the planner role."


def build(services: PageServices, session: SessionInfo) -> None:
    """Lay out the screen; what a person may not do stays in place with its reason."""
    LiveElement(
        "hl-maps",
        classes="m-screen",
        hook="maps",
        data_farm=services.settings.farm_name,
        data_may_edit="" if services.refusal(session, Permission.EDIT_MAP) else "yes",
        data_may_take="" if services.refusal(session, Permission.TAKE_LEASE) else "yes",
        data_no_edit=MAY_NOT_EDIT,
        data_scripts=_folder_url(bundle.STATIC / "js"),
        data_vendor=_folder_url(bundle.STATIC / "vendor" / "maplibre"),
        data_style=bundle.screen_style_url("maps"),
    )


@cache
def _folder_url(folder: Path) -> str:
    """Serve ``folder`` under an address that changes when a file in it does, so that browsers may keep it for good."""
    newest = max(path.stat().st_mtime for path in folder.rglob("*"))
    resource = register_resource(folder, max_time=newest)
    return f"/_nicegui/{nicegui_version}/resources/{resource.key}"
