"""What can be done in each state, and why not; why it is not moving, what clears it and who can."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hmi.domain.machine import Body, JointInfo
from hmi.domain.robot import Fault, Mode
from hmi.presenters.actions import ACTIONS, actions, why
from tests.hmi.presenters import robots as r

ALLOWED: dict[str, set[str]] = {
    "running": {"pause", "change", "abort", "return_home", "drive"},
    "idle": {"return_home", "drive"},
    "loaded": {"start", "return_home", "drive"},
    "done": {"start", "fresh", "return_home", "drive"},
    "paused": {"resume", "fresh", "change", "abort", "return_home", "drive"},
    "moved": {"start", "later", "fresh", "abort", "return_home", "drive"},
    "going home": {"pause", "abort", "return_home", "drive"},
    "manual": {"pause", "abort", "drive"},
    "braking": {"abort"},
    "latched": {"abort", "reset"},
    "button": {"abort"},
    "faulty": {"abort", "drive"},
    "silent": set(),
    "brokerless": set(),
    "stranger": set(),
    "never heard": set(),
}


FREE = {"go_to", "tool_retract", "tool_go_to", "stock_refilled", "jog"}
TOOLS: dict[str, set[str]] = {
    **dict.fromkeys(("idle", "loaded", "done"), FREE),
    **dict.fromkeys(("paused", "moved"), FREE | {"skip_target"}),
    "running": {"stock_refilled", "jog", "skip_target"},
    "going home": {"stock_refilled", "jog", "skip_target"},
    "manual": {"tool_retract", "tool_go_to", "stock_refilled", "jog", "skip_target"},
    "faulty": {"tool_retract", "tool_go_to", "stock_refilled", "jog", "skip_target"},
}


UNHEARD = ("silent", "brokerless", "stranger", "never heard")
"""A robot's cameras take orders in every other state: they move nothing."""


@pytest.mark.parametrize("state", ALLOWED)
def test_the_state_decides_what_is_allowed(state: str) -> None:
    found = actions(r.EVERY[state])
    camera = set() if state in UNHEARD else {"camera"}
    assert tuple(found) == ACTIONS
    assert {name for name, verdict in found.items() if verdict["ok"]} == ALLOWED[state] | TOOLS.get(
        state, set()
    ) | camera


@pytest.mark.parametrize("state", r.EVERY)
def test_a_refused_action_always_has_a_reason_and_an_allowed_one_none(state: str) -> None:
    for verdict in actions(r.EVERY[state]).values():
        assert verdict["ok"] == (verdict["reason"] == "")


@pytest.mark.parametrize(
    ("state", "action", "reason"),
    [
        ("latched", "resume", "Reset the stop first"),
        ("latched", "start", "Reset the stop first"),
        ("latched", "drive", "Reset the stop first"),
        ("latched", "return_home", "Reset the stop first"),
        ("braking", "reset", "Wait until it stands still"),
        ("button", "reset", "Hardware button is pressed on the machine. Release it there first."),
        ("button", "resume", "Hardware button is pressed on the machine. Release it there first."),
        ("running", "reset", "No stop is active"),
        ("running", "start", "The mission is running"),
        ("paused", "start", "Resume or abort the paused mission first"),
        ("moved", "resume", "It was moved since the pause. Drive it back, or Resume later"),
        ("idle", "start", "Send a mission first"),
        ("manual", "resume", "End driving by hand first"),
        ("silent", "pause", "Commands are off until the link is back."),
        ("never heard", "start", "Commands are off until the link is back."),
        ("stranger", "pause", "It is not registered here. An admin can accept it."),
    ],
)
def test_reasons_are_sentences_of_the_field(state: str, action: str, reason: str) -> None:
    assert actions(r.EVERY[state])[action]["reason"] == reason


def test_nothing_that_moves_is_allowed_before_the_safety_controller_was_heard() -> None:
    unheard = replace(r.LOADED, safety=None)
    assert {n for n, v in actions(unheard).items() if v["ok"]} == {"camera"}


