"""The life of a mission, as a table and as a robot reports it."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmi.domain.mission import (
    ENDED,
    MOVES,
    ON_ROBOT,
    BadMove,
    MissionStatus,
    Mover,
    OpenMission,
    check_move,
    reported_move,
)
from hmi.domain.robot import OrderStatus
from tests.hmi.missions.rig import order

S = MissionStatus
SHA, OTHER_SHA = "a" * 64, "b" * 64
statuses, reports = st.sampled_from(S), st.sampled_from(OrderStatus)


def held(status: MissionStatus) -> OpenMission:
    return OpenMission("m-1", status, "weeder-01", SHA)


def test_every_state_is_in_the_table() -> None:
    assert set(MOVES) == set(S)


def test_every_state_can_be_reached_from_a_draft() -> None:
    reached, waiting = {S.DRAFT}, [S.DRAFT]
    while waiting:
        for after in MOVES[waiting.pop()]:
            if after not in reached:
                reached.add(after)
                waiting.append(after)
    assert reached == set(S)


def test_only_a_robot_can_say_that_it_drives_or_has_finished() -> None:
    for before, after in itertools.product(S, (S.RUNNING, S.DONE, S.ABORTED)):
        assert MOVES[before].get(after, Mover.ROBOT) is Mover.ROBOT


def test_a_move_that_is_not_in_the_table_names_both_states() -> None:
    with pytest.raises(BadMove, match="A mission that is draft cannot become running"):
        check_move(S.DRAFT, S.RUNNING, Mover.ROBOT)


def test_a_move_by_the_wrong_hand_is_refused() -> None:
    with pytest.raises(BadMove, match="Only the robot can make a accepted mission running"):
        check_move(S.ACCEPTED, S.RUNNING, Mover.PERSON)


@pytest.mark.parametrize(
    ("status", "report", "path"),
    [
        (S.SENT, OrderStatus.LOADED, (S.ACCEPTED,)),
        (S.ACCEPTED, OrderStatus.RUNNING, (S.RUNNING,)),
        (S.RUNNING, OrderStatus.PAUSED, (S.PAUSED,)),
        (S.PAUSED, OrderStatus.RUNNING, (S.RUNNING,)),
        (S.RESUMING, OrderStatus.RUNNING, (S.RUNNING,)),
        (S.RUNNING, OrderStatus.DONE, (S.DONE,)),
        (S.RUNNING, OrderStatus.ABORTED, (S.ABORTED,)),
        (S.RUNNING, OrderStatus.FAILED, (S.FAILED,)),
        (S.ACCEPTED, OrderStatus.DONE, (S.RUNNING, S.DONE)),
        (S.DONE, OrderStatus.LOADED, (S.ACCEPTED,)),
    ],
)
def test_a_report_moves_a_mission_on(
    status: MissionStatus, report: OrderStatus, path: tuple[MissionStatus, ...]
) -> None:
    move = reported_move(held(status), order("m-1", SHA, report))
    assert move is not None
    assert move[0] == path


@pytest.mark.parametrize("report", [OrderStatus.PAUSED, OrderStatus.DONE, OrderStatus.ABORTED, OrderStatus.FAILED])
def test_the_end_of_an_earlier_run_says_nothing_about_a_mission_sent_again(report: OrderStatus) -> None:
    assert reported_move(held(S.SENT), order("m-1", SHA, report)) is None


def test_a_report_about_an_older_document_is_ignored() -> None:
    assert reported_move(held(S.ACCEPTED), order("m-1", OTHER_SHA, OrderStatus.RUNNING)) is None


def test_a_mission_that_waits_on_the_robot_is_ready_again_when_another_takes_its_place() -> None:
    move = reported_move(held(S.ACCEPTED), order("m-2", SHA, OrderStatus.LOADED))
    assert move == ((S.VALIDATED,), "The robot has another mission now.")


def test_a_running_mission_that_the_robot_lost_has_failed() -> None:
    assert reported_move(held(S.RUNNING), None) == ((S.FAILED,), "The robot lost the mission.")


def test_a_running_mission_that_the_robot_swapped_is_aborted() -> None:
    move = reported_move(held(S.PAUSED), order("m-2", SHA, OrderStatus.RUNNING))
    assert move == ((S.ABORTED,), "The robot took another mission.")


@given(statuses, reports, st.sampled_from(["m-1", "m-2"]), st.sampled_from([SHA, OTHER_SHA]))
def test_whatever_a_robot_reports_every_step_is_one_the_table_gives_it(
    status: MissionStatus, report: OrderStatus, mission_id: str, sha256: str
) -> None:
    move = reported_move(held(status), order(mission_id, sha256, report))
    before = status
    for after in move[0] if move else ():
        assert MOVES[before][after] is Mover.ROBOT
        before = after


@given(statuses, reports)
def test_the_same_report_again_changes_nothing(status: MissionStatus, report: OrderStatus) -> None:
    said = order("m-1", SHA, report)
    move = reported_move(held(status), said)
    if move is not None:
        assert reported_move(held(move[0][-1]), said) is None


@given(st.sampled_from(sorted(ENDED | (set(S) - ON_ROBOT))))
def test_a_mission_no_robot_holds_is_not_lost(status: MissionStatus) -> None:
    assert reported_move(held(status), None) is None
