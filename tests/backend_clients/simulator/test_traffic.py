"""Machines that share the ground wait for one another, and drive home along roads."""

from __future__ import annotations

import itertools
import math

import pytest

from backend_clients.edge import messages_down as down
from backend_clients.simulator.cameras.map_feature import MapFeature
from backend_clients.simulator.config import RobotConfig
from backend_clients.simulator.enu import EnuFrame, Point
from backend_clients.simulator.farm_ways import FarmWays
from backend_clients.simulator.traffic import WALK_S, Traffic
from backend_clients.simulator.world import SimRobot, World
from hmi.clock import FakeClock

LAT, LON = 52.0, 5.0
STEP_S = 0.1
EAST = 0.0


class Field:
    """Some machines on one field, a farm that pings them, and fake time; ``nearest_m`` is how near two ever came."""

    def __init__(self, *robots: RobotConfig) -> None:
        self.clock = FakeClock()
        self.world = World(robots, self.clock)
        self.traffic = Traffic(self.world.robots.values(), self.clock)
        self.nearest_m = math.inf

    def __getitem__(self, robot_id: str) -> SimRobot:
        return self.world.robots[robot_id]

    def send(self, robot_id: str, goal: Point) -> None:
        """Let a machine drive to a place by itself."""
        boot = self[robot_id].boot
        assert boot is not None
        boot.brain.go_to(goal)
        boot.brain.errand_is_supervised = False  # no page of an operator is open here

    def stand(self, robot_id: str, x_m: float, y_m: float = 0.0) -> None:
        """Put a machine somewhere, away from its bay."""
        self[robot_id].machine.base.put(x_m, y_m, EAST)

    def run(self, seconds: float) -> None:
        """Let time pass."""
        for n in range(round(seconds / STEP_S)):
            self.clock.advance(STEP_S)
            if n % 10 == 0:
                for robot_id, robot in self.world.robots.items():
                    robot.receive(down.Ping(robot=robot_id, nonce="console-p"))
            self.world.step(STEP_S)
            self.traffic.look()
            places = [self.place(one) for one in self.world.robots]
            self.nearest_m = min(self.nearest_m, *(math.dist(a, b) for a in places for b in places if a is not b))

    def place(self, robot_id: str) -> Point:
        """Return where a machine is."""
        base = self[robot_id].machine.base
        return base.x_m, base.y_m

    def hold(self, robot_id: str) -> tuple[str, str, str]:
        """Return why it does not move: code, text, who can."""
        boot = self[robot_id].boot
        assert boot is not None
        found = boot.reporter.state().hold
        return (found.code, found.text, found.who) if found is not None else ("", "", "")


def weeder(robot_id: str, x_m: float, y_m: float = 0.0, theta_rad: float = EAST) -> RobotConfig:
    """Return a weeder that stands somewhere."""
    return RobotConfig(robot_id, robot_id.title(), "secret", LAT, LON, x_m, y_m, theta_rad)


def test_a_machine_waits_behind_one_that_stands_and_says_for_whom() -> None:
    field = Field(weeder("weeder-01", 0.0), weeder("weeder-02", 15.0, 5.0))
    field.stand("weeder-02", 15.0)
    field.send("weeder-01", (40.0, 0.0))
    field.run(30.0)
    assert field.hold("weeder-01") == ("robot_ahead", "Weeder-02 stands in its way.", "")
    assert field.nearest_m > 7.0
    boot = field["weeder-01"].boot
    assert boot is not None
    assert boot.reporter.telemetry().obstacle_m == pytest.approx(5.3, abs=0.7)
    assert boot.reporter.state().faults == []


def test_who_stands_in_its_own_bay_is_off_the_way() -> None:
    field = Field(weeder("weeder-01", 0.0), weeder("weeder-02", 15.0))
    field.send("weeder-01", (40.0, 0.0))
    field.run(60.0)
    assert math.dist(field.place("weeder-01"), (40.0, 0.0)) < 1.0


def test_it_goes_on_after_the_horn_when_the_other_has_left() -> None:
    field = Field(weeder("weeder-01", 0.0), weeder("weeder-02", 15.0, 5.0))
    field.stand("weeder-02", 15.0)
    field.send("weeder-01", (40.0, 0.0))
    field.run(15.0)
    field.send("weeder-02", (15.0, 30.0))
    field.run(25.0)
    assert field.hold("weeder-01")[0] in ("", "start_horn")
    field.run(40.0)
    assert math.dist(field.place("weeder-01"), (40.0, 0.0)) < 1.0
    assert field.nearest_m > 4.0


