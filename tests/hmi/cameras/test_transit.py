"""A picture that waited on its way is as old as it is, whatever age its robot wrote on it."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from hmi.cameras import congestion
from hmi.cameras.congestion import CALM_MS, LASTS_MS, LEAST_FPS, Congestion
from hmi.cameras.inbox import Inbox, Shot
from hmi.cameras.picture_wire import Plan
from hmi.cameras.pull_http import HttpPull, PullFailed
from hmi.cameras.transit import Transit
from hmi.clock import mono_s
from hmi.domain.camera import CameraInfo, Source
from tests.hmi.cameras.fake_camera import TOKEN, FakeCamera, fake_camera

WALL_MS = 1_790_000_000_000.0  # how far the robot's clock is ahead of ours
WAY_MS, PERIOD_MS = 20.0, 66.0


class Robot:
    """Begins parts, which come after ``waits_ms``; ``ppm`` and ``step_ms`` are what its clock does."""

    def __init__(self, ppm: float = 0.0) -> None:
        self.transit, self.at_ms = Transit(), 1_000_000.0
        self.ppm, self.step_ms = ppm, 0.0

    def connect(self) -> None:
        """Ask for pictures anew."""
        self.transit.asked(self.at_ms)

    def part(self, waits_ms: float = 0.0, after_ms: float = PERIOD_MS) -> float:
        """Send one; return how long it is said to have waited."""
        self.at_ms += after_ms
        begun_ms = WALL_MS + self.at_ms * (1 + self.ppm / 1e6) + self.step_ms
        return self.transit.waited_ms(begun_ms, self.at_ms + WAY_MS + waits_ms)


def connected(ppm: float = 0.0) -> Robot:
    """Return a robot of which one picture came."""
    robot = Robot(ppm)
    robot.connect()
    assert robot.part() == 0.0
    return robot


def test_pictures_that_pile_up_in_the_robot_are_told_as_old_as_they_are() -> None:
    robot = connected()
    for waits_ms in range(0, 13_000, 40):
        assert robot.part(waits_ms) == pytest.approx(waits_ms, abs=5.0)
    assert robot.part(0.0) == pytest.approx(0.0, abs=3.0)


def test_a_line_that_is_full_for_an_hour_is_not_learned_as_normal() -> None:
    robot = connected()
    told = [robot.part(12_000.0, after_ms=1000.0) for _ in range(3600)]
    assert min(told) > 11_600.0


def test_a_line_that_was_full_when_it_was_opened_is_known_from_its_first_quick_picture_on() -> None:
    robot = Robot()
    robot.connect()
    robot.part(600.0)
    robot.part(0.0)
    assert robot.part(600.0) == pytest.approx(600.0, abs=1.0)


def asked_over(robot: Robot, there_ms: float, back_ms: float) -> None:
    """Ask for pictures over a line that takes so long in each direction."""
    robot.connect()
    robot.transit.heard(WALL_MS + robot.at_ms + there_ms + robot.step_ms)
    robot.part(back_ms - WAY_MS, after_ms=there_ms)


def test_a_line_that_is_full_from_the_first_picture_on_is_known_from_when_the_robot_heard_the_request() -> None:
    robot = Robot()
    asked_over(robot, 20.0, 3000.0)
    assert robot.transit.way_ms == pytest.approx(3020.0, abs=1.0)
    assert robot.part(3000.0) == pytest.approx(0.0, abs=50.0)
    robot.part(1000.0)
    assert robot.transit.way_ms == pytest.approx(1040.0, abs=50.0), "the line is less full"
    assert robot.part(3000.0) == pytest.approx(2000.0, abs=50.0)


def test_a_request_that_was_lost_once_makes_pictures_old_only_until_it_is_asked_again() -> None:
    robot = Robot()
    asked_over(robot, 1000.0, 20.0)
    assert robot.transit.way_ms == pytest.approx(1020.0, abs=1.0)
    asked_over(robot, 20.0, 20.0)
    assert robot.transit.way_ms == pytest.approx(40.0, abs=1.0)


@pytest.mark.parametrize("step_ms", [-5000.0, 3_600_000.0])
def test_a_robot_clock_that_is_set_makes_the_way_neither_long_nor_short(step_ms: float) -> None:
    robot = Robot()
    asked_over(robot, 20.0, 20.0)
    robot.step_ms = step_ms
    robot.part()
    asked_over(robot, 20.0, 20.0)
    assert robot.transit.way_ms == pytest.approx(40.0, abs=5.0)


@pytest.mark.parametrize("ppm", [-60.0, 60.0])
def test_two_clocks_that_part_by_their_drift_make_no_picture_old(ppm: float) -> None:
    robot = connected(ppm)
    assert max(robot.part(after_ms=1000.0) for _ in range(6 * 3600)) < 2.0


def test_a_new_connection_through_a_full_radio_is_not_taken_for_a_quick_one() -> None:
    robot = connected()
    robot.connect()
    assert robot.part(2500.0, after_ms=10.0) == pytest.approx(2500.0, abs=1.0)


@pytest.mark.parametrize("step_ms", [-300.0, -900.0, -5000.0])
def test_a_robot_clock_set_back_makes_no_picture_old_and_hides_none_that_waits(step_ms: float) -> None:
    robot = connected()
    robot.part(400.0)
    robot.step_ms = step_ms
    assert robot.part(400.0) == pytest.approx(400.0, abs=1.0), "as the one before"
    assert robot.part(900.0) == pytest.approx(900.0, abs=1.0)
    assert robot.part() == pytest.approx(0.0, abs=1.0)


def test_a_robot_clock_set_forward_hides_what_waits_and_says_so_until_the_source_is_opened_anew() -> None:
    robot = connected()
    robot.part(4000.0)
    assert not robot.transit.is_hidden
    robot.step_ms = 3_600_000.0
    robot.part(4000.0)
    assert robot.transit.is_hidden
    robot.connect()
    robot.part()
    assert not robot.transit.is_hidden
    assert robot.part(4000.0) == pytest.approx(4000.0, abs=1.0)


def test_fewer_pictures_are_asked_for_while_they_wait_and_more_again_after_a_while() -> None:
    line = Congestion()
    line.note(3000.0, 0.0)
    line.note(3000.0, LASTS_MS - 1)
    assert (line.fps(15.0), line.renewals) == (15.0, 0), "a burst that a gap in the radio held back"
    line.note(3000.0, LASTS_MS)
    assert (line.fps(15.0), line.renewals) == (7.5, 1)
    line.note(0.0, LASTS_MS + CALM_MS)
    assert (line.fps(15.0), line.renewals) == (15.0, 1)
    line.note(3000.0, 2 * CALM_MS)
    line.note(3000.0, 2 * CALM_MS + LASTS_MS)
    line.note(0.0, 3 * CALM_MS + LASTS_MS)
    assert line.fps(15.0) == 7.5, "a line that does not carry more is tried less often"


def test_never_fewer_are_asked_for_than_a_camera_shows_that_is_not_slow() -> None:
    line = Congestion()
    for second in range(60):
        line.note(9000.0, 1000.0 * second)
    assert (line.fps(15.0), line.fps(4.0), line.fps(1.0)) == (3.75, LEAST_FPS, 1.0)
    assert line.renewals > 3, "what waits is thrown away now and then"


@contextmanager
def pulled(robot: FakeCamera) -> Iterator[Inbox]:
    """Pull a robot's stream in a thread; it ends when the robot refuses."""
    box = Inbox()
    source = Source("weeder-01", CameraInfo("front", "Front", 640, 480), url=robot.url, token=TOKEN)
    pull = HttpPull(source, lambda: Plan(fps=15.0), box)

    def run() -> None:
        with pytest.raises(PullFailed):
            pull.run()

    thread = threading.Thread(target=run)
    thread.start()
    try:
        yield box
    finally:
        robot.refusal = (401, b"")
        thread.join()


