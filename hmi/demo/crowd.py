"""Fleets of any size on the demo farm, for trying and for load: who they are, where they stand, what they drive."""

from __future__ import annotations

import itertools
import math
import secrets
from typing import Any

from backend_clients.edge.messages_down import Mission, Segment
from backend_clients.edge.messages_up import Datum
from backend_clients.simulator.config import Job
from hmi.demo.farm import feature
from hmi.demo.fleet import FULL, POLDER_DATUM, DemoRobot, row_of
from hmi.domain.robot import Family
from hmi.planning.projection import LocalFrame

SPACE_M = 11.0  # from robot to robot
LAP_M = 7.0
COLUMNS = 40
CORNER_M = (-30.0, 40.0)  # of the first robot, from the datum, along and across the fields
SLOPE_RAD = math.radians(-15.64)  # the farm's roads against east
NAMES = {Family.WEEDER: "Weeder", Family.PLANTER: "Planter", Family.UAV: "Kestrel"}


def fleet_rows(weeders: int, planters: int, uavs: int) -> list[dict[str, Any]]:
    """Return rows of the fleet file: the demo's own robots first, further ones in lines on Polder 17."""
    wanted = {Family.WEEDER: weeders, Family.PLANTER: planters, Family.UAV: uavs}
    known = [one for one in FULL if int(one.id[-2:]) <= wanted[one.family]]
    rows = [row_of(one, secrets.token_urlsafe(24), "") for one in known]
    for row in rows:
        row["task"] = True
    more = [
        (f"{family.value}-{n:02d}", f"{NAMES[family]} {n:02d}", family)
        for family, count in wanted.items()
        for n in range(1 + sum(one.family is family for one in known), count + 1)
    ]
    return rows + [_placed(robot_id, name, family, k) for k, (robot_id, name, family) in enumerate(more)]


def lean_rows(count: int) -> list[dict[str, Any]]:
    """Return rows of ``count`` lean weeders, ``lean-0001`` on."""
    rows = [_placed(f"lean-{n + 1:04d}", f"Lean {n + 1}", Family.WEEDER, n) for n in range(count)]
    return [{**row, "is_lean": True} for row in rows]


def lean_jobs(rows: list[dict[str, Any]]) -> dict[str, Job]:
    """Return a small lap for each lean robot, driven again and again."""
    return {row["id"]: Job(_lap(row), is_endless=True) for row in rows if row.get("is_lean")}


def _placed(robot_id: str, name: str, family: Family, number: int) -> dict[str, Any]:
    along, across = CORNER_M[0] - SPACE_M * (number % COLUMNS), CORNER_M[1] + SPACE_M * (number // COLUMNS)
    x = along * math.cos(SLOPE_RAD) - across * math.sin(SLOPE_RAD)
    y = along * math.sin(SLOPE_RAD) + across * math.cos(SLOPE_RAD)
    made = DemoRobot(robot_id, name, "polder-bay-1", family=family)
    return {**row_of(made, secrets.token_urlsafe(24), ""), "x_m": round(x, 3), "y_m": round(y, 3)}


def _lap(row: dict[str, Any]) -> Mission:
    x, y = row["x_m"], row["y_m"]
    corners = [(x, y), (x, y + LAP_M), (x + LAP_M, y + LAP_M), (x + LAP_M, y), (x, y)]
    sides = list(itertools.pairwise(corners))
    segments = [
        Segment(kind="row" if n % 2 == 0 else "turn", points=[a, b], speed_mps=0.8, tool_on=n % 2 == 0,
                row=1 + n // 2 if n % 2 == 0 else 0, pivot=True)
        for n, (a, b) in enumerate(sides)
    ]  # fmt: skip
    polder = feature("polder-17")
    ring = LocalFrame(*POLDER_DATUM).to_lon_lat(corners).tolist()
    return Mission(
        robot=row["id"],
        mission_id=f"lap-{row['id']}",
        revision=1,
        name=f"Lap of {row['name']}",
        field_name=polder.name,
        datum=Datum(lat_deg=POLDER_DATUM[0], lon_deg=POLDER_DATUM[1]),
        width_m=1.5,
        area_m2=LAP_M * LAP_M,
        parcel=[[(lon, lat) for lon, lat in ring]],
        segments=segments,
    )
