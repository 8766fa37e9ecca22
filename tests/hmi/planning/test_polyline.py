"""Lines without corners on top of each other."""

from __future__ import annotations

import numpy as np
import pytest

from hmi.planning.polyline import distinct


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
