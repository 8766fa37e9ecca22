"""The figures of a rest: what it takes, and those of the whole mission as it is with it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from hmi.domain.family import Family
from hmi.domain.mission_document import Document
from hmi.domain.mission_rest import RestWish, length_m
from hmi.domain.planned_machine import MACHINE
from hmi.planning.estimate import effort
from hmi.planning.machine import RobotProfile
from hmi.planning.rest_work import legs_of
from hmi.planning.statistics import planned_machine, planting


def effort_of(segments: Sequence[Document], machine: RobotProfile, width_m: float) -> dict[str, Any]:
    """Return what driving segments takes, SI, as a person compares it; ``width_m`` of a pass."""
    work = effort(legs_of(segments), machine)
    return {
        "duration_s": round(work.duration_s, 1),
        "energy_j": round(work.energy_j),
        "battery_share": round(work.energy_j / machine.battery_j, 4),
        "length_m": round(work.length_m, 1),
        "area_m2": round(work.working_length_m * min(width_m, machine.tool_width_m or math.inf), 1),
        "rows": len({s["row"] for s in segments if s["row"]}),
    }


def statistics_of(
    wish: RestWish, machine: RobotProfile, segments: Sequence[Document], *, share: float, notes: Sequence[str]
) -> dict[str, Any]:
    """Return the figures of the whole mission that changed; ``share`` of its area is left."""
    legs = legs_of(segments)
    work = effort(legs, machine)
    width_m, spacing_m = wish.base["width_m"], wish.base.get("plant_spacing_m")
    is_planter = wish.robot is not None and wish.robot.family is Family.PLANTER
    return {
        **(planting(width_m, spacing_m, work.working_length_m) if is_planter else {}),
        MACHINE: planned_machine(wish.base["robot"], wish.robot, machine, legs, width_m),
        "length_m": round(work.length_m, 4),
        "working_length_m": round(work.working_length_m, 4),
        "duration_s": round(work.duration_s, 4),
        "working_s": round(work.working_s, 4),
        "rows": len({s["row"] for s in segments if s["row"]}),
        "turns": work.turns,
        "pivots": work.pivots,
        "reversals": work.reversals,
        "energy_j": round(work.energy_j, 1),
        "battery_share": round(work.energy_j / machine.battery_j, 4),
        "covered_share": round(share, 4),
        "notes": list(notes),
    }


def tool_m(segments: Sequence[Document]) -> float:
    """Return how far the tool is on."""
    return sum(length_m(s) for s in segments if s.get("tool_on"))
