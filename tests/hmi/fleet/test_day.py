"""Today's figures: only growth that was seen counts, and a new day begins at zero."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, date, datetime
from pathlib import Path
from typing import Any

import pytest

from hmi.domain.event import RobotEvent
from hmi.domain.fleet_day import FleetDay
from hmi.domain.robot import Family, Mode, OrderStatus, Robot
from hmi.store.fleet_day import read_day, write_day
from tests.hmi.presenters import robots as r

TODAY, TOMORROW = date(2026, 5, 20), date(2026, 5, 21)


def working(area_m2: float, *, mission: str = "m-1", row: int = 1, family: Family = Family.WEEDER) -> Robot:
    """Return a robot at work."""
    order = r.ordered(OrderStatus.RUNNING, area_done_m2=area_m2, mission_id=mission, row=row)
    return replace(r.with_state(r.RUNNING, order=order), factsheet=replace(r.SHEET, family=family))


def test_area_is_what_was_treated_while_somebody_watched() -> None:
    day = FleetDay()
    for at_s, area in ((0.0, 500.0), (2.0, 503.0), (4.0, 506.0)):
        day.see(working(area), at_s, TODAY)
    assert day.figures().area_m2 == pytest.approx(6.0)


def test_another_mission_or_a_fresh_start_takes_nothing_away_and_adds_nothing() -> None:
    day = FleetDay()
    day.see(working(500.0), 0.0, TODAY)
    day.see(working(0.0), 2.0, TODAY)
    day.see(working(90_000.0, mission="m-2"), 4.0, TODAY)
    day.see(working(90_003.0, mission="m-2"), 6.0, TODAY)
    assert day.figures().area_m2 == pytest.approx(3.0)


def attempt(outcome: str = "done", **data: Any) -> RobotEvent:
    """Return what a planter tells of one tree."""
    told = {"target": "tree-4", "outcome": outcome, **data}
    return RobotEvent("planter-01", "e-1", "treatment", "Tree 4", "", told, at_utc=datetime(2026, 5, 20, tzinfo=UTC))


def test_trees_are_those_that_were_planted_not_the_rows() -> None:
    day = FleetDay()
    for row in range(5):
        day.see(working(0.0, row=10 + row, family=Family.PLANTER), row * 2.0, TODAY)
    assert day.figures().plants == 0
    for outcome in ("done", "failed_ground", "done", "failed_tool"):
        day.see_event(attempt(outcome), TODAY)
    day.see_event(replace(attempt(), data={"row": 3, "trees": 2, "length_m": 20.0}), TODAY)  # told tree by tree before
    assert day.figures().plants == 2
    day.see_event(attempt(), TOMORROW)
    assert day.figures().plants == 1


def test_what_was_done_without_link_counts_when_the_robot_is_heard_again() -> None:
    day = FleetDay()
    day.see(working(500.0), 0.0, TODAY)
    day.see(r.SILENT, 2.0, TODAY)
    day.see(working(4_500.0), 602.0, TODAY)
    assert (day.figures().area_m2, day.figures().heard_s) == (pytest.approx(4_000.0), 0)
    day.see(r.SILENT, 604.0, TODAY)
    day.see(working(90_000.0), 614.0, TODAY)  # more than any machine does in that time
    day.see(r.SILENT, 616.0, TODAY)
    day.see(working(9_000.0, mission="m-2"), 1216.0, TODAY)
    assert day.figures().area_m2 == pytest.approx(4_000.0)
    day.see(r.SILENT, 1218.0, TODAY)
    day.see(working(9_900.0, mission="m-2"), 1800.0, TOMORROW)  # nobody knows on which day it was done
    assert day.figures().area_m2 == 0


def test_utilisation_is_the_share_of_heard_time_in_which_a_mission_ran() -> None:
    day = FleetDay()
    for step in range(4):
        day.see(working(0.0), step * 2.0, TODAY)
        day.see(replace(r.IDLE, id="weeder-02"), step * 2.0, TODAY)
    assert day.figures().utilisation == pytest.approx(0.5)


def test_time_that_nobody_saw_counts_neither_as_heard_nor_as_worked() -> None:
    day = FleetDay()
    day.see(working(0.0), 0.0, TODAY)
    day.see(r.SILENT, 2.0, TODAY)
    day.see(working(100.0), 3600.0, TODAY)
    assert day.figures().heard_s == 0
    assert day.figures().utilisation is None


def test_interventions_are_told_per_hour_of_work_once_there_is_a_quarter_of_one() -> None:
    day = FleetDay()
    day.intervened(TODAY)
    day.intervened(TODAY)
    assert day.figures().interventions_per_hour is None
    for step in range(361):
        day.see(working(0.0), step * 5.0, TODAY)
    assert day.figures().interventions_per_hour == pytest.approx(4.0)


def test_a_new_day_begins_at_zero() -> None:
    day = FleetDay()
    day.see(working(500.0), 0.0, TODAY)
    day.see(working(503.0), 2.0, TODAY)
    day.intervened(TODAY)
    day.see(working(505.0), 4.0, TOMORROW)
    figures = day.figures()
    assert (figures.area_m2, figures.interventions) == (pytest.approx(2.0), 0)


def test_a_robot_driven_by_hand_is_not_working() -> None:
    day = FleetDay()
    for step in range(3):
        day.see(r.with_state(working(0.0), mode=Mode.MANUAL), step * 2.0, TODAY)
    assert day.figures().working_s == 0


def test_the_sums_of_the_day_go_on_after_a_restart_and_not_on_another_day(tmp_path: Path) -> None:
    day = FleetDay()
    for at_s, area in ((0.0, 500.0), (2.0, 503.0)):
        day.see(working(area), at_s, TODAY)
    day.intervened(TODAY)
    write_day(tmp_path / "run" / "day.json", day.kept())
    again, tomorrow = FleetDay(), FleetDay()
    again.restore(read_day(tmp_path / "run" / "day.json"), TODAY)
    tomorrow.restore(read_day(tmp_path / "run" / "day.json"), TOMORROW)
    again.see(working(503.0), 100.0, TODAY)
    again.see(working(506.0), 102.0, TODAY)
    assert (again.figures().area_m2, again.figures().interventions) == (pytest.approx(6.0), 1)
    assert tomorrow.figures() == FleetDay().figures()


@pytest.mark.parametrize("text", ["", "[1]", '{"day": "2026-05-20", "area_m2": "x"}', '{"day": "2026-05-20"}'])
def test_a_spoilt_file_of_the_day_counts_as_none(tmp_path: Path, text: str) -> None:
    (tmp_path / "day.json").write_text(text)
    day = FleetDay()
    day.restore(read_day(tmp_path / "day.json"), TODAY)
    assert day.figures() == FleetDay().figures()
