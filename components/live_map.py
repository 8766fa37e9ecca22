"""The live map: farm, mission and robots, drawn in the browser from the live lane and from REST.

No position travels over the NiceGUI socket. The map's scripts and MapLibre GL are fetched from our own origin when a
map is on screen, under addresses that change with their content.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Literal

from nicegui import __version__ as nicegui_version
from nicegui.dependencies import register_resource
from nicegui.element import Element
from nicegui.events import GenericEventArguments

STATIC = Path(__file__).resolve().parent.parent / "static"
Mode = Literal["robot", "fleet", "stations"]
Engine = Literal["auto", "quick", "canvas"]


class LiveMap(Element, component="live_map.js"):
    """Map of one robot (lane topic ``robot/{id}``) or of all of them (topic ``fleet``).

    Args:
        robot_id: the robot to show; in fleet mode the selected one. ``None`` shows the farm alone.
        mode: ``robot`` follows one robot with its mission and trail, ``fleet`` shows all, ``stations`` the farm and
            what a script of the page hands it of field stations.
        has_buttons: follow, layers, zoom, north and scale; off for a small picture.
        engine: ``auto`` takes WebGL where there is one, ``quick`` only where a graphics chip draws it,
            ``canvas`` never.
        features_url: address of the farm's GeoJSON.
        mission_url: address of the mission's GeoJSON, ``{id}`` is the robot.
        on_select: called with the id of a robot that was tapped.
    """

    def __init__(
        self,
        robot_id: str | None = None,
        *,
        mode: Mode = "robot",
        has_buttons: bool = True,
        engine: Engine = "auto",
        features_url: str = "/api/v1/features",
        mission_url: str = "/api/v1/robots/{id}/mission.geojson",
        on_select: Callable[[str], None] | None = None,
    ) -> None:
        super().__init__()
        self._props["robot-id"] = robot_id
        self._props["mode"] = mode
        self._props["has-buttons"] = has_buttons
        self._props["engine"] = engine
        self._props["features-url"] = features_url
        self._props["mission-url"] = mission_url
        self._props["code-url"] = _resource_url(STATIC / "js" / "map")
        self._props["vendor-url"] = _resource_url(STATIC / "vendor" / "maplibre")
        self._props["data-testid"] = "map"
        self.classes("hl-map")
        if on_select is not None:
            self._select = on_select
            self.on("select-robot", self._selected)

    def set_robot(self, robot_id: str | None) -> None:
        """Show another robot; the map starts anew on it."""
        self._props["robot-id"] = robot_id
        self.update()

    def _selected(self, event: GenericEventArguments) -> None:
        if isinstance(event.args, str):  # the browser may send anything
            self._select(event.args)


@cache
def _resource_url(folder: Path) -> str:
    """Serve ``folder`` under an address that changes when a file in it does, so that browsers may keep it for good."""
    newest = max(path.stat().st_mtime for path in folder.iterdir())
    resource = register_resource(folder, max_time=newest)
    return f"/_nicegui/{nicegui_version}/resources/{resource.key}"
