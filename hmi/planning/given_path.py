"""A path that was planned elsewhere: checked as our own plans are, then counted, drawn and written here.

Nothing but the path is taken: time, ground, energy and the document for the robot are this module's own.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from hmi.domain.mission_plan import Candidate, PathUnfit, Pattern, PlannedMission, PlanWish
from hmi.planning import headland as headlands
from hmi.planning.figures import figures_of, missed_note, worked_strips
from hmi.planning.ground import erode
from hmi.planning.job import Job, checked_field
from hmi.planning.mission import MAX_EXTENT_M, MAX_POINTS_IN, MAX_SEGMENTS, candidate_of, job_of, mission_of
from hmi.planning.path_check import check_path
from hmi.planning.plan import Leg, LegKind, Plan, headings

MAX_NOTES, MAX_NOTE = 20, 300
LEAST_SHARE = 0.25  # of the ground to be treated; of slivers our own plans reach no more, of fields far more


def checked_mission(wish: PlanWish, segments: Sequence[Mapping[str, Any]], notes: Sequence[str]) -> PlannedMission:
    """Return a mission that drives this path.

    Args:
        segments: kind, points, speed_mps, tool_on, row, pivot, dose, is_continued, is_backward; metres in the
            wish's plane.
        notes: sentences of whoever planned it.

    Raises:
        PlanRefused: the wish itself cannot be planned.
        PathUnfit: the path breaks a rule that every plan keeps.
    """
    job, plan = _checked(wish, segments, notes)
    return mission_of(wish, job, plan)


def checked_candidate(wish: PlanWish, segments: Sequence[Mapping[str, Any]], notes: Sequence[str]) -> Candidate:
    """Return the path to look at; raises as ``checked_mission``."""
    job, plan = _checked(wish, segments, notes)
    return candidate_of(wish, job, plan)


def _checked(wish: PlanWish, segments: Sequence[Mapping[str, Any]], notes: Sequence[str]) -> tuple[Job, Plan]:
    job = job_of(wish)
    field = checked_field(job)
    legs = legs_of(segments)
    check_path(job, field, legs)
    legs = job.limits.cut(legs)  # a service knows nothing of slow zones
    division = headlands.divide(job.machine, job.width_m, job.headland_passes, is_wide=job.pattern is Pattern.SKIP_ROWS)
    rows = [leg for leg in legs if leg.kind is LegKind.ROW]
    figures = figures_of(
        job,
        field,
        erode(field, division.depth_m),
        legs,
        worked_strips(legs, job.treated_width_m),
        rows=max((leg.row for leg in rows), default=0),
        angle=_angle(rows),
        passes=sum(leg.kind is LegKind.HEADLAND and not leg.is_continued for leg in legs),
    )
    worked = 1 - figures.missed_m2 / figures.wanted_m2 if figures.wanted_m2 else 0.0
    if worked < LEAST_SHARE * job.treated_width_m / job.pass_width_m:
        raise PathUnfit("little", f"It works {worked:.0%} of the ground to be treated only.")
    told = [_plain(note) for note in notes[:MAX_NOTES]]
    said = dict.fromkeys(note for note in (*told, missed_note(job, figures), *job.flight_notes) if note)
    return job, Plan(tuple(legs), figures, tuple(said))


def legs_of(segments: Sequence[Mapping[str, Any]]) -> list[Leg]:
    """Return segments as legs; raises ``PathUnfit`` for numbers that are none."""
    if not 1 <= len(segments) <= MAX_SEGMENTS or sum(len(one["points"]) for one in segments) > MAX_POINTS_IN:
        raise PathUnfit("size", f"It has {len(segments)} pieces; a robot takes 1 to {MAX_SEGMENTS}.")
    return [_leg(one) for one in segments]


def _leg(one: Mapping[str, Any]) -> Leg:
    points = np.asarray(one["points"], dtype=np.float64).reshape(-1, 2)
    if len(points) < 2 or not np.isfinite(points).all() or float(np.abs(points).max()) > MAX_EXTENT_M:
        raise PathUnfit("numbers", "It has corners that are not numbers, or far from the field.")
    if not (math.isfinite(one["speed_mps"]) and one["speed_mps"] > 0):
        raise PathUnfit("numbers", "It has a speed that is none.")
    return Leg(
        LegKind(one["kind"]),
        points,
        float(one["speed_mps"]),
        tool_on=bool(one["tool_on"]),
        row=int(one["row"]),
        pivot=bool(one["pivot"]),
        dose=float(one["dose"]),
        is_continued=bool(one["is_continued"]),
        is_backward=bool(one.get("is_backward")),
    )


def _angle(rows: Sequence[Leg]) -> float:
    """Return the direction of the rows, 0 to pi; longer ones weigh more."""
    doubled = sum(leg.length_m * np.exp(2j * float(headings(leg.points)[0])) for leg in rows)
    return float(np.angle(doubled)) / 2 % math.pi


def _plain(note: str) -> str:
    return "".join(c for c in note[:MAX_NOTE] if c.isprintable()).strip()


def segments_of(legs: Sequence[Leg]) -> list[dict[str, Any]]:
    """Return legs as segments, as ``checked_mission`` takes them."""
    return [
        {
            "kind": leg.kind.value,
            "points": leg.points.tolist(),
            "speed_mps": leg.speed_mps,
            "tool_on": leg.tool_on,
            "row": leg.row,
            "pivot": leg.pivot,
            "dose": leg.dose,
            "is_continued": leg.is_continued,
            "is_backward": leg.is_backward,
        }
        for leg in legs
    ]
