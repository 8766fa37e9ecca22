"""A map that loses half is told in numbers, whichever half it is."""

from __future__ import annotations

import pytest

from hmi.mapping.feature import MapFeature
from hmi.mapping.shrinking import shrinking
from tests.hmi.mapping.farms import area, box, line, point

NORTH, SOUTH = area("north", box(0, 200, 100, 300)), area("south", box(0, 0, 100, 100))
ROADS = [line(f"road-{n}", [(0, 400 + n), (100, 400 + n)]) for n in range(4)]


def field(side_m: float, *holes: list[tuple[float, float]]) -> MapFeature:
    """Return the northern field with another size."""
    return area("north", box(0, 200, side_m, 200 + side_m), *holes)


@pytest.mark.parametrize(
    ("before", "after", "told"),
    [
        ([NORTH, *ROADS], [], "0 features, the published one 5"),
        ([NORTH, *ROADS], [NORTH, ROADS[0]], "2 features, the published one 5"),
        ([NORTH, *ROADS[:3]], [NORTH, ROADS[0]], "2 features, the published one 4"),  # just half of it
        ([NORTH, SOUTH, *ROADS], [NORTH, *ROADS], "1 field, the published one 2"),
        ([NORTH, *ROADS], ROADS, "0 fields, the published one 1"),
        ([NORTH, *ROADS], [field(1.0), *ROADS], "have 1.0 m², those of the published one 1.00 ha"),
        ([NORTH], [field(100, box(5, 205, 95, 295)[::-1])], "have 0.19 ha, those of the published one 1.00 ha"),
        ([NORTH, SOUTH], [field(70.0), area("south", box(0, 0, 70, 70))], "have 0.98 ha"),
    ],
)  # fmt: skip
def test_a_map_that_keeps_half_or_less_is_told_with_numbers(
    before: list[MapFeature], after: list[MapFeature], told: str
) -> None:
    assert told in shrinking(before, after)


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ([], []),
        ([], [NORTH]),
        ([NORTH], [NORTH]),
        ([NORTH], [field(80.0)]),
        ([NORTH, SOUTH], [NORTH, SOUTH, *ROADS]),
        (ROADS, ROADS[:3]),
        ([NORTH, *ROADS], [NORTH, *ROADS[:2], point("home-1", (0, 0))]),
    ],
)
def test_a_map_that_keeps_most_is_not_asked_about(before: list[MapFeature], after: list[MapFeature]) -> None:
    assert shrinking(before, after) == ""
