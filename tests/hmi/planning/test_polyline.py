"""Lines without corners on top of each other."""

from __future__ import annotations

import numpy as np
import pytest

from hmi.planning.polyline import distinct, in_millimetres
from hmi.planning.spans import between


def test_a_corner_too_near_to_the_next_is_dropped_and_the_ends_are_kept() -> None:
    way = np.array([[13.908, 5.413], [15.726, 4.8494], [15.7268, 4.8485], [17.0, 4.3], [18.0, 4.0], [18.0004, 3.9993]])
    kept = distinct(way)
    assert kept.tolist() == way[[0, 2, 3, 5]].tolist()


@pytest.mark.parametrize("radius_m", [0.05, 0.1, 1.5])
def test_arcs_stay_as_fine_as_they_are_sampled(radius_m: float) -> None:
    angles = np.radians(np.arange(0, 181, 8))
    arc = radius_m * np.column_stack([np.cos(angles), np.sin(angles)])
    assert distinct(arc).tolist() == arc.tolist()


def test_a_step_aside_is_not_a_crumb() -> None:
    step = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.015], [2.0, 0.015]])
    assert distinct(step).tolist() == step.tolist()


def test_an_arc_cut_beside_one_of_its_corners_keeps_its_directions_in_millimetres() -> None:
    angles = np.radians(np.arange(0, 181, 8))
    arc = 4.0 * np.column_stack([np.cos(angles), np.sin(angles)])
    along = np.cumsum(np.hypot(*np.diff(arc, axis=0).T))
    for corner in along[3:12]:
        for beside_m in (-0.0024, -0.0013, 0.0013, 0.0024):
            for part in (between(arc, 0.0, corner + beside_m), between(arc, corner + beside_m, along[-1])):
                told = in_millimetres(part)
                steps = np.diff(told, axis=0)
                turns = np.angle(np.exp(1j * np.diff(np.arctan2(steps[:, 1], steps[:, 0]))))
                assert np.abs(turns).max() < np.radians(15)
                assert np.abs(told[[0, -1]] - part[[0, -1]]).max() <= 0.0006
