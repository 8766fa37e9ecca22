"""Whether somebody has to look on is said by the stored mission and the registry, never by how the robot ran before."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hmi.commands.refusal import OrderRefused
from hmi.commands.start_rules import TAKEN_UP, MissionStartRules
from hmi.domain.mission import MissionStatus, Mover
from hmi.domain.robot import Hold, Mode, Order, OrderStatus, Robot
from hmi.domain.role import Role
from hmi.store.checklists import Checklists
from tests.hmi.missions.rig import FARM, OTHER_FARM, Rig, order
from tests.hmi.missions.test_store import put, through

S = MissionStatus


def rules(rig: Rig, *, may_run_alone: bool = True) -> MissionStartRules:
    """Return the rules of a farm that wants the list ticked."""
    lists = Checklists(rig.database, rig.clock)
    return MissionStartRules(rig.missions, lists, lambda: True, lambda _robot_id: may_run_alone)


def holding(rig: Rig, *, is_supervised: bool, status: OrderStatus = OrderStatus.LOADED) -> tuple[Robot, Order]:
    """Let the robot say what it has, and how it ran before."""
    known = rig.missions.known("m-1")
    said = replace(order("m-1", known.sha256 if known else "a" * 64, status), is_supervised=is_supervised)
    return rig.fleet.report("weeder-01", said, 1.0), said


def mark(rig: Rig, *, is_supervised: bool) -> None:
    """Mark the mission as a planner does."""
    rig.missions.adjust(FARM, "m-1", "Pieter", is_supervised=is_supervised)


def test_a_mission_marked_unattended_is_started_unattended_on_a_robot_that_may(rig: Rig) -> None:
    put(rig)
    mark(rig, is_supervised=False)
    robot, said = holding(rig, is_supervised=True)
    assert not rules(rig).is_supervised(robot, said)
    assert rules(rig, may_run_alone=False).is_supervised(robot, said)
    rules(rig).check(rig.person(Role.OPERATOR), robot, said, None)
    with pytest.raises(OrderRefused, match="Tick the list"):
        rules(rig, may_run_alone=False).check(rig.person(Role.OPERATOR), robot, said, None)


def test_a_mission_marked_supervised_after_an_unattended_life_is_taken_up_again_supervised(rig: Rig) -> None:
    put(rig)
    mark(rig, is_supervised=False)
    through(rig, "m-1", (S.SENT, Mover.PERSON), (S.RUNNING, Mover.ROBOT), (S.ABORTED, Mover.ROBOT))
    mark(rig, is_supervised=True)
    robot, said = holding(rig, is_supervised=False, status=OrderStatus.PAUSED)
    assert robot.state is not None
    robot = replace(robot, state=replace(robot.state, mode=Mode.PAUSED, hold=Hold(TAKEN_UP, "", "", "")))
    assert rules(rig).is_supervised(robot, said)
    with pytest.raises(OrderRefused, match="Tick the list"):
        rules(rig).check(rig.person(Role.OPERATOR), robot, said, None)


@pytest.mark.parametrize("farm", [FARM, OTHER_FARM])
def test_a_mission_that_is_not_stored_here_is_supervised_whatever_the_robot_says(rig: Rig, farm: str) -> None:
    if farm == OTHER_FARM:
        put(rig)
        mark(rig, is_supervised=False)
    robot, said = holding(rig, is_supervised=False)
    assert rules(rig).is_supervised(replace(robot, farm_id=farm), said)
