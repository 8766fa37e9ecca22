"""A farm that lives by itself: people who start work, and situations that come and go."""

from __future__ import annotations

from collections import Counter

import pytest

from backend_clients.edge import messages_down as down
from backend_clients.simulator.config import Job, RobotConfig
from backend_clients.simulator.director import AT_ONCE, Director
from backend_clients.simulator.faults import LowBattery, Silence
from backend_clients.simulator.foreman import Foreman
from backend_clients.simulator.situations import SITUATIONS
from backend_clients.simulator.world import World
from hmi.clock import FakeClock
from tests.backend_clients.simulator.rig import AT_START, LAT, LON, small_mission

STEP_S = 0.1
FREE = "weeder-01"


class Farm:
    """A few robots at work, a farm that pings them, and fake time."""

    def __init__(self, workers: int = 6, opening: dict[str, str] | None = None) -> None:
        self.clock = FakeClock()
        ids = [FREE, *(f"weeder-{n:02d}" for n in range(2, workers + 2))]
        configs = [RobotConfig(one, one.title(), "secret", **AT_START, is_lean=True) for one in ids]
        self.world = World(configs, self.clock)
        jobs = {one: Job(small_mission(one, rows=40, length_m=80.0), 0.3) for one in ids[1:]}
        self.foreman = Foreman(self.world.robots, jobs, self.clock)
        self.director = Director(self.world.robots, self.clock, players=frozenset(jobs), opening=opening)
        self.is_farm_there = True
        self.seen: Counter[str] = Counter()
        self.most = 0

    def run(self, seconds: float) -> None:
        """Let time pass."""
        for n in range(round(seconds / STEP_S)):
            self.clock.advance(STEP_S)
            if self.is_farm_there and n % 10 == 0:
                for robot_id, robot in self.world.robots.items():
                    silence = robot.faults.silence
                    if silence is None or not silence.deaf:
                        robot.receive(down.Ping(robot=robot_id, nonce="console-p"))
            self.world.step(STEP_S)
            self.foreman.look()
            before = set(self.director.now().items())
            self.director.look()
            self.seen.update(situation for _, situation in set(self.director.now().items()) - before)
            self.most = max(self.most, len(self.director.now()))

    def mode(self, robot_id: str) -> str:
        """Return the mode of a robot."""
        boot = self.world.robots[robot_id].boot
        return boot.brain.mode if boot is not None else "off"


def test_work_begins_where_it_was_and_unattended_only_when_the_farm_is_heard() -> None:
    farm = Farm()
    farm.is_farm_there = False
    farm.run(5.0)
    assert {farm.mode(one) for one in farm.world.robots} == {"idle", "paused"}
    farm.is_farm_there = True
    farm.run(8.0)
    assert farm.mode("weeder-02") == "auto"
    boot = farm.world.robots["weeder-02"].boot
    assert boot is not None
    order = boot.reporter.state().order
    assert order is not None
    assert (order.is_supervised, order.area_done_m2 / order.area_m2) == (False, pytest.approx(0.3, abs=0.05))


def test_nobody_touches_a_robot_that_a_person_paused_stopped_or_that_has_no_job() -> None:
    farm = Farm()
    farm.run(8.0)
    paused, stopped = (farm.world.robots[one] for one in ("weeder-02", "weeder-03"))
    assert paused.boot is not None
    paused.boot.brain.pause("paused")
    stopped.receive(down.Stop(robot="weeder-03", stop_id="stop-000001", by="Martha"))
    farm.run(400.0)
    assert (farm.mode("weeder-02"), farm.mode("weeder-03"), farm.mode(FREE)) == ("paused", "stopped", "idle")
    assert FREE not in farm.director.now()


def test_a_robot_that_lost_the_farm_waits_for_somebody_who_walks_there() -> None:
    farm = Farm(workers=1)
    farm.run(70.0)  # past the start, when people still stand beside the machines
    farm.world.robots["weeder-02"].set_fault(Silence(deaf=True))
    farm.run(12.0)
    assert farm.mode("weeder-02") == "paused"
    farm.world.robots["weeder-02"].clear_fault("silence")
    farm.run(30.0)
    assert farm.mode("weeder-02") == "paused"
    farm.run(100.0)
    assert farm.mode("weeder-02") == "auto"


