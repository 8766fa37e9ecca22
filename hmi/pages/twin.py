"""Twin: one robot in 3D, where it is, how it stands, what it is about to do; live and replayed."""

from __future__ import annotations

from nicegui import ui

from components.live_element import LiveElement
from components.live_map import LiveMap
from hmi.domain.ids import is_id
from hmi.domain.role import Permission
from hmi.pages import bundle, notice
from hmi.pages.services import PageServices
from hmi.security.session_info import SessionInfo

NO_REPLAY = "Replay needs the supervisor role."


def build(services: PageServices, session: SessionInfo, robot_id: str) -> None:
    """Lay out the screen of one robot; a robot nobody ever heard of gets a notice instead."""
    robot = services.fleet.robot(robot_id) if is_id(robot_id) else None
    if robot is None:
        name = robot_id if is_id(robot_id) else "this address"
        notice.build(
            "twin", "help", f"No robot {name}", "It was never heard of here. Check the name.", "/twin", "Choose a robot"
        )
        return
    problem = services.refusal(session, Permission.WATCH, robot_id)
    if problem:
        notice.build("twin", "lock", f"You may not watch {robot.name}", problem, "/fleet", "Fleet")
        return
    with LiveElement(
        "hl-screen",
        classes="h-screen t-screen",
        data_screen="twin",
        data_robot=robot_id,
        data_title=robot.name,
        data_code=" ".join(bundle.script_url(name) for name in ("machine", "machine_dock", "twin")),
        data_screen_style=f"{bundle.screen_style_url('twin')} {bundle.screen_style_url('machine_dock')}",
    ):
        with ui.element("section").classes("t-picture").props('aria-label="3D picture"'):
            LiveElement(
                "hl-twin",
                classes="t-twin",
                hook="twin",
                data_state="connecting",
                data_robot=robot_id,
                data_no_replay="" if not services.refusal(session, Permission.REPLAY, robot_id) else NO_REPLAY,
                data_may_model="" if services.refusal(session, Permission.MANAGE_ROBOTS, robot_id) else "yes",
            )
            with ui.element("div").classes("t-map").props("hidden"):
                LiveMap(robot_id, engine=services.map_engine(is_near=True)).classes("h-mapfill")
        with ui.element("aside").classes("h-side t-side").props('aria-label="Joints and values"'):
            LiveElement("hl-twin-alarm", hook="twin-alarm", data_right=Permission.ACKNOWLEDGE_ALARM.value, hidden="")
            LiveElement("hl-twin-side", classes="t-sidebox")
        LiveElement("hl-super-dock", classes="h-dockbar h-actions", role="group", aria_label="Actions")


def pick(services: PageServices, session: SessionInfo) -> None:
    """Let the browser open the robot it showed last, else offer those there are."""
    known = [r for r in services.fleet.robots() if not services.refusal(session, Permission.WATCH, r.id)]
    with LiveElement("hl-screen", classes="h-screen", data_screen="twin", data_title="Twin"):
        LiveElement(
            "hl-pick-robot", classes="h-scroll", data_known=" ".join(sorted(r.id for r in known if r.is_registered))
        )
