"""Operate: one robot, its map, its values, and what can be asked of it."""

from __future__ import annotations

from nicegui import ui

from components.action_dock import ActionDock
from components.hold_to_drive import HoldToDrive
from components.icon import icon
from components.live_element import LiveElement
from components.live_map import LiveMap
from components.mission_card import MissionCard
from components.state_path import StatePath
from components.telemetry_tile import TelemetryTile
from hmi.domain.ids import is_id
from hmi.domain.role import Permission
from hmi.pages import bundle, demo_button, notice
from hmi.pages.services import PageServices
from hmi.presenters.tiles import layout
from hmi.security.session_info import SessionInfo


def build(services: PageServices, session: SessionInfo, robot_id: str) -> None:
    """Lay out the screen of one robot; a robot nobody ever heard of gets a notice instead."""
    robot = services.fleet.robot(robot_id) if is_id(robot_id) else None
    if robot is None:
        _unknown(robot_id)
        return
    problem = services.refusal(session, Permission.WATCH, robot_id)
    if problem:
        notice.build("operate", "lock", f"You may not watch {robot.name}", problem, "/fleet", "Fleet")
        return
    with LiveElement(
        "hl-screen",
        classes="h-screen h-operate",
        data_screen="operate",
        data_robot=robot_id,
        data_title=robot.name,
        data_late=demo_button.code(services, f"{bundle.script_url('run')} {bundle.script_url('camera_door')}"),
        data_draw=bundle.script_url("draw"),
        data_screen_style=bundle.screen_style_url("cameras"),
    ):
        with ui.element("section").classes("h-map").props('aria-label="Map"'):
            LiveElement("hl-alarm-strip", hook="alarm-strip", data_right="acknowledge_alarm", hidden="")
            LiveMap(robot_id, engine=services.map_engine(is_near=True)).classes("h-mapfill")
            _overlay(services, robot_id)
            HoldToDrive()
            LiveElement("hl-connecting", classes="h-connecting", data_name=robot.name)
        with ui.element("aside").classes("h-side").props('aria-label="Values"'):
            _panel(layout(robot), has_mission=robot.state is not None and robot.state.order is not None)
            ActionDock()


def _overlay(services: PageServices, robot_id: str) -> None:
    """Over the map: the view that is shown, who has control, and why the robot does not move.

    The way to the cameras joins the views when the robot has one.
    """
    with ui.element("div").classes("h-overlay"):
        with ui.element("div").classes("h-bar1"):
            with (
                LiveElement("hl-camera-door", data_camera=" ".join(map(bundle.script_url, ("machine", "camera")))),
                ui.element("div").classes("h-seg").props('role="group" aria-label="View"'),
            ):
                ui.html(f"{icon('map', 'm')}Map", sanitize=False, tag="span").classes("on").props("aria-current=true")
            LiveElement("hl-lease", hidden="")
            demo_button.place(services, robot_id)
        LiveElement("hl-why", classes="h-card h-why", hook="robot-why", hidden="")


def _panel(tiles: list[tuple[str, str]], *, has_mission: bool) -> None:
    LiveElement("hl-stop-card", hook="stop-card", hidden="")
    MissionCard(has_mission=has_mission)
    StatePath()
    with ui.element("div").classes("h-tiles"):
        for key, label in tiles:
            TelemetryTile(key, label)


def pick(services: PageServices, session: SessionInfo) -> None:
    """Let the browser open the robot it showed last, else offer those there are."""
    known = [r for r in services.fleet.robots() if not services.refusal(session, Permission.WATCH, r.id)]
    with LiveElement("hl-screen", classes="h-screen", data_screen="operate", data_title="Operate"):
        LiveElement(
            "hl-pick-robot", classes="h-scroll", data_known=" ".join(sorted(r.id for r in known if r.is_registered))
        )


def _unknown(robot_id: str) -> None:
    name = robot_id if is_id(robot_id) else "this address"
    notice.build(
        "operate",
        "help",
        f"No robot {name}",
        "It was never heard of here. Check the name.",
        "/operate",
        "Choose a robot",
    )
