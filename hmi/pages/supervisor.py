"""Supervisor: what the robot's state machine does and why, its nodes, and what it can do now."""

from __future__ import annotations

from components.live_element import LiveElement
from hmi.domain.ids import is_id
from hmi.domain.role import Permission
from hmi.pages import bundle, notice
from hmi.pages.services import PageServices
from hmi.security.session_info import SessionInfo


def build(services: PageServices, session: SessionInfo, robot_id: str, mission_id: str = "") -> None:
    """Lay out the screen of one robot, with the times of one of its missions if that is named.

    A robot nobody ever heard of gets a notice instead.
    """
    robot = services.fleet.robot(robot_id) if is_id(robot_id) else None
    if robot is None:
        name = robot_id if is_id(robot_id) else "this address"
        text = "It was never heard of here. Check the name."
        notice.build("supervisor", "help", f"No robot {name}", text, "/supervisor", "Choose a robot")
        return
    problem = services.refusal(session, Permission.WATCH, robot_id)
    if problem:
        notice.build("supervisor", "lock", f"You may not watch {robot.name}", problem, "/fleet", "Fleet")
        return
    with LiveElement(
        "hl-screen",
        classes="h-screen s-screen",
        data_screen="supervisor",
        data_robot=robot_id,
        data_title=robot.name,
        data_mission=mission_id if is_id(mission_id) else "",
        data_code=" ".join(bundle.script_url(name) for name in ("machine", "machine_dock", "supervisor")),
        data_layout=bundle.script_url("chart_layout"),
        data_screen_style=f"{bundle.screen_style_url('supervisor')} {bundle.screen_style_url('machine_dock')}",
    ):
        LiveElement("hl-super")
        LiveElement("hl-super-dock", classes="h-dockbar h-actions", role="group", aria_label="Actions")


def pick(services: PageServices, session: SessionInfo) -> None:
    """Let the browser open the robot it showed last, else offer those there are."""
    known = [r for r in services.fleet.robots() if not services.refusal(session, Permission.WATCH, r.id)]
    with LiveElement("hl-screen", classes="h-screen", data_screen="supervisor", data_title="Supervisor"):
        LiveElement(
            "hl-pick-robot", classes="h-scroll", data_known=" ".join(sorted(r.id for r in known if r.is_registered))
        )
