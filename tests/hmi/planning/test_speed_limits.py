"""Slow zones: paths are cut at their borders, driven slowly in them, and the time that is told counts it."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import shapely

from hmi.commands.plan_wish import surroundings_of
from hmi.domain.mission_document import Document
from hmi.domain.mission_plan import PlannedMission, Surroundings
from hmi.domain.mission_rest import PlannedRest, Progress, RestWish, pieces_of
from hmi.planning.coverage import plan_coverage
from hmi.planning.estimate import effort
from hmi.planning.given_path import checked_mission, segments_of
from hmi.planning.machine import RobotProfile
from hmi.planning.mission import job_of, plan_mission
from hmi.planning.plan import Leg, LegKind
from hmi.planning.rest import plan_rest
from hmi.planning.rest_work import legs_of
from hmi.planning.speed_limits import SpeedLimits
from hmi.store.features import Feature
from tests.hmi.missions.rig import FARM, lon_lat, parcel_geometry
from tests.hmi.missions.test_document import wish
from tests.hmi.planning.test_rest import ROAD

LIMIT = 0.2
ZONE = shapely.box(5, 10, 25, 20)
REACH = RobotProfile().reach_m


def zone(box: shapely.Polygon = ZONE) -> dict[str, Any]:
    return {"type": "Polygon", "coordinates": [lon_lat(*box.exterior.coords)]}


def around(*limits: tuple[shapely.Polygon, float]) -> Surroundings:
    return Surroundings(ways=((ROAD, 6.0),), slow=tuple((zone(box), most) for box, most in limits))


def planned(*limits: tuple[shapely.Polygon, float], **more: Any) -> PlannedMission:
    home = tuple(lon_lat((-8.0, 20.0))[0])
    return plan_mission(wish(home=home, returns_home=True, surroundings=around(*limits), **more))


def too_fast_m(document: Document, area: shapely.Geometry, most: float) -> float:
    """Return how far the path is driven faster than that on an area."""
    return sum(
        shapely.LineString(one["points"]).intersection(area).length
        for one in document["segments"]
        if one["speed_mps"] > most
    )


def line(document: Document) -> shapely.LineString:
    return shapely.LineString(np.vstack([one["points"] for one in document["segments"]]))


def test_no_part_of_the_machine_is_faster_in_a_slow_zone_than_it_says() -> None:
    free, slow = planned(), planned((ZONE, LIMIT))
    inside = ZONE.buffer(REACH - 0.15)  # slivers belong to their neighbours
    assert too_fast_m(free.document, inside, LIMIT) > 100
    assert too_fast_m(slow.document, inside, LIMIT) == 0
    beyond = shapely.box(-50, -50, 90, 90).difference(ZONE.buffer(REACH + 0.15))
    kept = [one for one in slow.document["segments"] if one["speed_mps"] <= LIMIT]
    assert sum(shapely.LineString(one["points"]).intersection(beyond).length for one in kept) == 0
    assert line(slow.document).hausdorff_distance(line(free.document)) < 0.01


def test_the_time_told_is_that_of_the_slower_path() -> None:
    free, slow = planned(), planned((ZONE, LIMIT))
    told = effort(legs_of(slow.document["segments"]), RobotProfile())
    assert slow.statistics["duration_s"] == pytest.approx(told.duration_s, rel=1e-3)
    length_m = line(free.document).intersection(ZONE).length
    assert slow.statistics["duration_s"] - free.statistics["duration_s"] > length_m * (1 / LIMIT - 1 / 0.45)
    for same in ("rows", "turns", "pivots", "covered_m2", "overlap_m2"):
        assert slow.statistics[same] == free.statistics[same]


def test_the_slowest_of_several_zones_counts_and_one_faster_than_the_robot_changes_nothing() -> None:
    both = planned((ZONE, LIMIT), (shapely.box(5, 15, 25, 25), 0.35))
    assert too_fast_m(both.document, ZONE, LIMIT) == 0
    assert planned((ZONE, 5.0)).document == planned().document


def test_ways_to_the_field_and_turns_are_slow_there_too() -> None:
    yard = shapely.box(-10, 15, 0, 25)
    document = planned((yard, LIMIT)).document
    assert too_fast_m(document, yard, LIMIT) == 0
    kinds = {one["kind"] for one in document["segments"] if one["speed_mps"] <= LIMIT}
    assert {"approach", "exit"} <= kinds
    turns = planned((shapely.box(-5, -5, 9, 45), LIMIT)).document
    assert "turn" in {one["kind"] for one in turns["segments"] if one["speed_mps"] <= LIMIT}
    check_joined(turns)


def check_joined(document: Document) -> None:
    """One path without gaps and undeclared corners, no crumbs at the cuts."""
    legs = legs_of(document["segments"])
    for before, leg in pairwise(legs):
        assert math.dist(before.points[-1], leg.points[0]) < 0.003
        turn = abs(math.remainder(leg.first_heading_rad - before.last_heading_rad, 2 * math.pi))
        assert leg.pivot or turn <= math.radians(15)


def test_a_cut_beside_a_corner_of_the_line_lies_on_it() -> None:
    arc = np.array([[math.sin(a), 1 - math.cos(a)] for a in np.linspace(0, 1.5, 16)])
    at = float(np.hypot(*np.diff(arc[:8], axis=0).T).sum()) + 0.01
    x = float(np.interp(at, np.append(0, np.cumsum(np.hypot(*np.diff(arc, axis=0).T))), arc[:, 0]))
    limits = SpeedLimits(((shapely.box(x, -5, 5, 5), 0.1),))
    before, after = limits.cut([Leg(LegKind.TURN, arc, 0.3, pivot=True)])
    assert (len(before.points), before.speed_mps, before.pivot) == (8, 0.3, True)
    assert (len(after.points), after.speed_mps, after.pivot) == (9, 0.1, False)


def test_a_path_from_a_service_is_slowed_down_here() -> None:
    asked = wish(surroundings=around((ZONE, LIMIT)))
    legs = plan_coverage(job_of(replace(asked, surroundings=around()))).legs
    made = checked_mission(asked, segments_of(legs), [])
    assert too_fast_m(made.document, ZONE, LIMIT) == 0
    assert made.statistics["duration_s"] > plan_mission(replace(asked, surroundings=around())).statistics["duration_s"]


def rest(base: PlannedMission, limits: Surroundings, **more: Any) -> PlannedRest:
    segment = next(k for k, one in enumerate(base.document["segments"]) if one["row"] == 2)
    progress = Progress(base.sha256, segment, 5.0)
    return plan_rest(RestWish(base.document, base.sha256, 2, progress, surroundings=limits, **more))


def test_a_zone_drawn_since_counts_for_the_rest_and_a_higher_speed_ends_at_it() -> None:
    base = planned()
    made = rest(base, around((ZONE, LIMIT)))
    done = made.document["continues"]["segments"]
    left = {**made.document, "segments": made.document["segments"][done:]}
    assert too_fast_m(left, ZONE, LIMIT) == 0
    check_joined(made.document)
    slow = planned((ZONE, LIMIT))
    faster = rest(slow, around((ZONE, LIMIT)), row_speed_mps=0.6)
    done = faster.document["continues"]["segments"]
    left = {**faster.document, "segments": faster.document["segments"][done:]}
    assert too_fast_m(left, ZONE, LIMIT) == 0
    assert {one["speed_mps"] for one in left["segments"] if one["tool_on"]} == {0.6, LIMIT}


def test_a_rest_of_a_slowed_mission_is_cut_at_the_same_places() -> None:
    slow = planned((ZONE, LIMIT))
    made = rest(slow, around((ZONE, LIMIT)))
    assert len(made.document["segments"]) == len(slow.document["segments"]) + 1
    assert len(pieces_of(slow.document, Progress(slow.sha256, 0, 0.0))) > 0


def test_the_map_gives_the_zones_with_their_speeds() -> None:
    near = Feature("bees", FARM, "slow", "Bees", zone(), {"speed_mps": 0.3})
    silent = Feature("kids", FARM, "slow", "Kids", zone(), {})
    found = surroundings_of([near, silent], parcel_geometry(), "field-1")
    assert found.slow == ((zone(), 0.3), (zone(), 0.5))
