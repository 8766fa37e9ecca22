"""What a person touched in the picture, and where the ground is under the finger."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from backend_clients.edge import messages_up as up
from backend_clients.edge.topics import Up
from hmi.twin.kinematics import Place
from hmi.twin.model import Vector
from hmi.twin.rotation import turned

if TYPE_CHECKING:
    from hmi.media.studio import Studio
    from hmi.twin.viewer import Viewer

FAR_M = 500.0  # a finger near the horizon means no place
NEAR_M = 0.45  # of a tree or an obstacle's edge
OUTCOMES = {
    "done": "Planted",
    "failed_tool": "Failed: tool",
    "failed_ground": "Failed: ground",
    "failed_machine": "Failed: machine",
    "planned": "Planned",
    "current": "Being worked at",
    "skipped": "Skipped",
}


def tapped(
    studio: Studio, viewer: Viewer, origin: Vector, direction: Vector
) -> tuple[tuple[float, float] | None, dict[str, Any]]:
    """Return a place of the ground and what is under a ray: robot, place, obstacle or bare ground.

    A robot's place is where it stands, not what is seen behind it. In a replay that is what is seen there: nothing of
    now but obstacles, which are said to be.
    """
    ground = ground_under(origin, direction)
    found = _robot(studio, viewer, origin, direction)
    base = None if found is None else base_of(studio, viewer, found["id"])
    if base is not None:
        ground = base.xyz[:2]
    if found is None and ground is not None:
        found = _place(studio, viewer, ground) or {"what": "ground", "name": "Ground", "lines": []}
    found = found or {"what": "nothing", "name": "", "lines": []}
    return ground, {"k": "tap", **found, **where_is(studio, viewer, ground)}


def base_of(studio: Studio, viewer: Viewer, robot_id: str) -> Place | None:
    """Return where a robot stands in a viewer's picture."""
    if robot_id == viewer.robot_id:
        return studio.base(viewer)
    solid = studio.world.solid(robot_id)
    return None if solid is None else studio.world.mover.place(solid.name)


def ground_under(origin: Vector, direction: Vector) -> tuple[float, float] | None:
    """Return where a ray meets the ground, ``None`` above the horizon or too far away."""
    if direction[2] > -1e-4:
        return None
    share = -origin[2] / direction[2]
    x, y = origin[0] + share * direction[0], origin[1] + share * direction[1]
    return (x, y) if share > 0 and math.dist((x, y), origin[:2]) < FAR_M else None


def _robot(studio: Studio, viewer: Viewer, origin: Vector, direction: Vector) -> dict[str, Any] | None:
    """The robot whose hull the ray enters first; the hull is a ball, flattened to its height."""
    start, unit = np.asarray(origin), np.asarray(direction) / max(float(np.linalg.norm(direction)), 1e-9)
    best: tuple[float, str] | None = None
    for robot_id in studio.world.robots() if viewer.past is None else [viewer.robot_id]:
        solid = studio.world.solid(robot_id)
        if solid is None:
            continue
        base = base_of(studio, viewer, robot_id)
        if base is None:
            continue
        radius = 0.42 * solid.form.size_m
        middle = np.add(base.xyz, (0, 0, 0.5 * radius))
        along = float((middle - start) @ unit)
        aside = float(np.linalg.norm(start + along * unit - middle))
        if along > 0 and aside < radius and (best is None or along < best[0]):
            best = (along, robot_id)
    if best is None:
        return None
    return {
        "what": "robot",
        "id": best[1],
        "name": studio.farm[best[1]].name,
        "lines": _robot_lines(studio, viewer, best[1]),
    }


def _robot_lines(studio: Studio, viewer: Viewer, robot_id: str) -> list[str]:
    telemetry = studio.intake.newest(robot_id, Up.TELEMETRY, up.Telemetry)
    factsheet = studio.intake.newest(robot_id, Up.FACTSHEET, up.Factsheet)
    lines = [] if factsheet is None else [factsheet[0].model]
    return lines if telemetry is None or viewer.past is not None else [*lines, f"{abs(telemetry[0].speed_mps):.2f} m/s"]


def _place(studio: Studio, viewer: Viewer, ground: tuple[float, float]) -> dict[str, Any] | None:
    site, shift = studio.site(viewer.robot_id), _shift(studio, viewer)
    if site is None or shift is None:
        return None
    x, y = ground[0] - shift[0], ground[1] - shift[1]
    now, past = site.surface.site, viewer.past
    for one in [] if now is None else now.obstacles:
        if math.dist((one.x_m, one.y_m), (x, y)) < one.radius_m + NEAR_M:
            size = f"{2 * one.radius_m:.1f} m across, {one.height_m:.1f} m high"
            lines = [size] if past is None else [size, "As now, not recorded"]
            return {"what": "obstacle", "id": one.id, "name": one.kind.capitalize(), "lines": lines}
    for target in [] if now is None or past is not None else now.targets:
        if math.dist((target.x_m, target.y_m), (x, y)) < NEAR_M:
            lines = [OUTCOMES[target.status], *([target.text] if target.text else [])]
            return {"what": "place", "id": target.id, "name": f"Place {target.id}", "lines": lines}
    for name, at_x, at_y, outcome in site.surface.ended():
        is_then = past is None or name not in past.undone
        if is_then and math.dist((at_x, at_y), (x, y)) < NEAR_M:
            return {"what": "place", "id": name, "name": f"Place {name}", "lines": [OUTCOMES.get(outcome, outcome)]}
    return None


def where_is(studio: Studio, viewer: Viewer, ground: tuple[float, float] | None) -> dict[str, Any]:
    """Return where a place of the ground is for a viewer's robot, and how far from it and its arm at this moment."""
    shift = _shift(studio, viewer)
    if ground is None or shift is None:
        return {"x_m": None, "y_m": None, "distance_m": None}
    base = studio.base(viewer)
    away = None if base is None else round(math.dist(base.xyz[:2], ground), 2)
    place = {"x_m": round(ground[0] - shift[0], 3), "y_m": round(ground[1] - shift[1], 3), "distance_m": away}
    return {**place, **_arm(studio, viewer, ground)}


def _arm(studio: Studio, viewer: Viewer, ground: tuple[float, float]) -> dict[str, Any]:
    """How far the place is from what the arm turns on, and how far the arm reaches; nothing for a robot without."""
    site, body = studio.site(viewer.robot_id), studio.base(viewer)
    if site is None or site.reach is None or body is None:
        return {}
    x, y, _ = turned(body.wxyz, (site.reach.x_m, site.reach.y_m, 0.0))
    return {
        "arm_m": round(math.dist((body.xyz[0] + x, body.xyz[1] + y), ground), 2),
        "reach_m": round(site.reach.radius_m, 2),
    }


def _shift(studio: Studio, viewer: Viewer) -> tuple[float, float] | None:
    factsheet = studio.intake.newest(viewer.robot_id, Up.FACTSHEET, up.Factsheet)
    return None if factsheet is None else studio.frame.shift(factsheet[0].datum.lat_deg, factsheet[0].datum.lon_deg)
