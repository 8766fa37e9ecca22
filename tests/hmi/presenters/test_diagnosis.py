"""The guided check calls nothing live that is old, and sends nobody up to a machine that may move."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hmi.domain.alarm.catalogue import catalogue
from hmi.domain.robot import Battery, Robot
from hmi.presenters.diagnosis import diagnose
from hmi.presenters.scene import Scene
from tests.hmi.presenters import robots as r

NOW_S, SILENT_S = 1000.3, 1200.0
MAY_MOVE = "It may move. Use the red button and keep everyone away."


def silent(robot: Robot = r.RUNNING) -> Robot:
    """Return a robot that nothing is heard of any more."""
    return replace(robot, link=replace(robot.link, is_online=False, heard_s=NOW_S))


def others(heard: int, of: int) -> list[Robot]:
    """Return the other robots of the farm, so many of them heard."""
    return [r.RUNNING] * heard + [silent()] * (of - heard)


def found(code: str, scene: Scene) -> dict[str, tuple[str, bool | None]]:
    """Return what the check of a type found, by question."""
    steps = diagnose(catalogue()[code].diagnosis, scene)["steps"]
    return {one["text"]: (one["found"], one["ok"]) for one in steps}


def concluded(code: str, scene: Scene) -> str:
    """Return what the check of a type concludes."""
    text: str = diagnose(catalogue()[code].diagnosis, scene)["conclusion"]
    return text


@pytest.mark.parametrize("code", ["stop-not-confirmed", "moves-after-stop", "moves-unasked", "tool-on-unasked"])
def test_a_robot_that_fell_silent_may_move_whatever_else_is_found(code: str) -> None:
    for heard in (0, 5):
        assert concluded(code, Scene(NOW_S + SILENT_S, silent(), others(heard, 5))) == MAY_MOVE
    assert concluded(code, Scene(NOW_S, replace(r.RUNNING, safety=None))) == MAY_MOVE
    standing = r.with_safety(r.RUNNING, standstill=True, tool_off=True)
    assert concluded(code, Scene(NOW_S, standing)) != MAY_MOVE


def test_old_values_carry_their_age_and_are_neither_good_nor_bad() -> None:
    at = Scene(NOW_S + SILENT_S, silent())
    ago = "20:00 ago."
    for code in ("moves-after-stop", "battery-low", "tool-interlock", "person-ahead", "rtk-float", "stalled"):
        for text, (said, is_ok) in found(code, at).items():
            if text in ("Is the robot heard?", "Does it measure that it stands, with its tool off?"):
                continue  # that it does not stand is believed until it says otherwise
            assert ago in said or said == "Not known.", text
            assert is_ok is None, text


def test_fresh_values_are_judged() -> None:
    at = Scene(NOW_S, r.RUNNING)
    assert found("tool-interlock", at)["Are the covers of its tool closed?"][1] is True
    assert "ago" not in found("moves-after-stop", at)["How fast is it?"][0]


def test_an_old_low_battery_may_still_be_why_it_is_silent() -> None:
    empty = r.with_fast(r.RUNNING, battery=Battery(0.04, None, is_charging=False))
    scene = Scene(NOW_S + SILENT_S, silent(empty))
    assert found("link-lost", scene)["How full was the battery?"] == ("4 %, 20:00 ago.", False)


@pytest.mark.parametrize(
    ("heard", "of", "is_broker_up", "begins"),
    [
        (3, 5, True, "Only this robot is silent"),
        (0, 5, True, "No robot is heard"),
        (0, 0, True, "This robot is silent"),
        (0, 5, False, "The console has lost the broker"),
    ],
)
def test_only_this_robot_is_silent_is_said_where_others_are_heard(
    heard: int, of: int, is_broker_up: bool, begins: str
) -> None:
    scene = Scene(NOW_S + SILENT_S, silent(), others(heard, of), is_broker_up)
    assert concluded("values-old", scene).startswith(begins)
