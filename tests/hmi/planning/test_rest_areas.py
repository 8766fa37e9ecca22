"""The rest of a mission cut by ground somebody drew: areas left out, obstacles that appeared."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import pytest
import shapely
from hypothesis import assume, event, example, given, settings
from hypothesis import strategies as st

from hmi.domain.mission_plan import PlanRefused, Surroundings
from hmi.domain.mission_rest import LEAVE_OUT, OBSTACLE, DrawnArea, PlannedRest, is_work, length_m, pieces_of
from hmi.planning.machine import RobotProfile
from tests.hmi.missions.rig import lon_lat
from tests.hmi.planning.test_rest import (
    at,
    check_is_whole,
    number_of,
    placed,
    places,
    planned,
    published,
    rest,
    segments,
    ways,
    work_m,
)


def drawn(kind: str, *corners: tuple[float, float], clearance_m: float = 0.0) -> DrawnArea:
    return DrawnArea(kind, tuple((lon, lat) for lon, lat in lon_lat(*corners)), clearance_m)


def box(kind: str, x0: float, y0: float, x1: float, y1: float, clearance_m: float = 0.0) -> DrawnArea:
    return drawn(kind, (x0, y0), (x1, y0), (x1, y1), (x0, y1), clearance_m=clearance_m)


def new_part(made: PlannedRest) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = made.document["segments"][made.document["continues"]["segments"] :]
    return found


def test_an_area_left_out_is_driven_through_with_the_tool_off() -> None:
    x = segments()[number_of(6)]["points"][0][0]
    made = rest(at(number_of(2), 5.0), areas=(box(LEAVE_OUT, x - 1, 15.0, x + 1, 25.0),))
    pieces = [one for one in new_part(made) if one["row"] == 6]
    assert [one["tool_on"] for one in pieces] == [True, False, True]
    assert length_m(pieces[1]) == pytest.approx(10.0, abs=0.01)
    assert work_m(made.document["segments"])["row", 6] == pytest.approx(
        length_m(segments()[number_of(6)]) - 10, abs=0.01
    )
    assert made.difference["notes"] == ["10 m in 1 rows or laps are left out in the area drawn."]
    check_is_whole(made)


def test_a_row_inside_an_area_left_out_is_not_driven() -> None:
    x = segments()[number_of(6)]["points"][0][0]
    made = rest(at(number_of(2), 5.0), areas=(box(LEAVE_OUT, x - 1, -5, x + 1, 45),))
    assert 6 not in {one["row"] for one in made.document["segments"]}
    assert {5, 7} <= {one["row"] for one in made.document["segments"]}
    check_is_whole(made)


def test_a_drawn_obstacle_is_kept_clear_of() -> None:
    x = segments()[number_of(6)]["points"][0][0]
    made = rest(at(number_of(2), 5.0), areas=(box(OBSTACLE, x - 0.5, 19.5, x + 0.5, 20.5, clearance_m=1.0),))
    nearest = min(math.dist(point, (x, 20.0)) for one in new_part(made) for point in one["points"])
    assert nearest > 0.5 + 1.0 + 0.8  # its edge, the clearance, half the machine
    assert sum(one["row"] == 6 and one["tool_on"] for one in new_part(made)) == 2
    check_is_whole(made)


def test_a_running_robot_that_would_meet_a_drawn_obstacle_first_must_be_paused() -> None:
    number = number_of(3)
    x, y = segments()[number]["points"][0][0], 20.0
    obstacle = box(OBSTACLE, x - 0.5, y - 0.5, x + 0.5, y + 0.5, clearance_m=0.5)
    with pytest.raises(PlanRefused, match="Pause the robot") as caught:
        rest(at(number, 5.0), areas=(obstacle,), is_running=True)
    assert caught.value.code == "obstacle_ahead"
    assert new_part(rest(at(number, 5.0), areas=(obstacle,)))


@pytest.mark.parametrize("before", [ways(), None], ids=["known map", "unknown map"])
def test_a_running_robot_that_would_meet_a_published_obstacle_first_must_be_paused(before: Surroundings | None) -> None:
    number = number_of(3)
    x = segments()[number]["points"][0][0]
    now = {"surroundings": published(x, 20.0, 1.0), "around_before": before}
    with pytest.raises(PlanRefused, match=r"ahead: Open ditch is on the path.*Pause the robot") as caught:
        rest(at(number, 5.0), is_running=True, **now)
    assert caught.value.code == "obstacle_ahead"
    assert new_part(rest(at(number, 5.0), **now))  # paused, it is driven around
    assert new_part(rest(at(number_of(2), 5.0), is_running=True, **now))


def test_only_what_is_new_keeps_the_machines_margin_from_a_path_that_stays() -> None:
    number = number_of(3)
    x = segments()[number]["points"][0][0]
    beside = published(x + RobotProfile().width_m / 2 + 1.0 + 0.02, 20.0, 1.0)  # two centimetres beside the outline
    assert new_part(rest(at(number, 5.0), is_running=True, surroundings=beside, around_before=beside))
    with pytest.raises(PlanRefused, match="ahead: Open ditch is on the path"):
        rest(at(number, 5.0), is_running=True, surroundings=beside, around_before=ways())


def test_a_running_robot_says_which_row_it_can_no_longer_leave_out() -> None:
    number = number_of(3)
    x = segments()[number]["points"][0][0]
    made = rest(at(number, 5.0), areas=(box(LEAVE_OUT, x - 1, 15, x + 4, 25),), is_running=True)
    assert "too near row 3" in " ".join(made.difference["notes"])
    assert any(not one["tool_on"] for one in new_part(made) if one["row"] == 4)


@pytest.mark.parametrize("corners", [((0, 0), (10, 10), (10, 0), (0, 10)), ((0, 0), (0.01, 0), (0.01, 0.01))])
def test_an_outline_that_is_no_area_is_refused(corners: tuple[tuple[float, float], ...]) -> None:
    with pytest.raises(PlanRefused) as caught:
        rest(at(number_of(2), 5.0), areas=(drawn(OBSTACLE, *corners),))
    assert (caught.value.code, caught.value.field) == ("bad_area", "areas")


@example(place=(0, 0.0), x=27.4921875, y=3.0, wide=4.0, is_reversed=False, is_running=False)  # a row on its edge
@settings(max_examples=25, deadline=None)
@given(
    place=places,
    x=st.floats(3.0, 30.0),
    y=st.floats(3.0, 30.0),
    wide=st.floats(1.0, 15.0),
    is_reversed=st.booleans(),
    is_running=st.booleans(),
)
def test_the_tool_is_never_on_in_an_area_left_out_and_works_everywhere_else_once(
    place: tuple[int, float], x: float, y: float, wide: float, is_reversed: bool, is_running: bool
) -> None:
    progress = placed(place)
    assume(pieces_of(planned().document, progress))
    try:
        made = rest(
            progress,
            areas=(box(LEAVE_OUT, x, y, x + wide, y + wide),),
            is_reversed=is_reversed,
            is_running=is_running,
        )
    except PlanRefused as error:
        event(error.code)
        return
    check_is_whole(made)
    ground = shapely.box(x, y, x + wide, y + wide)

    def inside(parts: Sequence[Mapping[str, Any]], area: shapely.Geometry = ground) -> float:
        lines = [shapely.LineString(one["points"]) for one in parts if is_work(one)]
        return sum(line.intersection(area).length for line in lines)

    assert inside(new_part(made), ground.buffer(-0.01)) < 0.3  # slivers below 0.1 m go to their neighbours
    kept = made.document["segments"][: made.document["continues"]["segments"]]
    wanted = sum(length_m(one) for one in segments() if is_work(one))
    left = inside(segments()) - inside(kept)
    done = sum(length_m(one) for one in made.document["segments"] if is_work(one))
    assert done == pytest.approx(wanted - left, abs=0.6)