def test_a_robot_that_was_moved_by_hand_is_left_where_it_is() -> None:
    farm = Farm(workers=1)
    farm.run(70.0)
    robot = farm.world.robots["weeder-02"]
    assert robot.boot is not None
    robot.boot.brain.pause("link_lost")
    farm.run(3.0)
    robot.machine.base.x_m += 1.0
    farm.run(200.0)
    assert farm.mode("weeder-02") == "paused"


def test_a_low_battery_is_brought_home_by_somebody() -> None:
    farm = Farm(workers=1)
    farm.run(8.0)
    farm.world.robots["weeder-02"].set_fault(LowBattery(soc=0.14))
    farm.run(2.0)
    boot = farm.world.robots["weeder-02"].boot
    assert boot is not None
    assert boot.brain.watch.path[0] == "Return home"


def test_the_opening_is_played_once_the_robots_work_and_situations_end_by_themselves() -> None:
    farm = Farm(opening={"weeder-02": "rtk-float", "weeder-03": "weed-unsure"})
    farm.run(16.0)
    opening = farm.director.now()
    assert opening == {"weeder-02": "rtk-float", "weeder-03": "weed-unsure"}
    farm.run(244.0)
    assert not opening.items() & farm.director.now().items()


@pytest.mark.slow
def test_situations_come_and_go_but_never_trouble_everybody() -> None:
    farm = Farm(workers=8)
    farm.run(1200.0)
    assert sum(farm.seen.values()) >= 8
    assert len(farm.seen) >= 3
    assert 1 <= farm.most <= AT_ONCE
    working = sum(farm.mode(one) == "auto" for one in farm.world.robots)
    assert working >= 3


def test_a_provoked_situation_stays_until_it_is_ended() -> None:
    farm = Farm()
    farm.run(8.0)
    farm.director.provoke("weeder-02", "person-ahead")
    farm.run(400.0)
    assert farm.director.now()["weeder-02"] == "person-ahead"
    farm.director.provoke("weeder-02", None)
    assert "weeder-02" not in farm.director.now()
    farm.run(8.0)
    boot = farm.world.robots["weeder-02"].boot
    assert boot is not None
    assert boot.brain.watch.faults == ()


def test_a_situation_of_another_family_is_refused() -> None:
    farm = Farm()
    with pytest.raises(ValueError, match="cannot happen to a weeder"):
        farm.director.provoke("weeder-02", "crane-limit")
    with pytest.raises(KeyError):
        farm.director.provoke("weeder-99", "rtk-float")


@pytest.mark.parametrize("situation", SITUATIONS, ids=lambda one: one.id)
def test_every_situation_can_be_played_and_ended_on_its_families(situation: object) -> None:
    one = situation
    for family in one.families:  # type: ignore[attr-defined]
        clock = FakeClock()
        world = World([RobotConfig("robot-01", "R", "t", LAT, LON, family=family)], clock)
        director = Director(world.robots, clock)
        director.provoke("robot-01", one.id)  # type: ignore[attr-defined]
        assert world.robots["robot-01"].faults.list()
        director.provoke("robot-01", None)
        assert world.robots["robot-01"].faults.list() == []


def test_lean_robots_live_in_long_steps_and_stop_at_once_all_the_same() -> None:
    clock = FakeClock()
    ids = [f"lean-{n:02d}" for n in range(20)]
    world = World([RobotConfig(one, one, "t", **AT_START, is_lean=True) for one in ids], clock)
    jobs = {one: Job(small_mission(one, length_m=60.0), is_endless=True) for one in ids}
    foreman = Foreman(world.robots, jobs, clock)

    def run(seconds: float) -> None:
        for n in range(round(seconds / 0.05)):
            clock.advance(0.05)
            if n % 20 == 0:
                for robot_id, robot in world.robots.items():
                    robot.receive(down.Ping(robot=robot_id, nonce="console-p"))
            world.step(0.05)
            foreman.look()

    run(15.0)
    speeds = [robot.machine.base.speed_mps for robot in world.robots.values()]
    assert min(speeds) > 1.0
    for robot_id, robot in world.robots.items():
        answer = robot.receive(down.Stop(robot=robot_id, stop_id="stop-000001", by="Martha"))
        assert answer is not None
        assert answer.outcome == "accepted"
    run(1.6 / 1.2 + 0.5 + 0.2)
    for robot in world.robots.values():
        assert robot.boot is not None
        safety = robot.boot.reporter.safety()
        assert (safety.latched, safety.standstill) == (True, True)
