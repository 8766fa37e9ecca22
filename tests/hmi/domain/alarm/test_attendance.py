"""Alarms per hour of a person who is there."""

from __future__ import annotations

import pytest

from hmi.domain.alarm.attendance import LEAST_S, WINDOW_S, Attendance


def attended(attendance: Attendance, begin_s: int, end_s: int, people: int) -> None:
    for now_s in range(begin_s, end_s + 1, 5):
        attendance.see(now_s, people)


def test_two_people_share_the_alarms_of_an_hour() -> None:
    attendance = Attendance()
    attended(attendance, 0, 3600, 2)
    for _ in range(12):
        attendance.raised(3600)
    assert attendance.per_hour(3600) == pytest.approx(6.0)


def test_an_hour_of_a_person_who_left_since_still_counts() -> None:
    attendance = Attendance()
    attended(attendance, 0, 1800, 2)
    attended(attendance, 1800, 5400, 1)
    attendance.raised(5400)
    assert attendance.per_hour(5400) == pytest.approx(1 / 2.0, rel=0.01)


def test_alarms_of_a_night_without_anybody_are_no_load() -> None:
    attendance = Attendance()
    attended(attendance, 0, 3600, 0)
    attendance.raised(3600)
    assert attendance.per_hour(3600) is None
    attended(attendance, 3600, 7200, 1)
    assert attendance.per_hour(7200) == 0.0


def test_too_little_attendance_and_unseen_time_give_no_figure() -> None:
    attendance = Attendance()
    attendance.see(0, 1)
    attendance.see(10 * LEAST_S, 1)  # the console was suspended
    attendance.raised(10 * LEAST_S)
    assert attendance.per_hour(10 * LEAST_S) is None


def test_what_is_older_than_a_shift_is_forgotten() -> None:
    attendance = Attendance()
    attended(attendance, 0, 3600, 1)
    attendance.raised(3600)
    attended(attendance, int(WINDOW_S), int(WINDOW_S) + 7200, 1)
    assert attendance.per_hour(WINDOW_S + 7200) == 0.0
