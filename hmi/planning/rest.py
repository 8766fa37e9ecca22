"""The rest of a mission planned anew: what is done stays, what is left out goes, new ways join the pieces.

The document that comes out begins with the path that stays, point by point, so that the robot can compare it; see
*Updates* in docs/protocols/edge.md.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hmi.domain.family import Family
from hmi.domain.mission_document import Document, canonical, mission_sha256
from hmi.domain.mission_plan import PlanRefused
from hmi.domain.mission_rest import PlannedRest, RestWish, cut, is_work, length_m
from hmi.planning.dubins import Pose
from hmi.planning.flight import flight_notes
from hmi.planning.machine import RobotProfile
from hmi.planning.plan import GENTLE_RAD, Leg, LegKind, headings, turn_between
from hmi.planning.projection import Floats, LocalFrame
from hmi.planning.rest_figures import effort_of, statistics_of, tool_m
from hmi.planning.rest_ground import LEAST_PART_M, TOUCH_M, RestGround
from hmi.planning.rest_laps import Laps, RestLaps
from hmi.planning.rest_work import (
    Work,
    check_is_one_path,
    document_of,
    driven_through,
    gap,
    is_one_line,
    leg_of,
    off,
    place_of,
    rounded_points,
    turned,
    turned_line,
)

AHEAD_M = 10.0  # a running robot drives on while a person looks at the new rest: the new path begins beyond this
MAX_SEGMENTS = 20_000
FEW_MISSED = 0.01  # of the field: no other way to lay the laps is tried for less
MUCH_MISSED = 0.05  # of the field: then it is worth planning it anew
TOLD_MISSED_M2 = 1.0
NO_WAY = ("no_way", "turn_does_not_fit", "gap")


def plan_rest(wish: RestWish) -> PlannedRest:
    """Return the document that goes on with ``wish.base``; blocks for up to seconds.

    Raises:
        PlanRefused: nothing is left, or a piece cannot be reached; says why.
    """
    found: list[PlannedRest] = []
    refusal: PlanRefused | None = None
    for laps in Laps:
        rest = _Rest(wish, laps)
        if laps.lays and rest.ground.headland is None:  # no edge moved, or it has no laps
            continue
        try:
            found.append(rest.run())
        except PlanRefused as refused:
            if refused.code not in NO_WAY and not laps.lays:
                raise
            refusal = refused
            continue
        if not rest.ground.has_new_edge or found[-1].difference["missed_m2"] <= FEW_MISSED * rest.ground.field.area:
            break
    if not found:
        assert refusal is not None
        raise refusal
    return min(found, key=lambda one: float(one.difference["missed_m2"]))


class _Rest:
    """One rest while it is planned."""

    def __init__(self, wish: RestWish, laps: Laps) -> None:
        self.wish, self.laps = wish, laps
        self.base = wish.base
        self.machine = RobotProfile() if wish.robot is None else RobotProfile.from_factsheet(wish.robot)
        if wish.robot is not None and wish.robot.family is Family.PLANTER:
            self.machine = self.machine.planting(wish.base["width_m"], wish.base.get("plant_spacing_m"))
        self.frame = LocalFrame(wish.base["datum"]["lat_deg"], wish.base["datum"]["lon_deg"])
        self.lead_in_m, self.lead_out_m = wish.lead_m or (self.machine.lead_in_m, self.machine.lead_out_m)
        self.notes: list[str] = []
        self.idle_m, self.idle_rows = 0.0, set[str]()
        progress = wish.progress
        self.done, self.left, self.first = cut(wish.base["segments"], progress.segment, progress.segment_s_m)
        self.home = self._home()
        self.ground = RestGround(wish, self.frame, self.machine, self.home, lays_laps=laps.lays)
        self.laps_anew: RestLaps | None = None
        self.shorter_m: list[float] = []

    def run(self) -> PlannedRest:
        """Return the rest with these laps; raises ``PlanRefused``."""
        head, start, works = self._stitched()
        self.notes += flight_notes(self.wish.surroundings, self.frame, self.machine, self.ground.parcel, self.home)
        left_out = [work for work in works if self._is_left_out(work)]
        chosen = self._with_laps(self._chosen(works), head, left_out)
        is_laid = self.laps_anew is None or self.laps_anew.is_done
        if is_laid and not any(chosen) and not self.wish.is_running:
            raise PlanRefused("nothing_left", "Nothing is left to do. Abort the mission, or start fresh.")
        rest = [piece for one in self._joined(chosen, start, head) for piece in self._slowed(one)]
        if not rest:
            raise PlanRefused("nothing_left", "It finishes its last row. There is nothing left to change.")
        if len(head) + len(rest) > MAX_SEGMENTS:
            raise PlanRefused("too_many_rows", "The mission would have too many pieces for the robot.")
        check_is_one_path(head, rest)
        return self._planned(head, self._pivoted(head, rest), left_out)

    # what stays

    def _stitched(self) -> tuple[list[Document], int, list[Work]]:
        """Return the path that stays, the number of the base's first segment after it, and the work after it."""
        works = [Work.of(one, number) for number, one in enumerate(self.left, self.first) if is_work(one)]
        if not self.wish.is_running:
            return self.done, self.first, works
        ahead_m = 0.0
        for number, one in enumerate(self.left, self.first):
            ahead_m += length_m(one)
            if is_work(one) and ahead_m >= AHEAD_M:
                head = [dict(s) for s in self.base["segments"][: number + 1]]
                self._check_ahead(self.left[: number + 1 - self.first], [w for w in works if (w.begins or 0) <= number])
                return head, number + 1, [w for w in works if w.begins is not None and w.begins > number]
        raise PlanRefused("nothing_left", "It is in its last row. There is nothing left to change.")

    def _check_ahead(self, ahead: Sequence[Document], works: Sequence[Work]) -> None:
        """Say what can no longer be changed; raise if the robot would meet what is new before the new path."""
        legs = map(leg_of, ahead)
        met = (self.ground.met(leg.points, is_backward=leg.is_backward, pivot=leg.pivot) for leg in legs)
        what = next(filter(None, met), "")
        if what:
            text = f"{what} is on the path before the new one begins. Pause the robot, then change the rest."
            raise PlanRefused("obstacle_ahead", text, "areas")
        for work in works:
            if self._is_left_out(work):
                self.notes.append(f"It is too near {work.name} to leave it out. Pause it first.")
            elif len(self._by_dose(work)) > 1:
                self.notes.append(f"It is too near {work.name} to leave the area out. Pause it first.")

    def _turned_points(self, number: int | None) -> Floats:
        """Return where a segment that is left runs the other way round, with the borders of the tool moved."""
        assert number is not None
        here = number - self.first
        first, last = here, here
        while first > 0 and is_one_line(self.left[first - 1 : first + 1]):
            first -= 1
        while last + 1 < len(self.left) and is_one_line(self.left[last : last + 2]):
            last += 1
        return turned_line(self.left[first : last + 1], self.lead_in_m - self.lead_out_m)[last - here]

    def _is_left_out(self, work: Work) -> bool:
        return work.begins in self.wish.leave_out

    def _chosen(self, works: Sequence[Work]) -> list[Work]:
        """Return what is done, in the order wished for, cut where something stands in the way."""
        chosen = [w for w in works if not self._is_left_out(w)]
        if self.wish.is_reversed and chosen:
            is_inside = not self.wish.is_running and len(self.done) > self.first and chosen[0].begins == self.first
            kept, others = (chosen[:1], chosen[1:]) if is_inside else ([], chosen)
            chosen = [*kept, *(turned(work, self._turned_points(work.begins)) for work in others[::-1])]
        return chosen

    def _with_laps(
        self, chosen: Sequence[Work], head: Sequence[Document], left_out: Sequence[Work]
    ) -> list[Work | None]:
        """Return the work cut where it has to be; ``None`` stands for the laps laid anew."""
        laps = [work.segment["kind"] == "headland" for work in chosen]
        is_all = self.laps in (Laps.ALL_ANEW, Laps.LEAVING)
        is_moved = [lap and (is_all or self.ground.is_moved(w.segment)) for lap, w in zip(laps, chosen, strict=True)]
        parts = [[] if gone else self._around(work) for work, gone in zip(chosen, is_moved, strict=True)]
        if sum(self.shorter_m) >= LEAST_PART_M:
            lost_m, rows = sum(self.shorter_m), len(self.shorter_m)
            self.notes.append(f"Rows end sooner, at the headland of the new edge: {lost_m:.0f} m in {rows} of them.")
        kept = [self._without_areas(one) for one in parts]
        self._note_areas()
        before, after = kept, []
        if self.ground.headland is not None:
            rest = [work.segment for group in kept for work in group]
            missing = self.ground.missing([*head, *rest], [work.segment for work in left_out])
            self.laps_anew = self.ground.laps_anew(missing)
            ends = [k + 1 for k, work in enumerate(chosen) if self.ground.ends_at_edge(work.points)]
            at = is_moved.index(True) if any(is_moved) else max(ends, default=len(chosen))
            at = len(chosen) if is_all else at
            before, after = kept[:at], kept[at:]
        # those that cannot be reached from there are tried again at the end
        return [*(w for group in before for w in group), None, *(w for group in after for w in group), None]

    def _around(self, work: Work) -> list[Work]:
        is_lap = self.laps is not Laps.WHOLE and work.segment["kind"] == "headland"
        parts = self.ground.around(work.points, is_lap=is_lap)
        if parts is None:
            return [work]
        lost = length_m(work.segment) - sum(float(np.hypot(*np.diff(p, axis=0).T).sum()) for p in parts)
        if self.ground.ends_at_edge(work.points):
            self.shorter_m.append(lost)
        else:
            self.notes.append(f"{work.name.capitalize()}: {lost:.0f} m left out, something stands there.")
        if not parts:
            return []
        found = work.parts([{**work.segment, "points": p.tolist()} for p in parts], is_joined=False)
        return [replace(one, is_spare=is_lap) for one in found]

    def _without_areas(self, works: Sequence[Work]) -> list[Work]:
        """Turn the tool off inside areas to leave out; a piece that lies in them whole is not driven."""
        found: list[Work] = []
        for work in works:
            pieces = self._by_dose(work)
            idle = [one for one in pieces if not one["tool_on"]]
            if idle:
                self.idle_m += sum(map(length_m, idle))
                self.idle_rows.add(work.name)
            if len(idle) < len(pieces):
                found += work.parts(pieces, is_joined=True)
        return found

    def _note_areas(self) -> None:
        if self.idle_rows:
            rows = len(self.idle_rows)
            self.notes.append(f"{self.idle_m:.0f} m in {rows} rows or laps are left out in the area drawn.")
        elif not self.ground.doses.is_plain:
            self.notes.append("Nothing that is left lies in the area to leave out.")

    def _by_dose(self, work: Work) -> list[Document]:
        legs = self.ground.doses.cut([leg_of(work.segment)])
        if len(legs) == 1 and legs[0].tool_on:
            return [work.segment]
        return [
            {**(work.segment if leg.tool_on else off(work.segment)), "points": rounded_points(leg.points)}
            for leg in legs
        ]

    # ways

    def _joined(self, chosen: Sequence[Work | None], start: int, head: Sequence[Document]) -> list[Document]:
        rest: list[Document] = []
        before: Work | None = None
        is_left, stuck = False, None
        if self.wish.stand is None:  # its path goes on: what lay before its place is known
            before = Work({}, ends=start - 1)
        pose = self._beginning(head)
        is_inside = self.wish.stand is None and not self.wish.is_running and len(head) > start
        for work in chosen:
            if work is None and self.laps_anew is not None and not self.laps_anew.is_done:
                rest += self._laps_driven(pose, is_first=not rest)
                pose, before = (_end_pose(rest[-1]) if rest else pose), None
            if work is None:
                continue
            is_there = is_inside and not rest and work.begins == start
            if is_left and work.is_joined:  # it goes on from a piece that is left out
                continue
            is_left = False
            if not is_there and not work.is_joined:
                try:
                    rest += self._way(pose, before, work, is_first=not rest)
                except PlanRefused as refused:
                    if not work.is_spare and self.laps is not Laps.LEAVING:
                        raise
                    stuck, is_left = stuck or refused, True
                    lost_m = length_m(work.segment)
                    self.notes.append(f"{work.name.capitalize()}: {lost_m:.0f} m left out, no way leads there.")
                    continue
            rest.append(self._at_speed(work.segment))
            pose, before = _end_pose(work.segment), work
        if stuck is not None and not any(map(is_work, rest)):
            raise stuck
        self.notes += [] if self.laps_anew is None else self.laps_anew.notes
        rest += self._exit(pose, before, is_first=not rest)
        if (self.wish.stand is not None or self._is_taken_up) and rest:
            rest[0] = {**rest[0], "jump": True}
        return rest

    def _laps_driven(self, pose: Pose, *, is_first: bool) -> list[Document]:
        """Return the laps that are laid anew, with the ways between them."""
        assert self.laps_anew is not None
        legs = self.laps_anew.drive(pose, lambda a, b: self._legs_to(a, b, is_first=is_first and a == pose))
        return [self._at_speed(document_of(leg)) for leg in self.ground.doses.cut(legs)]

    def _beginning(self, head: Sequence[Document]) -> Pose:
        """Return where the new path begins."""
        if self.wish.stand is not None:
            lon, lat, heading = self.wish.stand
            x, y = self.frame.to_local([(lon, lat)])[0]
            return round(float(x), 3), round(float(y), 3), heading
        if head and not self._is_taken_up:
            return _end_pose(head[-1])
        leg = leg_of(self.left[0])
        return float(leg.points[0][0]), float(leg.points[0][1]), leg.first_heading_rad

    @property
    def _is_taken_up(self) -> bool:
        """Whether it stands where it was taken up before, and has driven nothing since."""
        is_there = not self.wish.is_running and len(self.done) == self.first
        return is_there and bool(self.left) and bool(self.left[0].get("jump"))

    def _way(self, pose: Pose, before: Work | None, work: Work, *, is_first: bool) -> list[Document]:
        points = work.points
        known = self._known_way(before, work.begins)
        if known is None and before is not None:
            known = self._known_way_back(before.turned, work.turned)
        if known is not None and gap(pose[:2], [*known, work.segment]) is None:
            return known
        goal: Pose = (float(points[0][0]), float(points[0][1]), float(headings(points)[0]))
        legs = self._legs_to(pose, goal, is_first=is_first)
        if legs is None:
            raise PlanRefused("no_way", self._no_way(pose, work, is_first=is_first))
        return [document_of(leg) for leg in legs]

    def _legs_to(self, pose: Pose, goal: Pose, *, is_first: bool) -> list[Leg] | None:
        approach = LegKind.APPROACH
        if is_first and self.wish.stand is not None:
            return self.ground.approach(approach, pose, goal, is_free=True)
        legs = self.ground.turn(pose, goal)
        if legs is None and is_first and not self.wish.is_running:  # off the field yet, or half over its new edge
            legs = self.ground.approach(approach, pose, goal, is_free=False)
        return legs

    def _no_way(self, pose: Pose, work: Work, *, is_first: bool) -> str:
        by_hand = f"{'Fly' if self.machine.flies else 'Drive'} it"
        if is_first and self.wish.stand is None and self.ground.is_lost(pose):
            return f"It stands over the field's new edge. {by_hand} back by hand, then choose Resume later."
        where = "where it stands" if is_first else "the piece before"
        is_back = is_first and self.wish.stand is not None
        then = f"{by_hand} nearer by hand, then repeat." if is_back else "Choose other rows."
        then = "Pause the robot, then change the rest." if is_first and self.wish.is_running else then
        return f"No known way leads from {where} to {work.name}. {then}"

    def _known_way(self, before: Work | None, number: int | None) -> list[Document] | None:
        """Return the base's own segments between two pieces if nothing was in between and nothing stands there now."""
        if before is None or before.ends is None or number is None or number <= before.ends:
            return None
        segments = self.base["segments"]
        first = segments[before.ends] if before.ends >= 0 else None
        if before.ends == self.first - 1 and len(self.done) > self.first:
            first = self.done[-1]  # it stands inside this piece
        last = segments[number] if number < len(segments) else None
        between = driven_through(first, self._between(before.ends, number), last)
        return None if between is None else self._clear(between, last)

    def _known_way_back(self, later: int | None, number: int | None) -> list[Document] | None:
        """Return what lies between two pieces of one row or lap that are driven the other way round."""
        if later is None or number is None or number >= later:
            return None
        between = self._between(number, later)
        if not is_one_line([self.base["segments"][number], *between, self.base["segments"][later]]):
            return None
        points = [rounded_points(self._turned_points(k)) for k in range(later - 1, number, -1)]
        back = [{**off(one), "points": p, "pivot": False} for one, p in zip(between[::-1], points, strict=True)]
        return self._clear(back)

    def _between(self, first: int, last: int) -> list[Document]:
        """Return the segments after ``first`` and before ``last``, without what of them is done."""
        whole = self.base["segments"]
        return [dict(self.left[k - self.first] if k >= self.first else whole[k]) for k in range(first + 1, last)]

    def _clear(self, between: list[Document], then: Document | None = None) -> list[Document] | None:
        """Return segments if nothing stands in their way, turning on the spot before ``then`` included."""
        legs = [leg_of(one) for one in between]
        turns = [leg.points[0] for leg in (*legs, *([leg_of(then)] if then else [])) if leg.pivot]
        is_clear = all(self.ground.is_clear(leg.points, is_backward=leg.is_backward) for leg in legs)
        is_clear = is_clear and all(self.ground.can_turn(place, self.machine.margin_m / 2) for place in turns)
        return between if is_clear else None

    def _exit(self, pose: Pose, before: Work | None, *, is_first: bool) -> list[Document]:
        if self.wish.end == "stay" or self.home is None:
            return []
        if self.wish.end == "as_planned":
            if self.base["at_end"] == "stay":
                return []
            known = self._known_way(before, len(self.base["segments"]))
            if known is not None and (known or not is_first) and gap(pose[:2], known) is None:
                return known
        target: Pose = (self.home[0], self.home[1], math.atan2(pose[1] - self.home[1], pose[0] - self.home[0]))
        legs = self.ground.approach(LegKind.EXIT, pose, target, is_free=False)
        if legs is None:
            self.notes.append("No known way leads home. The robot stays at the end.")
            return []
        return [document_of(leg) for leg in legs]

    def _home(self) -> tuple[float, float] | None:
        if self.wish.home is not None:
            x, y = self.frame.to_local([self.wish.home])[0]
            return round(float(x), 3), round(float(y), 3)
        home = self.base.get("home")
        return None if home is None else (float(home[0]), float(home[1]))

    def _at_speed(self, segment: Document) -> Document:
        wanted = self.wish.row_speed_mps
        if wanted is None or not segment["tool_on"]:
            return segment
        top = self.wish.robot.max_speed_mps if self.wish.robot is not None else wanted
        # more than the usual dose takes more time on each metre, as it was planned
        return {**segment, "speed_mps": round(min(wanted, top) / max(1.0, segment.get("dose", 1.0)), 3)}

    def _slowed(self, segment: Document) -> list[Document]:
        """Return a segment cut at the slow zones of the map."""
        whole = leg_of(segment)
        first, *others = self.ground.limits.pieces(whole)
        if first is whole:
            return [segment]
        later = {key: value for key, value in segment.items() if key != "jump"} | {"pivot": False}
        return [
            {**one, "points": rounded_points(leg.points), "speed_mps": round(leg.speed_mps, 3)}
            for one, leg in ((segment, first), *((later, leg) for leg in others))
        ]

    # the answer

    def _pivoted(self, head: Sequence[Document], rest: Sequence[Document]) -> list[Document]:
        """Declare the corners of the new path."""
        result: list[Document] = []
        before = leg_of(head[-1]) if head else None
        for one in rest:
            leg = leg_of(one)
            angle = 0.0 if before is None or one.get("jump") else abs(turn_between(before, leg))
            if angle > GENTLE_RAD and not self.machine.can_pivot:
                raise PlanRefused("turn_does_not_fit", "The robot's turning circle does not fit there.")
            if angle > GENTLE_RAD and not self.ground.can_turn(leg.points[0], -TOUCH_M):
                text = f"Turning on the spot {place_of(one)}, the robot would swing into what stands there. "
                then = "Choose other rows." if result else "Drive it away by hand, then choose Resume later."
                raise PlanRefused("turn_does_not_fit", text + then)
            result.append({**one, "pivot": angle > GENTLE_RAD})
            before = leg
        return result

    def _planned(self, head: list[Document], rest: list[Document], left_out: list[Work]) -> PlannedRest:
        is_home = rest[-1]["kind"] == "exit"
        tool_before, tool_after = tool_m(self.base["segments"]), tool_m([*head, *rest])
        whole: Document = {
            **self.base,
            "revision": self.wish.revision,
            "parcel": self.ground.outline,
            "segments": [*head, *rest],
            "area_m2": round(self.base["area_m2"] * tool_after / tool_before, 1) if tool_before else 0.0,
            "at_end": "return_home" if is_home else "stay",
            "home": None if self.home is None else list(self.home),
            "continues": {"base_sha256": self.wish.base_sha256, "segments": len(head)},
        }
        if self.wish.map_version is not None:
            whole["map_version"] = dict(self.wish.map_version)
        document = canonical(whole)
        missed_m2 = self._missed_m2([*head, *rest], left_out)
        ahead = self.base["segments"][len(self.done) : len(head)] if self.wish.is_running else []
        if self.wish.is_running and len(self.done) > self.first:
            ahead = [self.left[0], *ahead]
        return PlannedRest(
            document,
            mission_sha256(document),
            statistics_of(
                self.wish,
                self.machine,
                [*head, *rest],
                share=tool_after / tool_before if tool_before else 0.0,
                notes=self.notes,
            ),
            {
                "before": effort_of(self.left, self.machine, self.base["width_m"]),
                "after": effort_of([*ahead, *rest], self.machine, self.base["width_m"]),
                "left_out": [w.name.capitalize() for w in left_out],
                "kept_until": self._kept_until(head),
                "way_m": round(sum(length_m(s) for s in _until_work(rest)), 1) if self.wish.stand else 0.0,
                "missed_m2": missed_m2,
                "notes": self.notes,
            },
        )

    def _missed_m2(self, segments: Sequence[Document], left_out: Sequence[Work]) -> float:
        """Return how much of what was to be worked, and could be, is not any more; say so."""
        missing = self.ground.missing(segments, [work.segment for work in left_out], self.base["width_m"] / 2)
        missed_m2 = float(missing.area)
        if missed_m2 >= TOLD_MISSED_M2:
            share = missed_m2 / self.ground.field.area
            way_out = " A new plan of the field may work more of it." if share > MUCH_MISSED else ""
            told = f"{missed_m2:.0f} m² of the field ({100 * share:.1f} %) stay unworked that were to be worked."
            self.notes.append(told + way_out)
        return round(missed_m2, 1)

    def _kept_until(self, head: Sequence[Document]) -> str:
        if not self.wish.is_running:
            return "The new path begins where it stands."
        name = f"row {head[-1]['row']}" if head[-1]["row"] else "this headland lap"
        return f"The new path begins after {name}."


def _end_pose(segment: Document) -> Pose:
    leg = leg_of(segment)
    return float(leg.points[-1][0]), float(leg.points[-1][1]), leg.last_heading_rad


def _until_work(segments: Sequence[Document]) -> list[Document]:
    found = []
    for one in segments:
        if is_work(one):
            break
        found.append(one)
    return found
