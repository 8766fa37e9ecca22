"""Stays in states, from the events of simulated robots, are what the robots said was active at each moment."""

from __future__ import annotations

import itertools
import random
from datetime import UTC, datetime, timedelta
from typing import Any

import pytest

from backend_clients.simulator import faults
from hmi.domain.event import RobotEvent
from hmi.domain.state_chart import Chart
from hmi.domain.state_times import Interval, intervals, mark_of
from hmi.ingest import translate_machine
from tests.backend_clients.simulator.rig import Rig, small_mission

T0 = datetime(2026, 5, 20, 12, 0, tzinfo=UTC)
STEP_S = 0.25


def at(mono_ms: float) -> datetime:
    """Return the time of a moment of the robot's clock."""
    return T0 + timedelta(milliseconds=mono_ms)


def drive(family: str, seconds: float) -> tuple[Chart, list[RobotEvent], list[tuple[datetime, dict[str, datetime]]]]:
    """Let a robot work, with a person in its way for a while; return chart, events, and what was active when."""
    rig = Rig(family=family)
    declared = rig.boot.reporter.factsheet().chart
    assert declared is not None
    rig.start(small_mission(length_m=12.0, width_m=4.0))
    said = []
    for step in range(round(seconds / STEP_S)):
        if step == 80:
            rig.robot.set_fault(faults.PersonAhead(distance_m=2.0))
        if step == 140:
            rig.robot.clear_fault()
        if step == 160:
            rig.do("resume")
        rig.run(STEP_S)
        state: Any = rig.state
        said.append((at(state.mono_ms), {one.id: at(one.since_ms) for one in state.active}))
    events = [
        RobotEvent("r", e.event_id, e.kind, e.name, e.text, e.data, at_utc=at(e.mono_ms))
        for e in rig.events
        if e.kind in ("state_entered", "state_left")
    ]
    return translate_machine.chart(declared), events, said


def lasting(stays: list[Interval], moment: datetime) -> set[str]:
    """Return the states whose stay holds a moment."""
    return {one.state for one in stays if one.start <= moment and (one.end is None or moment < one.end)}


@pytest.mark.parametrize("family", ["weeder", "planter", "uav"])
def test_stays_are_what_the_robot_said_was_active_at_each_moment(family: str) -> None:
    chart, events, said = drive(family, 100)
    moment, active = said[-1]
    marks = [mark for event in events if (mark := mark_of(event)) is not None]
    stays = intervals(marks, chart, active, moment)
    assert {one.state for one in stays if one.end is None} == set(active)
    assert not any(one.is_guessed for one in stays)
    differing = [(when - T0).total_seconds() for when, ids in said if lasting(stays, when) != set(ids) - {"start-up"}]
    assert differing == []


@pytest.mark.parametrize("family", ["weeder", "planter", "uav"])
def test_with_a_fifth_of_the_events_lost_most_of_the_time_is_still_right_and_nothing_overlaps(family: str) -> None:
    chart, events, said = drive(family, 100)
    choose = random.Random(5)
    marks = [mark for event in events if choose.random() > 0.2 and (mark := mark_of(event)) is not None]
    moment, active = said[-1]
    stays = intervals(marks, chart, active, moment)
    parents = {one.id: one.parent for one in chart.states}
    regions = {one.id for one in chart.states if one.kind == "region"}
    for parent in set(parents.values()):
        same = [one for one in stays if parents[one.state] == parent and one.state not in regions]
        for before, after in itertools.pairwise(same):
            assert before.end is not None
            assert before.end <= after.start + timedelta(milliseconds=1)
    leaves = {one.id for one in chart.states} - set(parents.values())
    right = sum(len(lasting(stays, when) & leaves & set(ids)) for when, ids in said)
    meant = sum(len(leaves & set(ids) - {"start-up"}) for when, ids in said)
    assert right >= 0.7 * meant
