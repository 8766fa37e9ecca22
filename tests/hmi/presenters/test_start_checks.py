"""What must be true before a start: said in one sentence each, and locked for what the robot would refuse."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from hmi.domain.robot import Fault, Robot
from hmi.presenters.start_checks import MissionFacts, start_checks
from tests.hmi.presenters import robots as r

LOADED = r.EVERY["loaded"]
AWAY = ((6.0, 50.0), (6.1, 50.0), (6.1, 50.1))
FENCE = ((4.9, 51.9), (5.1, 51.9), (5.1, 52.1), (4.9, 52.1))


def ready(**changes: Any) -> Robot:
    """Return a loaded robot that may start, with some of its fast values changed."""
    fast = replace(r.FAST, **changes)
    return replace(LOADED, telemetry=fast)


def facts(**changes: Any) -> MissionFacts:
    assert LOADED.state is not None
    assert LOADED.state.order is not None
    usual = MissionFacts(
        LOADED.state.order.sha256,
        "Home field",
        1,
        battery_share=0.3,
        duration_s=LOADED.state.order.remaining_s or 3600.0,
        map_number=13,
        map_text="",
        start=(5.0001, 52.0),
        fences=(FENCE,),
    )
    return usual._replace(**changes)


def found(robot: Robot, known: MissionFacts | None) -> dict[str, dict[str, Any]]:
    return {one["key"]: one for one in start_checks(robot, known)}


def blocking(robot: Robot, known: MissionFacts | None) -> set[str]:
    return {key for key, one in found(robot, known).items() if one["blocks"]}


def test_a_robot_that_may_start_has_eight_good_checks() -> None:
    checks = found(ready(), facts())
    assert {key: one["ok"] for key, one in checks.items()} == dict.fromkeys(
        ("link", "mission", "map", "battery", "site", "rtk", "tool", "people"), True
    )
    assert not any(one["blocks"] or one["clears"] for one in checks.values())
    assert all(one["text"].endswith(".") for one in checks.values())


def test_how_far_the_first_point_is_counts_before_a_start_and_not_for_going_on() -> None:
    assert found(ready(), facts())["site"]["text"] == "It is at the site, 7 m from the first point."
    paused = replace(r.EVERY["paused"], telemetry=r.FAST)
    assert found(paused, facts(start=(5.02, 52.0)))["site"]["text"] == "It is at the site."


def test_a_running_mission_needs_no_checks() -> None:
    assert start_checks(r.EVERY["running"], facts()) == []


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"gnss": replace(r.FAST.gnss, fix="float")}, "rtk"),  # type: ignore[type-var]
        ({"tool": replace(r.FAST.tool, is_interlock_ok=False)}, "tool"),  # type: ignore[type-var]
        ({"battery": replace(r.FAST.battery, soc=0.08)}, "battery"),  # type: ignore[type-var]
    ],
)
def test_what_the_robot_would_refuse_keeps_the_slide_locked(changes: dict[str, Any], key: str) -> None:
    assert blocking(ready(**changes), facts()) == {key}
    assert found(ready(**changes), facts())[key]["clears"]


def test_another_version_on_the_robot_keeps_the_slide_locked() -> None:
    assert blocking(ready(), facts(sha256="f" * 64)) == {"mission"}


def test_a_person_ahead_keeps_the_slide_locked() -> None:
    robot = ready()
    assert robot.state is not None
    seen = replace(robot.state, faults=(Fault("person-ahead", "high", "Somebody.", "Look."),))
    assert blocking(replace(robot, state=seen), facts()) == {"people"}


def test_a_robot_at_another_place_keeps_the_slide_locked() -> None:
    assert blocking(ready(), facts(start=(5.02, 52.0))) == {"site"}


def test_a_charge_below_need_and_reserve_warns_and_says_what_happens() -> None:
    check = found(ready(), facts(battery_share=0.65))["battery"]
    assert (check["ok"], check["blocks"]) == (False, False)
    assert check["text"] == "Battery 68 %, the mission needs 65 % and 15 % reserve."
    assert "goes on later" in check["clears"]


def test_only_what_is_left_counts_against_the_battery() -> None:
    known = facts(battery_share=1.0)
    assert known.duration_s is not None
    check = found(ready(), known._replace(duration_s=known.duration_s * 4))["battery"]
    assert check["ok"]


def test_a_changed_map_and_a_place_outside_the_farm_warn() -> None:
    known = facts(map_text="Map is v15 now, plan uses v13.", fences=(AWAY,))
    checks = found(ready(), known)
    assert [checks[key]["ok"] for key in ("map", "site")] == [False, False]
    assert blocking(ready(), known) == set()
    assert found(ready(), facts(fences=(AWAY, FENCE)))["site"]["ok"]  # the second farm


def test_a_map_without_a_farm_edge_is_said_and_holds_nobody_up() -> None:
    site = found(ready(), facts(map_text="", fences=()))["site"]
    assert site["ok"]
    assert site["text"].endswith("The map has no farm edge: nobody notices if it leaves.")
    assert "edge" not in found(ready(), facts(map_text=None, fences=()))["site"]["text"]


def test_what_is_not_known_is_said_and_never_good() -> None:
    checks = found(replace(LOADED, telemetry=None), None)
    unknown = {key for key, one in checks.items() if one["ok"] is None}
    assert unknown == {"mission", "map", "battery", "site", "rtk", "tool", "people"}
