"""The numbers that go with a plan: figures of the path, battery with reserve, seedlings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from hmi.domain.mission_plan import PlanWish, Rows
from hmi.domain.planned_machine import MACHINE, PlannedMachine, worked_width_m
from hmi.domain.robot import Factsheet, Family
from hmi.planning.job import Job
from hmi.planning.machine import SEEDLINGS_PER_M2, RobotProfile
from hmi.planning.plan import Leg, Plan

LEAST_RESERVE = 0.15  # of the battery, never planned away: cold, wind and an aged cell take as much
DETOUR = 1.4  # a way home along headlands and roads is so much longer than the straight line


def statistics(wish: PlanWish, job: Job, plan: Plan) -> dict[str, Any]:
    """Return a plan's numbers as they are stored and shown, SI; shares are 0 to 1."""
    figures = {k: round(v, 4) if isinstance(v, float) else v for k, v in asdict(plan.figures).items()}
    found: dict[str, Any] = {
        **figures,
        "notes": list(plan.notes),
        "pattern": wish.pattern.value,
        "rows_along": _rows_along(wish),
        "battery_j": job.machine.battery_j,
        "energy_basis": _energy_basis(wish, job),
        "is_tank": job.machine.energy.is_tank,
        "reserve_share": round(_reserve_share(job, plan), 4),
        MACHINE: planned_machine(wish.robot_id, wish.robot, job.machine, plan.legs, wish.width_m),
    }
    if wish.robot is not None and wish.robot.charge_w is not None:
        found["charge_w"] = wish.robot.charge_w
    if not job.doses.is_plain:
        found["treatment"] = {
            "rest_dose": wish.treatment.rest_dose,
            "lead_m": [job.doses.lead_in_m, job.doses.lead_out_m],
            "areas": [{"dose": one.dose, "geometry": dict(one.geometry)} for one in wish.treatment.areas],
        }
    if wish.robot is not None and wish.robot.family is Family.PLANTER:
        found |= planting(wish.width_m, wish.plant_spacing_m, plan.figures.working_length_m)
    return found


def planting(width_m: float, spacing_m: float | None, length_m: float) -> dict[str, Any]:
    """Return how far apart the plants of ``length_m`` of row are and how many they are; ``None``: as dense as usual."""
    spacing_m = spacing_m or 1 / (SEEDLINGS_PER_M2 * width_m)
    return {"plant_spacing_m": round(spacing_m, 3), "seedlings": round(length_m / spacing_m)}


def planned_machine(
    robot_id: str, sheet: Factsheet | None, machine: RobotProfile, legs: Sequence[Leg], width_m: float
) -> dict[str, Any]:
    """Return what a path with rows ``width_m`` apart asks of a machine, as it is stored."""
    return PlannedMachine(
        robot_id=robot_id,
        family=None if sheet is None else sheet.family.value,
        length_m=machine.length_m,
        width_m=machine.width_m,
        base_to_front_m=machine.base_to_front_m,
        turning_radius_m=machine.turning_radius_m,
        turns_on_spot=any(leg.pivot for leg in legs[1:]),
        reverse_mps=round(max((leg.speed_mps for leg in legs if leg.is_backward), default=0.0), 3),
        top_mps=round(max((leg.speed_mps for leg in legs), default=0.0), 3),
        battery_wh=None if sheet is None else sheet.battery_wh,
        tool_width_m=worked_width_m(width_m, sheet),
    ).as_json()


def _rows_along(wish: PlanWish) -> str:
    """Return what the rows run along; ``direction``: that which was asked for, or the field's."""
    if wish.rows is not None:
        return wish.rows.value
    return Rows.BEST_ANGLE.value if wish.angle_rad is None else "direction"


def _energy_basis(wish: PlanWish, job: Job) -> str:
    """Return with which figures energy is counted, and who says so."""
    energy, holds = job.machine.energy, "Tank" if job.machine.energy.is_tank else "Battery"
    says = "assumed" if wish.robot is None or wish.robot.battery_wh is None else "from its factsheet"
    return f"{energy.basis} {holds} of {job.machine.battery_j / 3.6e6:.3g} kWh {says}."


def _reserve_share(job: Job, plan: Plan) -> float:
    """Return the share of the battery to keep: it brings the robot home from the furthest point, or more."""
    if job.home is None:
        return LEAST_RESERVE
    points = np.concatenate([leg.points for leg in plan.legs])
    way_m = DETOUR * float(np.hypot(*(points - np.array(job.home)).T).max())
    machine = job.machine
    way_j = way_m * machine.energy.drive_j_per_m + way_m / machine.transit_speed_mps * machine.energy.idle_w
    return max(LEAST_RESERVE, way_j / machine.battery_j)
