"""Nodes and functions as a person reads them, and what follows from them on Operate."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from hmi.domain.machine import Body, GaugeInfo, JointInfo
from hmi.domain.robot import Family, Robot, Stamp
from hmi.presenters import functions, nodes
from hmi.presenters.actions import actions
from hmi.presenters.start_checks import start_checks
from hmi.presenters.tiles import layout, tiles
from tests.hmi.domain.nodes import NOW_S, function, info, node, robot
from tests.hmi.presenters import robots as r

GUIDANCE = info("guidance", "Guidance", rate_hz=20.0, after=("gnss",))
GNSS = info("gnss", "RTK receiver")
TREE = [
    function("treat", "follow-path", label="Weed"),
    function("follow-path", "guidance", "gnss", label="Follow a path"),
]


def shown(**changes: Any) -> dict[str, Any]:
    """Return the node ``guidance`` with changes, as a screen gets it."""
    usual = {"rate_hz": 20.0, "since_s": NOW_S - 400}
    found = robot([node("guidance", **{**usual, **changes}), node("gnss")], TREE, [GNSS, GUIDANCE])
    told = nodes.present(found, NOW_S)
    assert told is not None
    return {one["name"]: one for one in told["nodes"]}["guidance"]


def test_a_node_carries_what_the_contract_names() -> None:
    assert shown() == {
        "name": "guidance",
        "label": "Guidance",
        "subsystem": "Drive",
        "state": "started",
        "rate_hz": 20.0,
        "usual_hz": 20.0,
        "cpu_pct": 4.0,
        "restarts": 0,
        "text": "",
        "host": "main",
        "since": 600_000.0,
        "t": 999_000.0,
        "period_ms": 5000,
        "offset_ms": 1.0,
        "starts_after": ["gnss"],
        "finding": "",
        "findings": [],
        "level": None,
        "off": ["Weed", "Follow a path"],
    }


@pytest.mark.parametrize(
    ("changes", "finding", "level"),
    [
        ({"state": "failure", "text": "exit 139"}, "Failed. exit 139", 2),
        ({"stamp": Stamp(NOW_S - 41, NOW_S)}, "Not heard any more. What is shown of it is old.", 2),
        ({"rate_hz": 9.0}, "Runs at 9 Hz, usual 20 Hz.", 3),
        (
            {"clock_offset_s": -0.18},
            "Its clock is 180 ms behind: what it measures is put at the wrong place and time. "
            "Set up the time service on main.",
            3,
        ),
        ({"clock_offset_s": 0.05}, "", None),
        ({"since_s": NOW_S - 600}, "It was started before RTK receiver and may have missed it. Restart it.", 3),
        ({"restarts": 3}, "Restarted 3 times, the last time within 10 minutes.", None),
        (
            {"restarts": 3, "since_s": NOW_S - 450, "state": "stopped"},
            "Restarted 3 times, the last time within 10 minutes.",
            None,
        ),
    ],
)
def test_what_is_wrong_with_a_node_is_one_sentence(changes: dict[str, Any], finding: str, level: int | None) -> None:
    told = shown(**changes)
    assert (told["finding"], told["level"]) == (finding, level)


def test_a_node_that_needs_one_which_is_not_started_says_which() -> None:
    found = robot([node("guidance")], TREE, [GNSS, GUIDANCE])
    told = nodes.present(found, NOW_S)
    assert told is not None
    by_name = {one["name"]: one for one in told["nodes"]}
    assert by_name["guidance"]["finding"].startswith("It needs RTK receiver first, which is not started.")
    assert (by_name["gnss"]["state"], by_name["gnss"]["t"], by_name["gnss"]["restarts"]) == ("unknown", None, None)


def test_nothing_is_shown_of_a_robot_that_told_nothing() -> None:
    assert nodes.present(r.RUNNING, NOW_S) is None
    assert functions.present(r.RUNNING, NOW_S) is None
    assert functions.present(r.NEVER_HEARD, NOW_S) is None


def test_functions_come_as_a_tree_with_why_since_and_a_hint() -> None:
    found = robot([node("guidance", "stopped", since_s=NOW_S - 41), node("gnss")], TREE, [GNSS, GUIDANCE])
    told = functions.present(found, NOW_S)
    assert told is not None
    assert [(one["name"], one["depth"], one["parent"]) for one in told["functions"]] == [
        ("treat", 0, ""),
        ("follow-path", 1, "treat"),
    ]
    assert (told["on"], told["total"], told["hint"]) == (0, 2, "To turn on Weed: start Guidance.")
    assert told["functions"][0] | {"depends_on": [], "better_with": []} == {
        "name": "treat", "label": "Weed", "state": "off", "why": "Guidance stopped", "turns_on": "Start Guidance",
        "since": 959_000.0, "level": None, "depends_on": [], "better_with": [], "depth": 0, "parent": "",
    }  # fmt: skip


def off_path(base: Robot) -> Robot:
    """Return a robot that cannot follow a path."""
    return replace(
        base, factsheet=robot([], TREE).factsheet, nodes={"guidance": node("guidance", "failure"), "gnss": node("gnss")}
    )


def test_an_action_that_uses_a_function_which_is_off_says_which_and_what_turns_it_on() -> None:
    found = actions(off_path(r.LOADED))
    assert found["start"]["reason"] == "Weed is off: guidance failed. Restart guidance on Supervisor."
    assert found["return_home"]["reason"] == "Follow a path is off: guidance failed. Restart guidance on Supervisor."
    assert found["drive"]["ok"]
    assert actions(off_path(r.RUNNING))["pause"]["ok"]
    assert actions(off_path(r.RUNNING))["abort"]["ok"]
    assert actions(off_path(r.LATCHED))["reset"]["ok"]


def test_what_the_state_forbids_is_said_before_what_a_function_lacks() -> None:
    assert actions(off_path(r.LATCHED))["return_home"]["reason"] == "Reset the stop first"
    assert actions(off_path(r.SILENT))["return_home"]["reason"] == "Commands are off until the link is back."


def check(found: Robot) -> dict[str, Any] | None:
    """Return the check of functions before a start."""
    return next((one for one in start_checks(found, None) if one["key"] == "functions"), None)


def test_the_checks_before_a_start_name_a_function_that_is_off_and_block() -> None:
    told = check(off_path(r.LOADED))
    assert told is not None
    assert (told["ok"], told["blocks"]) == (False, True)
    assert told["text"] == "Weed is off: guidance failed."
    assert told["clears"] == "Restart guidance on Supervisor."


def test_a_limited_function_warns_and_one_that_is_on_is_fine() -> None:
    tree = [function("treat", "gnss", better=("cam",), label="Weed")]
    limited = replace(
        r.LOADED, factsheet=robot([], tree).factsheet, nodes={"gnss": node("gnss"), "cam": node("cam", "stopped")}
    )
    told = check(limited)
    assert told is not None
    assert (told["ok"], told["blocks"], told["text"]) == (False, False, "Weed is limited: cam stopped.")
    fine = check(replace(limited, nodes={"gnss": node("gnss"), "cam": node("cam")}))
    assert fine is not None
    assert fine["ok"]


@pytest.mark.parametrize("state", r.EVERY)
def test_a_robot_that_declares_no_functions_sees_no_difference(state: str) -> None:
    assert check(r.EVERY[state]) is None
    assert all("Supervisor" not in one["reason"] for one in actions(r.EVERY[state]).values())


BOOM = JointInfo("boom", "Boom", "rad", -0.4, 1.3, 0.3, -0.3, 1.2)
TILT = GaugeInfo("tilt", "Tilt", "°", 0.0, 20.0, None, 12.0, "stops at 12°")
WIND = GaugeInfo("wind", "Wind", "m/s", 0.0, 20.0, None, 10.0, "lands at 12 m/s")


def planter(**measured: Any) -> Robot:
    """Return a planter with a body."""
    sheet = replace(r.SHEET, family=Family.PLANTER, tool_label="Crane", joints=(BOOM,), gauges=(TILT,))
    values = {"boom": 0.7, "tilt": 4.2, "stock": 41, "is_loaded": True, **measured}
    body = Body(
        {"boom": values["boom"]}, {}, {"tilt": values["tilt"]}, None, values["is_loaded"], values["stock"], (), r.T
    )
    return replace(r.RUNNING, factsheet=sheet, body=body)


def tile(found: Robot, key: str) -> dict[str, Any]:
    """Return one tile."""
    return next(one for one in tiles(found) if one["key"] == key)


def test_a_planter_shows_crane_trays_and_tilt_where_a_weeder_shows_its_laser() -> None:
    assert [key for key, _ in layout(planter())] == [
        "speed", "battery", "tool", "tilt", "stock", "gnss", "delay", "cross-track",
    ]  # fmt: skip
    assert (tile(planter(), "tool")["label"], tile(planter(), "tool")["sub"]) == (
        "Crane",
        "seedling in hand",
    )
    trays = tile(planter(), "stock")
    assert (trays["value"], trays["text"], trays["unit"], trays["level"]) == (41, "41", "left", None)
    tilt = tile(planter(), "tilt")
    assert (tilt["value"], tilt["text"], tilt["unit"], tilt["sub"], tilt["level"]) == (
        4.2,
        "4.2",
        "°",
        "stops at 12°",
        None,
    )
    assert [key for key, _ in layout(r.RUNNING)] == ["speed", "battery", "gnss", "delay", "tool", "cross-track"]


def test_what_is_outside_its_limits_is_marked_and_what_is_not_told_is_missing() -> None:
    assert (tile(planter(boom=1.25), "tool")["level"], tile(planter(boom=1.25), "tool")["sub"]) == (
        2,
        "Boom at its soft limit",
    )
    assert tile(planter(tilt=13.0), "tilt")["level"] == 2
    assert tile(planter(stock=0), "stock")["level"] == 3
    assert tile(planter(stock=None), "stock")["missing"] == "not told"
    bare = replace(planter(), body=None)
    assert {tile(bare, key)["missing"] for key in ("stock", "tilt")} == {"nothing heard yet"}


def test_a_drone_shows_height_wind_and_time_to_return_only_where_it_tells_them() -> None:
    sheet = replace(r.SHEET, family=Family.UAV)
    assert [key for key, _ in layout(replace(r.RUNNING, factsheet=sheet))] == [key for key, _ in layout(r.RUNNING)]
    windy = replace(
        r.RUNNING,
        factsheet=replace(sheet, gauges=(WIND,)),
        body=Body({}, {}, {"wind": 11.0}, None, None, None, (), r.T),
    )
    assert (tile(windy, "wind")["text"], tile(windy, "wind")["level"]) == ("11.0", 2)


def test_a_machine_that_nobody_here_knows_shows_the_first_gauges_it_declares() -> None:
    gauges = tuple(
        replace(TILT, key=key, label=key.title()) for key in ("crate", "speed", "vacuum", "oil", "hand", "x")
    )
    body = Body({}, {}, {"crate": 3.4}, None, None, None, (), r.T)
    other = replace(r.RUNNING, factsheet=replace(r.SHEET, family=Family.OTHER, gauges=gauges), body=body)
    keys = [one["key"] for one in tiles(other)]
    assert keys == ["speed", "battery", "crate", "vacuum", "oil", "hand", "tool", "gnss", "delay", "cross-track"]
    assert (tile(other, "crate")["text"], tile(other, "oil")["text"]) == ("3.4", "––")