def age_ms(shot: object) -> float:
    """Return how old a picture is said to be."""
    assert isinstance(shot, Shot)
    assert shot.is_dated
    return mono_s() * 1000 - shot.captured_ms


def test_a_picture_that_waited_in_the_robots_send_buffer_is_not_fresh() -> None:
    with fake_camera(FakeCamera()) as robot, pulled(robot) as box:
        box.take(10.0)
        robot.waits_longer = 0.9
        assert any(age_ms(box.take(10.0)) >= 500.0 for _ in range(60))


def test_a_picture_over_a_line_that_was_full_from_the_first_on_is_as_old_as_it_is() -> None:
    with fake_camera(FakeCamera()) as robot:
        robot.line_s = 1.5
        with pulled(robot) as box:
            assert age_ms(box.take(10.0)) >= 1500.0
            assert age_ms(box.take(10.0)) >= 1500.0


def test_a_picture_of_a_robot_that_does_not_say_when_it_heard_is_dated_as_well() -> None:
    with fake_camera(FakeCamera()) as robot:
        robot.says_asked = False
        with pulled(robot) as box:
            assert age_ms(box.take(10.0)) < 500.0


def test_a_robot_on_a_full_line_is_asked_for_fewer_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(congestion, "LASTS_MS", 100.0)
    with fake_camera(FakeCamera()) as robot, pulled(robot) as box:
        assert box.take(10.0) is not None
        robot.waits_longer = 0.9
        while len(robot.asked) < 2:
            assert box.take(10.0) is not None
        assert [one["fps"] for one in robot.asked[:2]] == ["15", "7.5"]
