"""The order of cells."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from hmi.planning.swaths import Swath
from hmi.planning.tour import by_part, tour

Cells = list[list[Swath]]


def block(left: float, low: float, length: float, rows: int) -> list[Swath]:
    """Return rows 3 m apart, upward from ``low``."""
    return [Swath(k, (left, low + 3 * k), (left + length, low + 3 * k)) for k in range(rows)]


def between_m(order: Cells) -> float:
    """Return the straight metres from the end of each cell to the beginning of the next."""
    return sum(math.dist(a[-1].b, b[0].a) for a, b in pairwise(order))


def inner_of(cells: Cells) -> shapely.Geometry:
    """Return a field around the cells."""
    return shapely.union_all([shapely.LineString([row.a, row.b]) for cell in cells for row in cell]).envelope.buffer(5)


blocks = st.builds(
    block, st.integers(0, 300), st.integers(0, 300), st.sampled_from([20.0, 50.0, 90.0]), st.integers(1, 6)
)


def test_two_neighbouring_blocks_are_joined_where_they_meet() -> None:
    cells = [block(0, 0, 140, 16), block(0, 48, 50, 30)]
    order = tour(cells, inner_of(cells), None)
    assert between_m(order) == pytest.approx(3)


def test_the_tour_begins_near_the_place_it_comes_from() -> None:
    cells = [block(0, 0, 60, 5), block(0, 100, 60, 5)]
    assert tour(cells, inner_of(cells), (61.0, 115.0))[0][0].a == (60, 112)


def test_the_part_with_most_rows_comes_first_where_a_field_cannot_be_passed() -> None:
    small, large = block(0, 0, 20, 2), block(100, 0, 60, 5)
    parts = shapely.MultiPolygon([shapely.box(-5, -5, 25, 10), shapely.box(95, -5, 165, 20)])
    assert by_part([small, large], parts) == [[large], [small]]


def test_no_cells_make_no_tour() -> None:
    assert tour([], shapely.Polygon(), None) == []


@given(st.lists(blocks, min_size=1, max_size=8))
@pytest.mark.slow
def test_every_row_is_driven_once_and_neighbours_in_opposite_directions(cells: Cells) -> None:
    order = tour(cells, inner_of(cells), None)
    driven = sorted(tuple(sorted((row.a, row.b))) for cell in order for row in cell)
    assert driven == sorted(tuple(sorted((row.a, row.b))) for cell in cells for row in cell)
    for cell in order:
        for a, b in pairwise(cell):
            assert (a.b[0] - a.a[0]) * (b.b[0] - b.a[0]) < 0
            assert math.dist(a.b, b.a) == pytest.approx(3)