def test_two_that_meet_wait_until_somebody_leads_one_past() -> None:
    field = Field(weeder("weeder-01", 0.0), weeder("weeder-02", 30.0, theta_rad=math.pi))
    field.send("weeder-01", (30.0, 0.0))
    field.send("weeder-02", (0.0, 0.0))
    field.run(WALK_S[0])
    assert {field.hold(one)[0] for one in field.world.robots} == {"robot_ahead"}
    field.run(WALK_S[1])
    events = [event for robot in field.world.robots.values() for event in robot.take_events()]
    assert "Led past" in [event.name for event in events]
    assert math.dist(field.place("weeder-01"), (30.0, 0.0)) < 1.0
    assert math.dist(field.place("weeder-02"), (0.0, 0.0)) < 1.0
    assert field.nearest_m > 2.0, "they went past each other, not through"


def test_neighbours_at_its_side_what_flies_and_lean_robots_hold_nobody_up() -> None:
    kestrel = RobotConfig("uav-01", "Kestrel", "secret", LAT, LON, 12.0, family="uav")
    lean = RobotConfig("lean-1", "Lean", "secret", LAT, LON, 18.0, is_lean=True)
    field = Field(weeder("weeder-01", 0.0), weeder("weeder-02", 20.0, 3.2), kestrel, lean)
    field.send("weeder-01", (40.0, 0.0))
    field.run(60.0)
    assert math.dist(field.place("weeder-01"), (40.0, 0.0)) < 1.0


def test_machines_of_different_datums_see_each_other_where_they_are() -> None:
    frame = EnuFrame(LAT, LON)
    lat, lon = frame.to_wgs84(15.0, 0.0)
    other = RobotConfig("weeder-02", "Weeder 02", "secret", lat, lon, 0.0, 5.0)
    field = Field(weeder("weeder-01", 0.0), other)
    field.stand("weeder-02", 0.0)
    field.send("weeder-01", (40.0, 0.0))
    field.run(20.0)
    assert field.hold("weeder-01")[0] == "robot_ahead"


# ---- the way home ------------------------------------------------------------------------------------------


def feature(kind: str, shape: str, points: list[Point], **properties: object) -> MapFeature:
    """Return a map feature at places in metres."""
    frame = EnuFrame(LAT, LON)
    places = [list(reversed(frame.to_wgs84(*point))) for point in points]
    coordinates = {"Point": places[0], "LineString": places, "Polygon": [places]}[shape]
    return MapFeature(kind, kind.title(), properties, {"type": shape, "coordinates": coordinates})


ROAD = feature("road", "LineString", [(0, -60), (0, 60), (120, 60)], width_m=5)
MEADOW = feature("no-go", "Polygon", [(30, -20), (70, -20), (70, 20), (30, 20), (30, -20)])


def length_m(way: list[Point]) -> float:
    """Return how long a way is."""
    return sum(math.dist(a, b) for a, b in itertools.pairwise(way))


def test_the_way_home_goes_round_a_no_entry_area() -> None:
    ways = FarmWays([ROAD, MEADOW])
    way = ways.way(EnuFrame(LAT, LON), (100.0, 0.0), (0.0, 0.0))
    assert (way[0], way[-1]) == ((100.0, 0.0), (0.0, 0.0))
    inside = [
        (x, y)
        for a, b in itertools.pairwise(way)
        for k in range(101)
        for x, y in [(a[0] + (b[0] - a[0]) * k / 100, a[1] + (b[1] - a[1]) * k / 100)]
        if 29 < x < 71 and -21 < y < 21
    ]
    assert not inside
    assert length_m(way) < 300


def test_along_a_road_is_better_than_over_the_crop_but_not_at_any_length() -> None:
    ways, frame = FarmWays([ROAD]), EnuFrame(LAT, LON)
    along = ways.way(frame, (110.0, 60.0), (0.0, -50.0))
    assert length_m(along) == pytest.approx(220, abs=8)
    across = ways.way(frame, (6.0, 0.0), (2.0, -6.0))
    assert length_m(across) < 12


def test_without_a_map_the_way_is_straight() -> None:
    frame = EnuFrame(LAT, LON)
    assert FarmWays([]).way(frame, (5.0, 5.0), (0.0, 0.0)) == [(5.0, 5.0), (0.0, 0.0)]
    far = FarmWays([ROAD]).way(EnuFrame(40.0, -3.0), (5.0, 5.0), (0.0, 0.0))
    assert far == [(5.0, 5.0), (0.0, 0.0)]


def test_a_robot_sent_home_takes_that_way_with_its_tool_off() -> None:
    clock = FakeClock()
    config = RobotConfig("weeder-01", "Weeder 01", "secret", LAT, LON)
    robot = SimRobot(config, clock, ways=FarmWays([ROAD, MEADOW]))
    robot.machine.base.put(100.0, 0.0, EAST)
    assert robot.boot is not None
    robot.boot.brain.go_home()
    assert robot.boot.brain.home_run is not None
    assert robot.boot.brain.home_run.route.length_m > 120
