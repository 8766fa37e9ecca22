"""The pieces a rest is made of: rows and laps, whole or cut, and which of them are one line."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from hmi.domain.mission_document import Document
from hmi.domain.mission_plan import PlanRefused
from hmi.domain.mission_rest import WORK_KINDS, is_work
from hmi.planning.plan import GENTLE_RAD, Leg, LegKind, turn_between
from hmi.planning.polyline import in_millimetres
from hmi.planning.projection import Floats
from hmi.planning.spans import between

TOUCH_M = 0.005  # points are rounded to millimetres
MEET_M = 0.025  # paths from elsewhere may have gaps of 0.02 m before they are rounded


@dataclass(frozen=True, slots=True, eq=False)
class Work:
    """A piece to drive.

    Args:
        begins, ends: the base segment whose beginning and end these still are; ``None``: moved or turned around.
        turned: the base segment that is driven the other way round; of one that was cut one end or the other is there.
        is_joined: it goes on where the piece before it ended.
        is_spare: left out if no way leads to it: a part of a lap that something cut.
    """

    segment: Document
    begins: int | None = None
    ends: int | None = None
    turned: int | None = None
    is_joined: bool = False
    is_spare: bool = False

    @classmethod
    def of(cls, segment: Document, number: int) -> Work:
        """Return a piece as it stands in the base; a place where it was taken up belongs to the path, not to a row."""
        return cls({key: value for key, value in segment.items() if key != "jump"}, number, number)

    def parts(self, segments: Sequence[Document], *, is_joined: bool) -> list[Work]:
        """Return it cut; ``is_joined``: the parts follow one another without a way."""
        last = len(segments) - 1
        has_start, has_end = _is_same(segments[0], self.segment, 0), _is_same(segments[-1], self.segment, -1)
        return [
            Work(
                one,
                self.begins if k == 0 and has_start else None,
                self.ends if k == last and has_end else None,
                self.turned if (k == 0 and has_start) or (k == last and has_end) else None,
                is_joined=(is_joined and k > 0) or (self.is_joined and k == 0 and has_start),
            )
            for k, one in enumerate(segments)
        ]

    @property
    def points(self) -> Floats:
        """Where it runs, (N, 2) metres."""
        return np.asarray(self.segment["points"], dtype=float)

    @property
    def name(self) -> str:
        """What people call it."""
        return f"row {self.segment['row']}" if self.segment["row"] else "a headland lap"


def leg_of(segment: Document) -> Leg:
    """Return a segment as the planner sees it."""
    points = np.asarray(segment["points"], dtype=float)
    return Leg(
        LegKind(segment["kind"]),
        points,
        segment["speed_mps"],
        bool(segment.get("tool_on")),
        int(segment.get("row", 0)),
        bool(segment.get("pivot")) and not segment.get("jump"),
        segment.get("dose", 1.0),
        is_backward=bool(segment.get("backward")),
    )


def document_of(leg: Leg) -> Document:
    """Return a way, a lap or a loop as a segment."""
    rounded = np.round(leg.points, 3) + 0.0
    keep = np.append(True, np.any(np.diff(rounded, axis=0) != 0, axis=1))
    kept = rounded[keep] if keep.sum() > 1 else rounded[[0, -1]]
    segment: Document = {
        "kind": leg.kind.value,
        "points": kept.tolist(),
        "speed_mps": round(leg.speed_mps, 3),
        "tool_on": leg.tool_on,
        "row": 0,
        "pivot": False,
    }
    if leg.dose != 1.0:
        segment["dose"] = leg.dose
    return {**segment, "backward": True} if leg.is_backward else segment


def legs_of(segments: Sequence[Document]) -> list[Leg]:
    """Return a path; pieces of one row or lap count as one."""
    legs = [leg_of(one) for one in segments]
    return [
        replace(leg, is_continued=k > 0 and leg.kind.value in WORK_KINDS and is_one_line(segments[k - 1 : k + 1]))
        for k, leg in enumerate(legs)
    ]


def is_one_line(segments: Sequence[Document]) -> bool:
    """Say whether segments are pieces of one row or lap: each begins where and as the one before it ended."""
    return all(
        a["kind"] == b["kind"]
        and a.get("row", 0) == b.get("row", 0)
        and math.dist(a["points"][-1], b["points"][0]) < TOUCH_M
        and abs(turn_between(leg_of(a), leg_of(b))) <= GENTLE_RAD
        for a, b in pairwise(segments)
    )


def gap(place: Sequence[float], segments: Sequence[Document]) -> tuple[float, Document] | None:
    """Return the first gap of a path from ``place`` on, metres, and the segment after it; ``None`` if there is none.

    A segment that says ``jump`` begins where the robot stands, however far that is.
    """
    for one in segments:
        apart_m = math.dist(place, one["points"][0])
        if apart_m > MEET_M and not one.get("jump"):
            return apart_m, one
        place = one["points"][-1]
    return None


def check_is_one_path(head: Sequence[Document], rest: Sequence[Document]) -> None:
    """Refuse a rest with a gap: a robot would cross ground that nobody looked at."""
    found = gap(head[-1]["points"][-1] if head else rest[0]["points"][0], rest)
    if found is not None:
        gap_m, one = found
        raise PlanRefused("gap", f"The new path would have a gap of {gap_m:.2f} m {place_of(one)}. Choose other rows.")


def place_of(segment: Document) -> str:
    """Return in words where a segment begins."""
    return f"before row {segment['row']}" if segment.get("row") else "on the headland or on a way"


def turned(work: Work, points: Floats) -> Work:
    """Return a piece driven the other way round, along ``points``."""
    return Work({**work.segment, "points": rounded_points(points)}, turned=work.begins)


def turned_line(segments: Sequence[Document], shift_m: float) -> list[Floats]:
    """Return the pieces of one row or lap driven the other way round, the last one first.

    The tool goes on ``shift_m`` sooner and off ``shift_m`` sooner than the same borders say the other way round:
    it is on for longer before treated ground than after it. Borders between two doses stay where they are.
    """
    line = np.vstack([np.asarray(one["points"], dtype=float)[::-1] for one in segments[::-1]])
    # a piece begins where the one before it ends: the same place twice would be a piece without a direction
    line = line[np.append(True, np.hypot(*np.diff(line, axis=0).T) > 0)]
    lengths = [float(np.hypot(*np.diff(np.asarray(one["points"], dtype=float), axis=0).T).sum()) for one in segments]
    edges = np.append(0.0, np.cumsum(lengths[::-1]))
    for k, (first, then) in enumerate(pairwise(segments[::-1]), 1):
        if bool(first.get("tool_on")) != bool(then.get("tool_on")):
            edges[k] = min(max(edges[k] - shift_m, edges[k - 1]), edges[-1])
    return [between(line, float(a), float(b)) for a, b in pairwise(edges)]


def _is_same(part: Document, whole: Document, end: int) -> bool:
    return math.dist(part["points"][end], whole["points"][end]) < TOUCH_M


def rounded_points(points: Floats) -> list[list[float]]:
    """Return points as they stand in a document."""
    rounded: list[list[float]] = in_millimetres(points).tolist()
    return rounded


def driven_through(
    before: Document | None, between: Sequence[Document], after: Document | None
) -> list[Document] | None:
    """Return the segments between two pieces with the tool off, ``None`` if a row or lap of its own lies between.

    Work may be driven through only in the line of the piece before or after it; ``None`` for one that is not known.
    """
    lead = 0
    while lead < len(between) and before is not None and is_one_line([before, between[lead]]):
        before, lead = between[lead], lead + 1
    tail = len(between)
    while tail > lead and after is not None and is_one_line([between[tail - 1], after]):
        after, tail = between[tail - 1], tail - 1
    if any(is_work(one) for one in between[lead:tail]):
        return None
    return [off(one) if is_work(one) else one for one in between]


def off(segment: Document) -> Document:
    """Return a segment driven with the tool off."""
    kept = {key: value for key, value in segment.items() if key != "dose"}
    return {**kept, "tool_on": False}
