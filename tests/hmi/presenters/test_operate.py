"""The operate screen says what is true, in SI for machines and in words for people."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from typing import Any

import pytest

from hmi.domain.family import Family
from hmi.domain.robot import Battery, Fault, Gnss, OrderStatus, Robot, ToolState
from hmi.presenters.fleet import entry, level
from hmi.presenters.operate import PRESENTERS, Context, MissionTitle, present
from hmi.presenters.tiles import tiles
from hmi.presenters.units import age_text, heading_deg, number, percent, short_length, span_text
from tests.hmi.presenters import robots as r


def tile(robot: Robot, key: str) -> dict[str, Any]:
    """Return one tile."""
    return next(t for t in tiles(robot) if t["key"] == key)


def test_the_tiles_of_a_running_weeder_read_as_in_the_picture() -> None:
    shown = [(t["label"], t["text"], t["unit"], t["sub"]) for t in tiles(r.RUNNING)]
    assert shown == [
        ("Speed", "0.42", "m/s", "set 0.45 m/s"),
        ("Battery", "68", "%", "5 h 10, need 3 h 26"),
        ("RTK", "Fix", "±1.4 cm", "27 sats, corr. 0.8 s"),
        ("Link delay", "86", "ms", "max 140 ms, 1 min"),
        ("Laser", "On", "212 /min", "interlock ok, 41 °C"),
        ("Off line", "0.9", "cm", "limit ±3.0 cm"),
    ]


def test_the_camera_of_a_uav_has_no_interlock_to_tell_of_but_an_open_one_is_told() -> None:
    assert r.RUNNING.factsheet is not None
    uav = replace(r.RUNNING, factsheet=replace(r.RUNNING.factsheet, family=Family.UAV))
    is_open = r.with_fast(uav, tool=replace(r.FAST.tool, is_interlock_ok=False)) if r.FAST.tool else uav
    said = [t["sub"] for one in (uav, is_open) for t in tiles(one) if t["key"] == "tool"]
    assert said == ["41 °C", "interlock open, 41 °C"]


def test_tiles_carry_si_values_for_machines() -> None:
    assert [(t["key"], t["value"]) for t in tiles(r.RUNNING)] == [
        ("speed", 0.42),
        ("battery", 0.68),
        ("gnss", 0.014),
        ("delay", 0.086),
        ("tool", "on"),
        ("cross-track", 0.009),
    ]


def test_nothing_is_abnormal_on_a_running_weeder() -> None:
    assert [t["level"] for t in tiles(r.RUNNING)] == [None] * 6


def test_a_missing_value_is_never_a_zero() -> None:
    for t in tiles(r.NEVER_HEARD):
        assert t["value"] is None
        assert t["text"] == "––"
        assert t["t"] is None
        assert t["missing"]


@pytest.mark.parametrize("state", r.EVERY)
def test_every_tile_says_when_it_was_true_or_why_there_is_none(state: str) -> None:
    found = tiles(r.EVERY[state])
    assert [t["key"] for t in found] == ["speed", "battery", "gnss", "delay", "tool", "cross-track"]
    for t in found:
        assert (t["t"] is None) == (t["missing"] is not None)
        assert t["period_ms"] in (100, 1000)
        assert t["missing"] is not None or t["sub"]


@pytest.mark.parametrize("state", r.EVERY)
def test_bars_stay_between_their_ends(state: str) -> None:
    for t in tiles(r.EVERY[state]):
        if t["bar"] is not None:
            figures = [*t["bar"]["ok"], t["bar"]["ptr"], *t["bar"]["limits"]]
            assert all(0 <= x <= 100 for x in figures)
            assert t["bar"]["ok"][0] <= t["bar"]["ok"][1]


@pytest.mark.parametrize(
    ("robot", "key", "expected"),
    [
        (r.with_fast(r.RUNNING, gnss=Gnss("float", 0.35, 20, 4.0)), "gnss", ("Float", 3)),
        (r.with_fast(r.RUNNING, gnss=Gnss("single", 2.5, 9, None)), "gnss", ("Single", 2)),
        (r.with_fast(r.RUNNING, gnss=Gnss("none", 0.0, 0, None)), "gnss", ("None", 2)),
        (r.with_fast(r.RUNNING, battery=Battery(0.14, 3000.0, False)), "battery", ("14", 2)),
        (r.with_fast(r.RUNNING, battery=Battery(0.24, 30000.0, False)), "battery", ("24", 3)),
        (r.with_fast(r.RUNNING, battery=Battery(0.60, 9000.0, False)), "battery", ("60", 3)),
        (r.with_fast(r.RUNNING, battery=Battery(0.10, None, True)), "battery", ("10", None)),
        (r.with_fast(r.RUNNING, tool=ToolState("fault", True, None, None)), "tool", ("Fault", 2)),
        (r.with_fast(r.RUNNING, tool=ToolState("off", False, None, 33.0)), "tool", ("Off", 3)),
        (r.with_fast(r.MANUAL, tool=ToolState("off", False, None, 33.0)), "tool", ("Off", None)),
        (r.with_fast(r.RUNNING, cross_track_m=-0.042), "cross-track", ("4.2", 3)),
        (r.with_fast(r.PAUSED, cross_track_m=-0.042), "cross-track", ("4.2", None)),
        (r.at_speed(r.RUNNING, 1.9), "speed", ("1.90", 2)),
        (replace(r.RUNNING, link=replace(r.LINK, rtt_s=0.41)), "delay", ("410", 3)),
    ],
)
def test_what_is_abnormal_has_a_level(robot: Robot, key: str, expected: tuple[str, int | None]) -> None:
    found = tile(robot, key)
    assert (found["text"], found["level"]) == expected


@pytest.mark.parametrize(
    ("robot", "key", "meaning"),
    [
        (r.MANUAL, "speed", "limit 0.20 m/s"),
        (r.PAUSED, "speed", "paused"),
        (r.LATCHED, "speed", "standstill confirmed"),
        (r.BRAKING, "speed", "stopping"),
        (r.MANUAL, "delay", "drive cuts at 300 ms"),
        (r.IDLE, "battery", "5 h 10 left"),
        (r.with_fast(r.RUNNING, battery=Battery(0.5, None, True)), "battery", "charging"),
    ],
)
def test_one_line_of_meaning_follows_the_state(robot: Robot, key: str, meaning: str) -> None:
    assert tile(robot, key)["sub"] == meaning


@pytest.mark.parametrize(
    ("state", "mode", "text"),
    [
        ("running", "auto", "Running"),
        ("going home", "auto", "Return home"),
        ("idle", "idle", "Ready"),
        ("loaded", "idle", "Ready to start"),
        ("done", "idle", "Mission done"),
        ("paused", "paused", "Paused"),
        ("manual", "manual", "Driven by hand"),
        ("latched", "stopped", "Latched"),
        ("button", "stopped", "Button pressed"),
        ("faulty", "fault", "Fault"),
    ],
)
def test_the_mode_is_said_in_a_word_or_two(state: str, mode: str, text: str) -> None:
    shown = present(r.EVERY[state], Context(), ["mode"])["mode"]
    assert (shown["mode"], shown["text"]) == (mode, text)


def test_people_stay_away_as_far_as_the_machine_says_or_further_where_the_farm_asks_for_it() -> None:
    asked = [present(r.RUNNING, Context(keep_out_m=metres), ["body"])["body"]["keep_out_m"] for metres in (None, 8, 25)]
    assert asked == [15.0, 15.0, 25]


def test_the_mission_is_called_by_its_name_when_it_is_known() -> None:
    context = Context(title_of=lambda mission_id: MissionTitle("M-0412", "Nordfeld 12") if mission_id else None)
    mission = present(r.RUNNING, context, ["mission"])["mission"]
    assert (mission["name"], mission["field"], mission["id"]) == ("M-0412", "Nordfeld 12", "m-0412")
    assert (mission["row"], mission["rows"], mission["share"]) == (37, 84, pytest.approx(0.4344, abs=1e-4))
    assert (mission["segment"], mission["segment_s_m"]) == (73, 12.5)
    assert present(r.RUNNING, Context(), ["mission"])["mission"]["name"] == "m-0412"


def test_a_mission_without_area_has_no_share_and_no_error() -> None:
    robot = r.with_state(r.RUNNING, order=r.ordered(OrderStatus.RUNNING, area_m2=0.0))
    assert present(robot, Context(), ["mission"])["mission"]["share"] == 0.0


def test_the_machine_is_described_with_whom_to_call() -> None:
    body = present(r.RUNNING, Context("Jonas Weber", "+49 170 000"), ["body"])["body"]
    assert body["contact"] == {"name": "Jonas Weber", "phone": "+49 170 000"}
    assert (body["decel_mps2"], body["deadman_s"], body["operator_lost_s"], body["horn_s"]) == (1.2, 0.5, 3.5, 3.0)


def test_of_a_uav_nobody_says_that_it_pauses_without_the_link() -> None:
    assert r.RUNNING.factsheet is not None
    uav = replace(r.RUNNING, factsheet=replace(r.RUNNING.factsheet, family=Family.UAV))
    bodies = [present(one, Context(), ["body"])["body"] for one in (r.RUNNING, uav)]
    assert [body["link_lost_s"] for body in bodies] == [10.0, None]


def test_presses_carry_who_where_and_when() -> None:
    presses = present(r.LATCHED, Context(), ["safety"])["safety"]["presses"]
    assert presses == [
        {"stop_id": "stop-0001", "by": "Martha Keller", "device": "Tablet 3", "t": 990_000.0, "is_reset": False}
    ]


@pytest.mark.parametrize("state", r.EVERY)
def test_every_state_can_be_sent_and_names_every_group(state: str) -> None:
    groups = present(r.EVERY[state], Context())
    assert set(groups) == set(PRESENTERS)
    json.dumps(groups, allow_nan=False)


def test_what_was_never_heard_is_null() -> None:
    groups = present(r.NEVER_HEARD, Context())
    nulls = {name for name, value in groups.items() if value is None}
    assert nulls == {"mode", "pose", "mission", "supervisor", "safety", "body", "faults"}


@pytest.mark.parametrize(
    ("state", "expected"),
    [("running", None), ("latched", 3), ("silent", 2), ("stranger", None), ("never heard", 2)],
)
def test_the_fleet_shows_the_worst_first(state: str, expected: int | None) -> None:
    assert level(r.EVERY[state]) == expected
    assert entry(r.EVERY[state])["level"] == expected


def test_a_critical_fault_is_the_worst_of_all() -> None:
    faults = (Fault("a", "low", "", ""), Fault("b", "critical", "", ""))
    assert level(r.with_state(r.LATCHED, faults=faults)) == 1


def test_the_fleet_entry_of_a_robot_never_heard_invents_nothing() -> None:
    shown = entry(r.NEVER_HEARD)
    assert shown["lat"] is None
    assert shown["soc"] is None
    assert shown["mode"] == "unknown"
    assert shown["why"] == "It is not heard."


@pytest.mark.parametrize(
    ("theta_rad", "expected"),
    [(0.0, 90.0), (math.pi / 2, 0.0), (math.pi, 270.0), (-math.pi / 2, 180.0), (100 * math.pi, 90.0)],
)
def test_heading_is_clockwise_from_north(theta_rad: float, expected: float) -> None:
    assert heading_deg(theta_rad) == pytest.approx(expected)


def test_numbers_are_written_for_people() -> None:
    assert number(-0.2, 2) == "−0.20"
    assert number(-0.001, 2) == "0.00"
    assert percent(0.999) == "99"
    assert percent(0.29) == "29"
    assert short_length(0.009) == ("0.9", "cm")
    assert short_length(0.35) == ("35", "cm")
    assert short_length(1.25) == ("1.25", "m")
    assert [span_text(s) for s in (0, 90, 3540, 12360)] == ["0 min", "2 min", "59 min", "3 h 26"]
    assert [age_text(s) for s in (0.2, 9.96, 12, 59.6, 134, 4080)] == [
        "0.2 s",
        "10 s",
        "12 s",
        "1:00",
        "2:14",
        "1 h 08",
    ]


@pytest.mark.parametrize("state", ["loaded", "paused", "done"])
@pytest.mark.parametrize("is_supervised", [True, False])
def test_who_looks_on_is_told_as_a_start_would_say_it(state: str, is_supervised: bool) -> None:
    context = Context(is_supervised=lambda _robot, _order: is_supervised)
    assert present(r.EVERY[state], context, ("mission",))["mission"]["is_supervised"] is is_supervised


@pytest.mark.parametrize("state", ["running", "going home"])
def test_while_it_drives_the_robot_says_itself_who_looks_on(state: str) -> None:
    robot = r.EVERY[state]
    assert robot.state is not None
    assert robot.state.order is not None
    context = Context(is_supervised=lambda _robot, order: not order.is_supervised)
    shown = present(robot, context, ("mission",))["mission"]["is_supervised"]
    assert shown is robot.state.order.is_supervised