@pytest.mark.parametrize(
    ("code", "reason"), [("crane_limit", ""), ("ask_person", ""), ("person_ahead", "Pause it first")]
)
def test_a_mission_at_work_takes_a_retract_only_while_it_waits_for_one(code: str, reason: str) -> None:
    waiting = r.with_state(r.RUNNING, hold=replace(r.HOLD_PAUSED, code=code))
    assert actions(waiting)["tool_retract"]["reason"] == reason


@pytest.mark.parametrize("state", ["running", "idle", "done", "manual", "going home"])
def test_there_is_nothing_to_explain_when_it_moves_or_has_nothing_to_do(state: str) -> None:
    assert why(r.EVERY[state]) is None


@pytest.mark.parametrize(
    ("state", "code", "clears", "who"),
    [
        ("latched", "stop_latched", "Reset the stop, then resume.", "operator"),
        ("button", "hardware_stop", "Release it at the machine.", "anybody at the machine"),
        ("paused", "paused", "Resume the mission.", "operator"),
        ("moved", "moved_while_paused", "Drive it back.", "operator"),
        ("loaded", "ready", "Slide to start.", "operator"),
        ("silent", "no_link", "Look at its power and its radio.", "anybody at the machine"),
        ("brokerless", "no_broker", "Start the broker.", "admin"),
        ("never heard", "no_link", "Look at its power and its radio.", "anybody at the machine"),
        ("stranger", "not_registered", "Accept it under Admin, Robots.", "admin"),
        ("faulty", "fault", "Look at its alarms.", "operator"),
    ],
)
def test_why_says_what_clears_it_and_who_can(state: str, code: str, clears: str, who: str) -> None:
    found = why(r.EVERY[state])
    assert found is not None
    assert (found["code"], found["clears"], found["who"]) == (code, clears, who)
    assert found["text"].endswith(".")


def test_why_names_everybody_whose_stop_is_not_reset() -> None:
    anna = replace(r.PRESS, stop_id="stop-0002", by="Anna Ostermeier", pressed_s=995.0)
    past = replace(r.PRESS, stop_id="stop-0000", by="Jonas Weber", is_reset=True)
    found = why(r.with_safety(r.LATCHED, presses=(past, r.PRESS, anna)))
    assert found is not None
    assert found["text"] == "Martha Keller and Anna Ostermeier pressed STOP."
    assert found["since"] == 990_000.0


def test_a_fault_is_told_in_the_robots_words() -> None:
    fault = Fault("track-jam", "critical", "The left track is jammed.", "Clear the track at the machine.")
    found = why(r.with_state(r.FAULTY, faults=(fault,)))
    assert found is not None
    assert found["text"] == "The left track is jammed."
    assert found["clears"] == "Clear the track at the machine."


def test_what_the_robot_says_of_itself_comes_before_our_guess() -> None:
    running_but_held = r.with_state(r.RUNNING, hold=replace(r.HOLD_PAUSED, code="rtk_float", text="RTK is not fixed."))
    found = why(running_but_held)
    assert found is not None
    assert found["code"] == "rtk_float"


def test_a_latched_stop_wins_over_a_mode_that_says_auto() -> None:
    lying = r.with_state(r.LATCHED, mode=Mode.AUTO)
    assert not actions(lying)["pause"]["ok"]
    found = why(lying)
    assert found is not None
    assert found["code"] == "stop_latched"


def test_an_arm_is_sent_nowhere_while_its_joints_are_not_heard() -> None:
    joint = JointInfo("boom", "Boom", "rad", -1.0, 1.0, 0.2, None, None)
    sheet = replace(r.SHEET, joints=(joint,))
    idle = replace(r.with_state(r.RUNNING, mode=Mode.IDLE), factsheet=sheet)
    assert actions(idle)["tool_go_to"] == {"ok": False, "reason": "Its joints were not heard."}
    body = Body({"boom": 0.1}, {}, {}, None, None, None, (), r.T)
    assert actions(replace(idle, body=body))["tool_go_to"]["ok"]
    late = replace(idle, body=body, link=replace(r.LINK, heard_s=r.T.source_s + 2.5))
    assert actions(late)["tool_go_to"]["reason"] == "Its joints are not heard any more."
    assert actions(late)["tool_retract"]["ok"], "it goes by itself, and helps out"
