"""What a machine tells of its inside: joints, gauges, who is near, where it works, and the ground it sees."""

from __future__ import annotations

import math
from typing import Any

from backend_clients.edge.machine import Point3, Sighting
from backend_clients.simulator.machine import Machine
from backend_clients.simulator.planter_rig import PlanterRig
from backend_clients.simulator.planting_site import to_enu
from backend_clients.simulator.terrain import height_m, tilt_rad

SEES_M = 40.0
LEAST_TILT_RAD = 1e-6


def body_fields(machine: Machine) -> dict[str, Any]:
    """Return the body message of a machine without its header."""
    fields: dict[str, Any] = {"gauges": gauges(machine), "seen": seen(machine)}
    rig = machine.rig
    if rig is None:
        if machine.limbs is not None:
            fields |= {"joints": _rounded(machine.limbs.pose), "planned": _rounded(machine.limbs.planned)}
        return fields
    return fields | {
        "joints": _rounded(rig.crane.pose),
        "planned": _rounded(rig.crane.planned),
        "tool": _tool(machine, rig),
        "is_loaded": rig.in_head > 0,
        "stock": machine.seedlings,
    }


def is_body_moving(machine: Machine) -> bool:
    """Say whether joints move now."""
    if machine.rig is not None:
        return machine.rig.crane.is_moving
    return machine.limbs is not None and machine.limbs.is_moving


def gauges(machine: Machine) -> dict[str, float]:
    """Return what the machine measures."""
    if machine.rig is not None:
        base, rig = machine.base, machine.rig
        return {
            "pressure": round(rig.pressure_bar, 1),
            "oil": round(rig.oil_c, 1),
            "tilt": round(math.degrees(tilt_rad(base.x_m, base.y_m)), 1),
            "head-soil": round(max(rig.crane.tip[2], 0.0), 2),
        }
    found = {"motor-temp": round(machine.motor_c, 1)}
    if machine.profile.hot_c is not None:
        found["laser-temp"] = round(machine.tool_temperature_c, 1)
    return found


def seen(machine: Machine) -> list[Sighting]:
    """Return who stands near."""
    if machine.person is None:
        return []
    away_m = math.dist(machine.person, (machine.base.x_m, machine.base.y_m))
    if away_m > SEES_M:
        return []
    x_m, y_m = machine.person
    return [Sighting(id="person-1", kind="person", x_m=round(x_m, 2), y_m=round(y_m, 2), distance_m=round(away_m, 2))]


def worksite_fields(rig: PlanterRig) -> dict[str, Any] | None:
    """Return the worksite message without its header, ``None`` before the first site."""
    site = rig.site
    if site is None:
        return None
    return {"stop": site.stop, "area": site.area, "obstacles": site.obstacles, "targets": site.targets}


def _tool(machine: Machine, rig: PlanterRig) -> Point3:
    x_m, y_m, z_m = rig.crane.tip
    east_m, north_m = to_enu(machine.base, (x_m, y_m))
    return round(east_m, 3), round(north_m, 3), round(z_m + height_m(machine.base.x_m, machine.base.y_m), 3)


def _rounded(pose: dict[str, float]) -> dict[str, float]:
    return {name: round(value, 4) for name, value in pose.items()}
