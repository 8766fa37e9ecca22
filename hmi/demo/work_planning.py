"""Plan what the demo's robots are busy with: ``python -m hmi.demo.work_planning`` writes the file the demo ships."""

from __future__ import annotations

import gzip
import json
from typing import Any

import numpy as np
import shapely

from hmi.commands.plan_wish import surroundings_of
from hmi.demo.catalogue import row_angle, surroundings
from hmi.demo.farm import POLDER, DemoFeature, feature, features
from hmi.demo.fleet import POLDER_DATUM, DemoRobot, robot
from hmi.demo.work import FILE, TASKS, Task
from hmi.domain.mission_plan import PlannedMission, PlanWish, Surroundings
from hmi.domain.robot import Factsheet, Family
from hmi.ingest import translate
from hmi.planning.mission import plan_mission
from hmi.planning.projection import LocalFrame
from hmi.store.features import Feature

EDGE_M = 9.0  # along the border of a field


def plan_task(task: Task) -> PlannedMission:
    """Plan one task; seconds of work."""
    field, machine = feature(task.field_id), robot(task.robot_id)
    angle = row_angle(field.properties)
    sheet = _factsheet(machine)
    return plan_mission(
        PlanWish(
            mission_id=task.mission_id,
            name=f"{field.name}, {machine.name}",
            robot_id=task.robot_id,
            field_name=field.name,
            parcel=_band(field.geometry, angle or 0.0, task.band),
            width_m=task.width_m,
            datum_lat_deg=machine.datum_lat_deg,
            datum_lon_deg=machine.datum_lon_deg,
            robot=sheet,
            angle_rad=angle,
            home=machine.home,
            returns_home=True,
            surroundings=_around(sheet, field),
        )
    )


def _around(sheet: Factsheet, field: DemoFeature) -> Surroundings:
    """Return roads and obstacles, and the edge of the field as the way to a band inside it.

    A planter may cross all of its field, for nothing stands there yet; a UAV flies over most of it.
    """
    if sheet.family is Family.UAV:
        map_now = [Feature(one.id, "", one.kind, one.name, one.geometry, one.properties) for one in features()]
        return surroundings_of(map_now, field.geometry, field.id, sheet)
    frame, known = LocalFrame(*POLDER_DATUM), surroundings(POLDER)
    outline = shapely.transform(shapely.geometry.shape(field.geometry), frame.to_local)
    inner = shapely.Polygon() if sheet.family is Family.PLANTER else outline.buffer(-EDGE_M)
    edge = shapely.transform(outline.difference(inner), frame.to_lon_lat)
    way: dict[str, Any] = shapely.geometry.mapping(edge)
    return Surroundings((*known.obstacles, *known.crossed), (*known.ways, (way, 0.0)))


def _band(geometry: dict[str, Any], angle_rad: float, band: tuple[float, float]) -> dict[str, Any]:
    """Return the part of a field between two shares of its width across the rows."""
    if band == (0.0, 1.0):
        return geometry
    frame = LocalFrame(*POLDER_DATUM)
    field = shapely.transform(shapely.geometry.shape(geometry), frame.to_local)
    lying = shapely.affinity.rotate(field, -angle_rad, origin=(0, 0), use_radians=True)
    left, low, right, high = lying.bounds
    cut = shapely.box(left - 1, low + band[0] * (high - low), right + 1, low + band[1] * (high - low))
    part = shapely.affinity.rotate(lying.intersection(cut), angle_rad, origin=(0, 0), use_radians=True)
    degrees = shapely.transform(part, lambda xy: np.round(frame.to_lon_lat(xy), 8))
    outline: dict[str, Any] = shapely.geometry.mapping(shapely.orient_polygons(degrees))
    return {"type": outline["type"], "coordinates": [[list(p) for p in ring] for ring in outline["coordinates"]]}


def _factsheet(machine: DemoRobot) -> Factsheet:
    # only planning anew needs the simulator
    from backend_clients.edge.messages_up import Factsheet as SaidFactsheet
    from backend_clients.simulator.config import RobotConfig
    from backend_clients.simulator.datasheet import factsheet_fields

    config = RobotConfig(machine.id, machine.name, "unused", *POLDER_DATUM, family=machine.family.value)  # type: ignore[arg-type]
    said = SaidFactsheet(robot=machine.id, boot="planning", seq=0, mono_ms=0, wall_ms=0, **factsheet_fields(config))
    return translate.factsheet(said)


def write_work() -> int:
    """Plan every task and write the file; return its size in bytes."""
    planned = [plan_task(task) for task in TASKS]
    rows = [{"document": one.document, "statistics": one.statistics} for one in planned]
    text = json.dumps(rows, separators=(",", ":"))
    FILE.write_bytes(gzip.compress(text.encode(), mtime=0))
    return FILE.stat().st_size


if __name__ == "__main__":
    print(write_work())  # noqa: T201 - a tool for developers
