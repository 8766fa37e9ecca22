"""The rest of a mission planned anew: what is done stays, what is left out goes, new ways join the pieces.

The document that comes out begins with the path that stays, point by point, so that the robot can compare it; see
*Updates* in docs/protocols/edge.md.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hmi.domain.mission_document import Document, canonical, mission_sha256
from hmi.domain.mission_plan import PlanRefused
from hmi.domain.mission_rest import PlannedRest, RestWish, cut, is_work, length_m
from hmi.planning.dubins import Pose
from hmi.planning.estimate import effort
from hmi.planning.machine import RobotProfile
from hmi.planning.plan import GENTLE_RAD, Leg, LegKind, headings, turn_between
from hmi.planning.projection import Floats, LocalFrame
from hmi.planning.rest_ground import RestGround

AHEAD_M = 10.0  # a running robot drives on while a person looks at the new rest: the new path begins beyond this
MAX_SEGMENTS = 20_000


@dataclass(frozen=True, slots=True, eq=False)
class _Work:
    """A piece of work: the segment, and where it stood in the base document; ``None``: it is not driven as it stood."""

    segment: Document
    number: int | None

    @property
    def points(self) -> Floats:
        return np.asarray(self.segment["points"], dtype=float)

    @property
    def name(self) -> str:
        return f"row {self.segment['row']}" if self.segment["row"] else "a headland lap"


def plan_rest(wish: RestWish) -> PlannedRest:
    """Return the document that goes on with ``wish.base``; blocks for up to seconds.

    Raises:
        PlanRefused: nothing is left, or a piece cannot be reached; says why.
    """
    return _Rest(wish).run()


class _Rest:
    """One rest while it is planned."""

    def __init__(self, wish: RestWish) -> None:
        self.wish = wish
        self.base = wish.base
        self.machine = RobotProfile() if wish.robot is None else RobotProfile.from_factsheet(wish.robot)
        self.frame = LocalFrame(wish.base["datum"]["lat_deg"], wish.base["datum"]["lon_deg"])
        self.notes: list[str] = []
        progress = wish.progress
        self.done, self.left, self.first = cut(wish.base["segments"], progress.segment, progress.segment_s_m)
        self.home = self._home()
        self.ground = RestGround(wish, self.frame, self.machine, self.home)

    def run(self) -> PlannedRest:
        head, start, works = self._stitched()
        chosen = self._chosen(works)
        if not chosen and not self.wish.is_running:
            raise PlanRefused("nothing_left", "Nothing is left to do. Abort the mission, or start fresh.")
        rest = self._joined(chosen, start, head)
        if not rest:
            raise PlanRefused("nothing_left", "It finishes its last row. There is nothing left to change.")
        if len(head) + len(rest) > MAX_SEGMENTS:
            raise PlanRefused("too_many_rows", "The mission would have too many pieces for the robot.")
        return self._planned(head, self._pivoted(head, rest), [w for w in works if self._is_left_out(w)])

    # what stays

    def _stitched(self) -> tuple[list[Document], int, list[_Work]]:
        """Return the path that stays, the number of the base's first segment after it, and the work after it."""
        works = [_Work(one, number) for number, one in enumerate(self.left, self.first) if is_work(one)]
        if not self.wish.is_running:
            return self.done, self.first, works
        ahead_m = 0.0
        for number, one in enumerate(self.left, self.first):
            ahead_m += length_m(one)
            if is_work(one) and ahead_m >= AHEAD_M:
                head = [dict(s) for s in self.base["segments"][: number + 1]]
                for work in works:
                    if work.number in self.wish.leave_out and (work.number or 0) <= number:
                        self.notes.append(f"It is too near {work.name} to leave it out. Pause it first.")
                return head, number + 1, [w for w in works if w.number is not None and w.number > number]
        raise PlanRefused("nothing_left", "It is in its last row. There is nothing left to change.")

    def _is_left_out(self, work: _Work) -> bool:
        return work.number in self.wish.leave_out

    def _chosen(self, works: Sequence[_Work]) -> list[_Work]:
        """Return what is done, in the order wished for, cut where something stands in the way."""
        chosen = [w for w in works if not self._is_left_out(w)]
        if self.wish.is_reversed and chosen:
            is_inside = not self.wish.is_running and len(self.done) > self.first and chosen[0].number == self.first
            kept, turned = (chosen[:1], chosen[1:]) if is_inside else ([], chosen)
            chosen = [*kept, *(_Work({**w.segment, "points": w.segment["points"][::-1]}, None) for w in turned[::-1])]
        return [part for work in chosen for part in self._around(work)]

    def _around(self, work: _Work) -> list[_Work]:
        parts = self.ground.around(work.points)
        if parts is None:
            return [work]
        lost = length_m(work.segment) - sum(float(np.hypot(*np.diff(p, axis=0).T).sum()) for p in parts)
        self.notes.append(f"{work.name.capitalize()}: {lost:.0f} m left out, something stands there.")
        return [_Work({**work.segment, "points": p.tolist()}, None) for p in parts]

    # ways

    def _joined(self, chosen: Sequence[_Work], start: int, head: Sequence[Document]) -> list[Document]:
        rest: list[Document] = []
        before: int | None = start - 1 if self.wish.stand is None else None
        pose = self._beginning(head)
        is_inside = self.wish.stand is None and not self.wish.is_running and len(head) > start
        for work in chosen:
            is_there = is_inside and not rest and work.number == start
            if not is_there:
                rest += self._way(pose, before, work, is_first=not rest)
            rest.append(self._at_speed(work.segment))
            pose, before = _end_pose(work.points), work.number
        rest += self._exit(pose, before, is_first=not rest)
        if self.wish.stand is not None and rest:
            rest[0] = {**rest[0], "jump": True}
        return rest

    def _beginning(self, head: Sequence[Document]) -> Pose:
        """Return where the new path begins."""
        if self.wish.stand is not None:
            lon, lat, heading = self.wish.stand
            x, y = self.frame.to_local([(lon, lat)])[0]
            return round(float(x), 3), round(float(y), 3), heading
        if head:
            return _end_pose(np.asarray(head[-1]["points"], dtype=float))
        points = np.asarray(self.left[0]["points"], dtype=float)
        return float(points[0][0]), float(points[0][1]), float(headings(points)[0])

    def _way(self, pose: Pose, before: int | None, work: _Work, *, is_first: bool) -> list[Document]:
        known = self._known_way(before, work.number)
        if known is not None:
            return known
        points = work.points
        goal: Pose = (float(points[0][0]), float(points[0][1]), float(headings(points)[0]))
        is_back = is_first and self.wish.stand is not None
        pieces = self.ground.approach(pose, goal, is_free=True) if is_back else self.ground.link(pose, goal)
        if pieces is None:
            where = "where it stands" if is_first else "the piece before"
            text = f"No known way leads from {where} to {work.name}. "
            raise PlanRefused(
                "no_way", text + ("Drive it nearer by hand, then repeat." if is_back else "Choose other rows.")
            )
        kind = LegKind.APPROACH if is_back else LegKind.TURN
        slow_mps = 0.6 if is_back else self.machine.turn_speed_mps
        return [_document(kind, p, self.ground.way_speed(p, slow_mps)) for p in pieces]

    def _known_way(self, before: int | None, number: int | None) -> list[Document] | None:
        """Return the base's own segments between two pieces if nothing was in between and nothing stands there now."""
        if before is None or number is None or number <= before:
            return None
        between = [
            dict(self.left[k - self.first] if k - self.first >= 0 else self.base["segments"][k])
            for k in range(before + 1, number)
        ]
        is_clear = all(self.ground.is_clear(np.asarray(s["points"], dtype=float)) for s in between)
        return between if is_clear and not any(is_work(s) for s in between) else None

    def _exit(self, pose: Pose, before: int | None, *, is_first: bool) -> list[Document]:
        if self.wish.end == "stay" or self.home is None:
            return []
        if self.wish.end == "as_planned":
            if self.base["at_end"] == "stay":
                return []
            known = self._known_way(before, len(self.base["segments"]))
            if known is not None and (known or not is_first):
                return known
        target: Pose = (self.home[0], self.home[1], math.atan2(pose[1] - self.home[1], pose[0] - self.home[0]))
        pieces = self.ground.approach(pose, target, is_free=False)
        if pieces is None:
            self.notes.append("No known way leads home. The robot stays at the end.")
            return []
        return [_document(LegKind.EXIT, p, self.ground.way_speed(p, 0.6)) for p in pieces]

    def _home(self) -> tuple[float, float] | None:
        if self.wish.home is not None:
            x, y = self.frame.to_local([self.wish.home])[0]
            return round(float(x), 3), round(float(y), 3)
        home = self.base.get("home")
        return None if home is None else (float(home[0]), float(home[1]))

    def _at_speed(self, segment: Document) -> Document:
        wanted = self.wish.row_speed_mps
        if wanted is None:
            return segment
        top = self.wish.robot.max_speed_mps if self.wish.robot is not None else wanted
        return {**segment, "speed_mps": round(min(wanted, top), 3)}

    # the answer

    def _pivoted(self, head: Sequence[Document], rest: Sequence[Document]) -> list[Document]:
        """Declare the corners of the new path."""
        result: list[Document] = []
        before = _leg(head[-1]) if head else None
        for one in rest:
            leg = _leg(one)
            angle = 0.0 if before is None or one.get("jump") else abs(turn_between(before, leg))
            if angle > GENTLE_RAD and not self.machine.can_pivot:
                raise PlanRefused("turn_does_not_fit", "The robot's turning circle does not fit there.")
            result.append({**one, "pivot": angle > GENTLE_RAD})
            before = leg
        return result

    def _planned(self, head: list[Document], rest: list[Document], left_out: list[_Work]) -> PlannedRest:
        is_home = rest[-1]["kind"] == "exit"
        tool_before, tool_after = _tool_m(self.base["segments"]), _tool_m([*head, *rest])
        whole: Document = {
            **self.base,
            "revision": self.wish.revision,
            "segments": [*head, *rest],
            "area_m2": round(self.base["area_m2"] * tool_after / tool_before, 1) if tool_before else 0.0,
            "at_end": "return_home" if is_home else "stay",
            "home": None if self.home is None else list(self.home),
            "continues": {"base_sha256": self.wish.base_sha256, "segments": len(head)},
        }
        if self.wish.map_version is not None:
            whole["map_version"] = dict(self.wish.map_version)
        document = canonical(whole)
        ahead = self.base["segments"][len(self.done) : len(head)] if self.wish.is_running else []
        if self.wish.is_running and len(self.done) > self.first:
            ahead = [self.left[0], *ahead]
        return PlannedRest(
            document,
            mission_sha256(document),
            self._statistics([*head, *rest], tool_after / tool_before if tool_before else 0.0),
            {
                "before": self._effort(self.left),
                "after": self._effort([*ahead, *rest]),
                "left_out": [w.name.capitalize() for w in left_out],
                "kept_until": self._kept_until(head),
                "way_m": round(sum(length_m(s) for s in _until_work(rest)), 1) if self.wish.stand else 0.0,
                "notes": self.notes,
            },
        )

    def _kept_until(self, head: Sequence[Document]) -> str:
        if not self.wish.is_running:
            return "The new path begins where it stands."
        name = f"row {head[-1]['row']}" if head[-1]["row"] else "this headland lap"
        return f"The new path begins after {name}."

    def _effort(self, segments: Sequence[Document]) -> dict[str, Any]:
        work = effort([_leg(s) for s in segments], self.machine)
        return {
            "duration_s": round(work.duration_s, 1),
            "energy_j": round(work.energy_j),
            "battery_share": round(work.energy_j / self.machine.battery_j, 4),
            "length_m": round(work.length_m, 1),
            "area_m2": round(work.working_length_m * self.base["width_m"], 1),
            "rows": len({s["row"] for s in segments if s["row"]}),
        }

    def _statistics(self, segments: Sequence[Document], share: float) -> dict[str, Any]:
        """Return the figures of the whole mission that changed; ``share`` of its area is left."""
        work = effort([_leg(s) for s in segments], self.machine)
        return {
            "length_m": round(work.length_m, 4),
            "working_length_m": round(work.working_length_m, 4),
            "duration_s": round(work.duration_s, 4),
            "working_s": round(work.working_s, 4),
            "rows": len({s["row"] for s in segments if s["row"]}),
            "turns": work.turns,
            "pivots": work.pivots,
            "energy_j": round(work.energy_j, 1),
            "battery_share": round(work.energy_j / self.machine.battery_j, 4),
            "covered_share": round(share, 4),
            "notes": list(self.notes),
        }


def _leg(segment: Document) -> Leg:
    points = np.asarray(segment["points"], dtype=float)
    return Leg(
        LegKind(segment["kind"]),
        points,
        segment["speed_mps"],
        bool(segment.get("tool_on")),
        int(segment.get("row", 0)),
        bool(segment.get("pivot")) and not segment.get("jump"),
    )


def _document(kind: LegKind, points: Floats, speed_mps: float) -> Document:
    rounded = np.round(points, 3) + 0.0
    keep = np.append(True, np.any(np.diff(rounded, axis=0) != 0, axis=1))
    kept = rounded[keep] if keep.sum() > 1 else rounded[[0, -1]]
    return {
        "kind": kind.value,
        "points": kept.tolist(),
        "speed_mps": round(speed_mps, 3),
        "tool_on": False,
        "row": 0,
        "pivot": False,
    }


def _end_pose(points: Floats) -> Pose:
    return float(points[-1][0]), float(points[-1][1]), float(headings(points)[-1])


def _tool_m(segments: Sequence[Document]) -> float:
    return sum(length_m(s) for s in segments if s.get("tool_on"))


def _until_work(segments: Sequence[Document]) -> list[Document]:
    found = []
    for one in segments:
        if is_work(one):
            break
        found.append(one)
    return found
