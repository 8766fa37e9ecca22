"""So many pictures a second, out of a stream that sends more."""

from __future__ import annotations

import pytest

from hmi.cameras.pace import Pace


@pytest.mark.parametrize(
    ("source_fps", "wanted_fps", "expected"), [(15, 2, 20), (15, 10, 100), (30, 15, 150), (4, 15, 40), (15, 15, 150)]
)
def test_ten_seconds_give_ten_times_as_many_as_wanted(source_fps: int, wanted_fps: float, expected: int) -> None:
    pace = Pace(wanted_fps)
    sent = sum(pace.is_due(1000 + number / source_fps) for number in range(10 * source_fps))
    assert abs(sent - expected) <= 1


def test_jitter_loses_no_picture_of_a_stream_that_is_as_fast_as_wanted() -> None:
    pace = Pace(15)
    assert all(pace.is_due(1000 + number / 15 + (0.015 if number % 2 else -0.002)) for number in range(100))


def test_after_a_break_there_is_no_burst() -> None:
    pace = Pace(2)
    assert pace.is_due(0.0)
    assert [pace.is_due(60.0 + number / 10) for number in range(10)].count(True) <= 4
