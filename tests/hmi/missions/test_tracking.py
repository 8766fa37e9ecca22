"""Following missions by what robots report."""

from __future__ import annotations

from collections.abc import AsyncIterator
from dataclasses import replace

import pytest

from hmi.domain.mission import MissionStatus, Mover
from hmi.domain.robot import Hold, OrderStatus
from hmi.store.mission_tracking import MissionTracking
from hmi.store.missions import Mission, Missions
from tests.hmi.missions.rig import FARM, Rig, order, weeder
from tests.hmi.missions.test_store import put, through

S = MissionStatus


class Follower:
    """Tracking with a robot to report."""

    def __init__(self, rig: Rig) -> None:
        self.rig = rig
        self.moves: list[MissionStatus] = []
        self.tracking = MissionTracking(rig.missions, rig.database, FARM, lambda _m, c: self.moves.append(c.after))

    async def report(self, status: OrderStatus | None, mission_id: str = "m-1", robot_id: str = "weeder-01") -> None:
        known = self.rig.missions.known(mission_id)
        said = None if status is None else order(mission_id, known.sha256 if known else "c" * 64, status)
        self.tracking.see(self.rig.fleet.report(robot_id, said, self.rig.clock.mono_s()))
        await self.tracking.settle()

    @property
    def mission(self) -> Mission:
        known = self.rig.missions.known("m-1")
        assert known is not None
        return known


@pytest.fixture
async def follower(rig: Rig) -> AsyncIterator[Follower]:
    put(rig)
    rig.missions.move(FARM, "m-1", S.SENT, Mover.PERSON, "Martha")
    follower = Follower(rig)
    yield follower
    await follower.tracking.close()


async def test_a_mission_runs_through_its_life_as_the_robot_reports(follower: Follower) -> None:
    for status in (OrderStatus.LOADED, OrderStatus.RUNNING, OrderStatus.PAUSED, OrderStatus.RUNNING, OrderStatus.DONE):
        await follower.report(status)
    assert follower.moves == [S.ACCEPTED, S.RUNNING, S.PAUSED, S.RUNNING, S.DONE]
    assert [entry.by for entry in follower.rig.missions.log(FARM, "m-1")][2:] == ["Weeder 01"] * 5


async def test_the_same_report_again_writes_nothing(follower: Follower) -> None:
    for _ in range(3):
        await follower.report(OrderStatus.LOADED)
    assert follower.moves == [S.ACCEPTED]


async def test_what_passed_while_the_console_was_away_is_caught_up_with(follower: Follower) -> None:
    await follower.report(OrderStatus.DONE, "m-1")
    assert follower.moves == []  # sent just now: this is the end of an earlier run
    await follower.report(OrderStatus.LOADED)
    await follower.report(OrderStatus.DONE)
    assert follower.moves == [S.ACCEPTED, S.RUNNING, S.DONE]


async def test_another_mission_on_the_robot_frees_the_one_that_waited(follower: Follower) -> None:
    await follower.report(OrderStatus.LOADED)
    await follower.report(OrderStatus.LOADED, "m-2")
    assert follower.mission.status is S.VALIDATED


async def test_a_running_mission_the_robot_lost_has_failed(follower: Follower) -> None:
    await follower.report(OrderStatus.RUNNING)
    await follower.report(None)
    assert follower.mission.status is S.FAILED


async def test_a_robot_cannot_move_the_mission_of_another(follower: Follower) -> None:
    await follower.report(OrderStatus.RUNNING, robot_id="weeder-02")
    assert follower.mission.status is S.SENT


async def test_an_unregistered_or_foreign_robot_is_not_followed(follower: Follower) -> None:
    follower.rig.fleet.robots["weeder-01"] = weeder("weeder-01", "Weeder 01", farm_id="other-farm")
    await follower.report(OrderStatus.LOADED)
    assert follower.mission.status is S.SENT


async def test_the_task_writes_moves_by_itself_and_ends(follower: Follower) -> None:
    follower.tracking.start()
    changed = follower.rig.missions.version
    said = order("m-1", follower.mission.sha256, OrderStatus.LOADED)
    follower.tracking.see(follower.rig.fleet.report("weeder-01", said, 1.0))
    await follower.tracking.close()  # a move being written is finished; else the next start does it
    follower.tracking.see(follower.rig.fleet.report("weeder-01", said, 2.0))
    await follower.tracking.settle()
    assert follower.mission.status is S.ACCEPTED
    assert follower.rig.missions.version == changed + 1


async def test_a_mission_resumes_until_the_robot_moves_and_a_later_pause_counts(rig: Rig) -> None:
    put(rig)
    through(rig, "m-1", (S.SENT, Mover.PERSON), (S.ACCEPTED, Mover.ROBOT), (S.RUNNING, Mover.ROBOT))
    following = Follower(rig)
    await following.report(OrderStatus.PAUSED)
    through(rig, "m-1", (S.RESUMING, Mover.PERSON))
    following.tracking.acted("m-1", rig.clock.mono_s())
    await following.report(OrderStatus.PAUSED)
    assert following.mission.status is S.RESUMING, "a report from before the order"
    await horn(following)
    assert following.mission.status is S.RESUMING, "the horn sounds, nothing moves"
    await following.report(OrderStatus.RUNNING)
    assert following.mission.status is S.RUNNING
    through(rig, "m-1", (S.PAUSED, Mover.ROBOT), (S.RESUMING, Mover.PERSON))
    rig.clock.advance(5.0)
    await following.report(OrderStatus.PAUSED)
    assert following.mission.status is S.PAUSED, "it paused again before it was seen running"


async def horn(following: Follower) -> None:
    """Let the robot say that it sounds its horn before it moves on."""
    said = order("m-1", following.mission.sha256, OrderStatus.RUNNING)
    robot = following.rig.fleet.report("weeder-01", said, following.rig.clock.mono_s())
    assert robot.state is not None
    held = replace(robot.state, hold=Hold("start_horn", "The horn sounds.", "", ""))
    following.rig.fleet.robots["weeder-01"] = replace(robot, state=held)
    following.tracking.see(following.rig.fleet.robots["weeder-01"])
    await following.tracking.settle()


async def test_how_far_it_is_survives_a_killed_console(rig: Rig) -> None:
    put(rig)
    through(rig, "m-1", (S.SENT, Mover.PERSON), (S.ACCEPTED, Mover.ROBOT), (S.RUNNING, Mover.ROBOT))
    await Follower(rig).report(OrderStatus.RUNNING)
    again = Missions(rig.database, rig.clock)
    again.load()
    known = again.known("m-1")
    assert known is not None
    assert known.progress is not None
    assert (known.progress["segment"], known.progress["row"], known.progress["area_done_m2"]) == (2, 1, 20.0)
