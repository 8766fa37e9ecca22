"""One sentence per robot: in the words of its machine, with what clears it, who can, how long; and when help is due."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hmi.domain.robot import Battery, Family, Hold, Mode, OrderStatus, Robot
from hmi.presenters.fleet import slow, task
from hmi.presenters.help_needed import help_s, waits_for_person
from hmi.presenters.sentence import TAKES_S, sentence
from tests.hmi.presenters import robots as r


def of(robot: Robot, family: Family) -> Robot:
    """Return the robot as another kind of machine."""
    return replace(robot, factsheet=replace(r.SHEET, family=family))


def with_battery(robot: Robot, soc: float, remaining_s: float | None, *, is_charging: bool = False) -> Robot:
    """Return the robot with another battery."""
    return r.with_fast(robot, battery=Battery(soc, remaining_s, is_charging))


@pytest.mark.parametrize(
    ("family", "words"),
    [
        (Family.WEEDER, "Martha Keller pressed STOP. Laser off, tracks brake."),
        (Family.PLANTER, "Martha Keller pressed STOP. Drive and crane stand, hydraulics hold."),
        (Family.UAV, "Martha Keller pressed STOP. It brakes and hovers."),
    ],
)
def test_a_stop_says_what_it_does_to_this_kind_of_machine(family: Family, words: str) -> None:
    found = sentence(of(r.LATCHED, family))
    assert found is not None
    assert (found["text"], found["who"], found["takes_s"]) == (words, "operator", TAKES_S["stop_latched"])


@pytest.mark.parametrize(
    "robot",
    [
        r.BRAKING,
        r.with_safety(r.LATCHED, tool_off=False),
        r.with_safety(r.LATCHED, standstill=False),
        replace(r.LATCHED, link=replace(r.LINK, heard_s=1002.0)),  # the newest word of its safety controller is old
    ],
)
@pytest.mark.parametrize("family", list(Family))
def test_a_stop_claims_no_standstill_that_the_robot_does_not_report_now(robot: Robot, family: Family) -> None:
    found = sentence(of(robot, family))
    assert found is not None
    assert found["text"] == "Martha Keller pressed STOP. It does not say yet that it stands with its tool off."
    assert (found["clears"], found["takes_s"]) == ("Reset the stop when it stands, tool off.", None)


@pytest.mark.parametrize(
    ("code", "takes_s"),
    [
        ("rebooted", 20), ("link_lost", 20), ("operator_lost", 20), ("after_stop", 10), ("manual", 10),
        ("battery_low", None), ("tray_empty", None),
    ],
)  # fmt: skip
def test_what_is_cleared_at_the_screen_alone_says_how_long_that_takes(code: str, takes_s: float | None) -> None:
    found = sentence(r.with_state(r.PAUSED, hold=replace(r.HOLD_PAUSED, code=code)))
    assert found is not None
    assert found["takes_s"] == takes_s


def test_an_aircraft_that_waits_says_how_long_it_can_hover() -> None:
    waiting = with_battery(r.with_state(of(r.PAUSED, Family.UAV), hold=None), 0.6, 1200.0)
    found = sentence(waiting)
    assert found is not None
    assert found["text"] == "It holds its place in the air. Battery for 10 min more."
    assert help_s(waiting) == 0


def test_a_silent_aircraft_was_in_the_air() -> None:
    found = sentence(of(r.SILENT, Family.UAV))
    assert found is not None
    assert found["text"] == "It is not heard. It was in the air when last heard."


def test_a_robot_that_charges_says_so_and_asks_nobody() -> None:
    charging = with_battery(r.IDLE, 0.61, None, is_charging=True)
    found = sentence(charging)
    assert found is not None
    assert (found["code"], found["text"], found["who"]) == ("charging", "It charges, 61 %.", "nobody")
    assert not waits_for_person(charging)
    assert help_s(charging) is None


def test_nobody_guesses_how_long_a_walk_to_the_machine_takes() -> None:
    found = sentence(r.BUTTON)
    assert found is not None
    assert found["takes_s"] is None


def test_a_robot_at_work_has_no_sentence() -> None:
    assert sentence(r.RUNNING) is None


def test_help_is_due_when_the_battery_is_at_its_reserve_or_the_mission_ends() -> None:
    assert help_s(with_battery(r.RUNNING, 0.3, 3600.0)) == 1800
    assert help_s(with_battery(r.RUNNING, 0.9, 90_000.0)) == 12_360  # the mission ends first
    assert help_s(with_battery(r.RUNNING, 0.1, 600.0)) == 0
    assert help_s(with_battery(of(r.RUNNING, Family.UAV), 0.6, 1200.0)) == 600


def test_help_is_told_in_whole_minutes_so_that_the_figure_does_not_run() -> None:
    assert help_s(with_battery(r.RUNNING, 0.3, 3659.0)) == 1800


@pytest.mark.parametrize("state", ["latched", "button", "paused", "moved", "faulty"])
def test_a_robot_that_only_a_person_gets_going_waits_now(state: str) -> None:
    assert waits_for_person(r.EVERY[state])
    assert help_s(r.EVERY[state]) == 0


@pytest.mark.parametrize("state", ["running", "idle", "done", "silent", "stranger", "never heard"])
def test_others_do_not_wait_for_a_person(state: str) -> None:
    assert not waits_for_person(r.EVERY[state])


def test_a_hold_that_clears_itself_waits_for_nobody() -> None:
    held = r.with_state(r.PAUSED, hold=Hold("rtk", "It waits for RTK.", "It goes on by itself.", "nobody"))
    assert not waits_for_person(held)


@pytest.mark.parametrize(
    ("robot", "words"),
    [
        (r.RUNNING, "Row 37/84"),
        (of(r.RUNNING, Family.PLANTER), "Row 37/84"),
        (r.with_state(of(r.RUNNING, Family.UAV), path=("Mission", "Searching")), "Searching"),
        (r.with_state(r.RUNNING, path=("Mission", "Transit")), "Transit"),
        (r.GOING_HOME, "Return home"),
        (r.with_state(r.IDLE, path=("Docked",)), "Docked"),
        (with_battery(r.IDLE, 0.5, None, is_charging=True), "Charging"),
        (r.LOADED, "Ready to start"),
        (r.PAUSED, "Paused"),
        (r.NEVER_HEARD, ""),
    ],
)
def test_what_it_does_is_said_in_two_words(robot: Robot, words: str) -> None:
    assert task(robot) == words


def test_values_that_change_all_the_time_do_not_change_the_entry() -> None:
    later = with_battery(r.RUNNING, 0.6799, 18_590.0)
    later = r.with_fast(later, pose=replace(r.POSE, lat_deg=52.1), gnss=replace(r.FAST.gnss, accuracy_m=0.0121))
    assert slow(later) == slow(r.RUNNING)


def test_a_mission_is_told_with_the_map_it_is_drawn_from() -> None:
    mission = slow(r.RUNNING)["mission"]
    assert (mission["id"], mission["row"], mission["rows"], mission["share"]) == ("m-0412", 37, 84, 0.43)
    assert slow(r.with_state(r.IDLE, mode=Mode.IDLE))["mission"] is None
    assert slow(r.with_state(r.IDLE, order=r.ordered(OrderStatus.NONE)))["mission"] is None
