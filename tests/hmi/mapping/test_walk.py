"""Outlines and lines from walking."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence

import pytest
import shapely
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hmi.mapping.errors import BadWalk
from hmi.mapping.walk import Walked, WalkPoint, outline
from tests.hmi.mapping.farms import HERE, XY, box, degrees

SQUARE = box(0, 0, 80, 50)


def walk(
    corners: Sequence[XY], step_m: float = 0.7, accuracy_m: float = 0.02, noise_m: float = 0.0, seed: int = 1
) -> list[WalkPoint]:
    """Return positions along a way at 1.4 m/s, two a second."""
    chance = random.Random(seed)
    way = shapely.LineString(corners)
    count = math.ceil(way.length / step_m)
    at = [way.interpolate(min(n * step_m, way.length)).coords[0] for n in range(count + 1)]
    noisy = degrees([(x + chance.gauss(0, noise_m), y + chance.gauss(0, noise_m)) for x, y in at])
    return [WalkPoint(lon, lat, accuracy_m, n * 0.5) for n, (lon, lat) in enumerate(noisy)]


def ring(walked: Walked) -> shapely.Polygon:
    assert walked.coordinates[0] == walked.coordinates[-1]
    return shapely.Polygon(HERE.to_local(walked.coordinates))


def at(x: float, y: float, accuracy_m: float, at_s: float) -> WalkPoint:
    [[lon, lat]] = degrees([(x, y)])
    return WalkPoint(lon, lat, accuracy_m, at_s)


def test_a_field_walked_around_has_its_corners() -> None:
    walked = outline(walk(SQUARE), True, 0.5)
    assert len(walked.coordinates) == 5
    assert ring(walked).hausdorff_distance(shapely.Polygon(SQUARE)) < 1
    assert ring(walked).exterior.is_ccw
    assert (walked.accuracy_m, walked.tolerance_m) == (0.02, 0.5)


def test_a_field_walked_the_other_way_round_winds_the_same() -> None:
    assert ring(outline(walk(SQUARE[::-1]), True, 0.5)).exterior.is_ccw


def test_a_line_stays_open_and_keeps_its_ends() -> None:
    walked = outline(walk([(0, 0), (60, 0), (60, 40)]), False, 0.3)
    xy = HERE.to_local(walked.coordinates)
    assert len(xy) == 3
    assert xy[0] == pytest.approx((0, 0), abs=0.5)
    assert xy[-1] == pytest.approx((60, 40), abs=0.5)


@pytest.mark.parametrize("jumps", [[50], [50, 51, 52], [0], [20, 60, 100]])
def test_jumps_of_the_receiver_are_dropped(jumps: list[int]) -> None:
    points = walk(SQUARE)
    clean = outline(points, True, 0.5)
    for n in jumps:
        points[n] = at(-300 - n, 400, 0.02, points[n].at_s)
    walked = outline(points, True, 0.5)
    assert ring(walked).symmetric_difference(ring(clean)).area < 40
    assert walked.dropped >= len(jumps)
    assert walked.kept + walked.dropped == len(points)


def test_points_far_worse_than_the_others_are_dropped() -> None:
    points = walk(SQUARE)
    points[40] = at(28, -6, 9.0, points[40].at_s)
    assert ring(outline(points, True, 0.5)).hausdorff_distance(shapely.Polygon(SQUARE)) < 1


def test_positions_that_are_none_are_dropped() -> None:
    points = walk(SQUARE)
    points[10:14] = [
        WalkPoint(math.nan, 51.7, 0.02, 5.0),
        WalkPoint(4.2, 51.7, math.inf, 5.5),
        WalkPoint(4.2, 51.7, 0.0, 6.0),
        WalkPoint(4.2, 151.7, 0.02, 6.5),
    ]
    walked = outline(points, True, 0.5)
    assert walked.dropped >= 4
    assert ring(walked).area == pytest.approx(4000, rel=0.03)


def test_standing_makes_no_corners() -> None:
    chance = random.Random(3)
    before = walk([(0, 0), (60, 0)])
    stood = [at(60 + chance.gauss(0, 0.03), chance.gauss(0, 0.03), 0.05, 50 + n * 0.5) for n in range(200)]
    after = [WalkPoint(p.lon, p.lat, p.accuracy_m, p.at_s + 160) for p in walk([(60, 0), (60, 40)])]
    walked = outline([*before, *stood, *after], False, 0.3)
    assert len(walked.coordinates) == 3


def test_better_positions_weigh_more() -> None:
    points = [at(0, 0, 0.02, 0), at(0, 0.15, 0.06, 1), at(40, 0, 0.02, 60), at(40, 0.15, 0.06, 61)]
    walked = outline(points, False, 0.1)
    ys = HERE.to_local(walked.coordinates)[:, 1]
    assert ys == pytest.approx([0.015, 0.015], abs=0.003)


def test_the_end_that_runs_on_past_the_start_is_cut_off() -> None:
    points = walk([*SQUARE, (15, 0.3)])
    walked = outline(points, True, 0.5)
    assert ring(walked).is_valid
    assert ring(walked).hausdorff_distance(shapely.Polygon(SQUARE)) < 1
    assert walked.dropped >= 15


def test_the_outline_is_never_finer_than_the_receiver() -> None:
    walked = outline(walk(SQUARE, accuracy_m=1.5, noise_m=0.4), True, 0.1)
    assert walked.tolerance_m == walked.accuracy_m == 1.5
    assert len(walked.coordinates) < 12
    assert ring(walked).area == pytest.approx(4000, rel=0.08)


def test_positions_in_the_wrong_order_are_put_in_order() -> None:
    points = walk(SQUARE)
    mixed = random.Random(5).sample(points, len(points))
    assert outline(mixed, True, 0.5) == outline(points, True, 0.5)


BAY = [(0, 0), (100, 0), (100, 80), (60, 80), (60, 40), (40, 40), (40, 80), (0, 80), (0, 0)]
"""A field with a bay of 20 by 40 m."""


def test_a_stretch_without_positions_is_told_with_where_how_long_and_how_far() -> None:
    points = walk(BAY)
    assert outline(points, True, 0.1).gaps == []
    whole = ring(outline(points, True, 0.1)).area
    xy = HERE.to_local([(one.lon, one.lat) for one in points])
    seen = [one for one, (x, y) in zip(points, xy, strict=True) if not (39 < x < 61 and 39 < y < 79)]
    walked = outline(seen, True, 0.1)
    assert (walked.dropped, walked.accuracy_m) == (0, 0.02)
    assert ring(walked).area > whole + 700, "the bay is field now"
    [gap] = walked.gaps
    assert gap.metres == pytest.approx(20, abs=1)
    assert gap.seconds == pytest.approx(100 / 1.4, abs=2)
    assert HERE.to_local([gap.start, gap.end]) == pytest.approx(HERE.to_local(degrees([(60, 80), (40, 80)])), abs=2)


def test_positions_that_were_left_out_leave_a_gap_where_they_were_many() -> None:
    points = walk(SQUARE)
    poor = range(20, 40)  # below trees, 14 m
    points[20:40] = [at(14 + 0.7 * n, 6, 9.0, points[n].at_s) for n in poor]
    [gap] = outline(points, True, 0.5).gaps
    assert gap.metres == pytest.approx(21 * 0.7, abs=0.1)
    assert outline([*points[:20], *walk(SQUARE)[22:]], True, 0.5).gaps == [], "a second without one is none"


def test_a_receiver_that_jumps_for_good_leaves_a_gap() -> None:
    points = walk([(0, 0), (60, 0)])[:40] + [
        WalkPoint(one.lon, one.lat, one.accuracy_m, one.at_s + 20) for one in walk([(28, 300), (60, 300)])
    ]
    [gap] = outline(points, False, 0.3).gaps
    assert (gap.seconds, gap.metres) == (0.5, pytest.approx(300, abs=1))


@pytest.mark.parametrize("tolerance", [0, -1, math.nan, math.inf, 51])
def test_a_tolerance_out_of_range_is_refused(tolerance: float) -> None:
    with pytest.raises(BadWalk, match="bad_tolerance"):
        outline(walk(SQUARE), True, tolerance)


@pytest.mark.parametrize(
    ("points", "is_closed", "code"),
    [
        ([], True, "too_few_points"),
        ([at(0, 0, 0.02, 0)], False, "too_few_points"),
        ([at(0, 0, 0.02, n) for n in range(50)], False, "too_few_points"),
        ([at(0, 0, 0.02, n) for n in range(50)], True, "too_few_points"),
        (walk([(0, 0), (50, 0)]), True, "no_area"),
    ],
)
def test_what_encloses_nothing_is_refused_in_a_sentence(points: list[WalkPoint], is_closed: bool, code: str) -> None:
    with pytest.raises(BadWalk) as caught:
        outline(points, is_closed, 0.5)
    assert caught.value.code == code
    assert caught.value.text.endswith(".")


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.integers(0, 10_000), st.floats(0.01, 0.3), st.floats(30, 200), st.floats(30, 200), st.floats(0.3, 2))
@pytest.mark.slow
def test_any_rectangle_walked_is_about_that_rectangle(
    seed: int, noise: float, width: float, height: float, tolerance: float
) -> None:
    points = walk(box(0, 0, width, height), accuracy_m=noise, noise_m=noise / 2, seed=seed)
    walked = outline(points, True, tolerance)
    field = shapely.Polygon(box(0, 0, width, height))
    assert ring(walked).is_valid
    assert ring(walked).symmetric_difference(field).area < (walked.tolerance_m + 1) * field.length / 2
    assert walked.kept + walked.dropped == len(points)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(
        st.builds(
            WalkPoint,
            st.floats(4.2, 4.201) | st.floats(),
            st.floats(51.7, 51.701) | st.floats(),
            st.floats(0.01, 5) | st.floats(),
            st.floats(0, 1000) | st.floats(),
        ),
        max_size=40,
    ),
    st.booleans(),
)
def test_any_positions_give_an_outline_or_a_sentence(points: list[WalkPoint], is_closed: bool) -> None:
    try:
        walked = outline(points, is_closed, 0.5)
    except BadWalk:
        return
    assert len(walked.coordinates) >= (4 if is_closed else 2)
