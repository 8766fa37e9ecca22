"""A function is on only while everything it depends on is there, and says why when it is not."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmi.domain.command import Action
from hmi.domain.function_use import camera_obstacle, jog_obstacle, obstacle
from hmi.domain.functions import Ability, evaluate, needing, tree
from hmi.domain.machine import Body, FunctionInfo, GaugeInfo, JointInfo
from hmi.domain.robot import Node, Robot, Stamp
from tests.hmi.domain.nodes import NOW_S, function, info, node, robot
from tests.hmi.presenters import robots as r

NODES = [f"node-{i}" for i in range(6)]
WRONG = (
    {"state": "stopped"},
    {"state": "failure", "text": "No picture"},
    {"state": "starting"},
    {"state": "stopping"},
    {"state": "unknown"},
    {"stamp": Stamp(NOW_S - 16, NOW_S - 16)},
    {"rate_hz": 4.9},
)
SLOW, WAIT = "Restart Rear camera", "Wait for fresh values of the machine"
RIGHT: tuple[dict[str, object], ...] = ({}, {"rate_hz": None}, {"rate_hz": 5.0}, {"stamp": Stamp(NOW_S - 14, NOW_S)})


@st.composite
def dags(draw: st.DrawFn) -> list[FunctionInfo]:
    """Functions that depend on nodes and on functions declared before them, shown in any order."""
    functions: list[FunctionInfo] = []
    for i in range(draw(st.integers(1, 9))):
        below = NODES + [one.name for one in functions]
        needs = draw(st.lists(st.sampled_from(below), max_size=4))
        functions.append(function(f"function-{i}", *needs, better=draw(st.lists(st.sampled_from(below), max_size=2))))
    return draw(st.permutations(functions))


@st.composite
def graphs(draw: st.DrawFn) -> list[FunctionInfo]:
    """Functions that depend on anything: themselves, each other, names that nothing has."""
    names = [f"function-{i}" for i in range(draw(st.integers(1, 7)))]
    anything = st.sampled_from([*NODES, *names, "nobody-knows"])
    return [function(one, *draw(st.lists(anything, max_size=4)), better=draw(st.lists(anything, max_size=2)))
            for one in draw(st.lists(st.sampled_from(names), max_size=9))]  # fmt: skip


conditions = st.fixed_dictionaries({name: st.sampled_from([*RIGHT, *WRONG]) for name in NODES})


def machine(functions: list[FunctionInfo], states: dict[str, dict[str, object]]) -> Robot:
    """Return a robot whose nodes are in these states."""
    return robot([node(name, **states[name]) for name in NODES], functions, [info(name) for name in NODES])


def reachable(functions: list[FunctionInfo], name: str) -> set[str]:
    """Return every name a function depends on in the end, by walking."""
    needs: dict[str, tuple[str, ...]] = {}
    for one in functions:
        needs.setdefault(one.name, one.depends_on)
    seen: set[str] = set()
    waiting = list(needs[name])
    while waiting:
        one_name = waiting.pop()
        if one_name not in seen:
            seen.add(one_name)
            waiting.extend(needs.get(one_name, ()))
    return seen


def off(found: Robot) -> set[str]:
    """Return the names of the functions that are off."""
    return {name for name, one in evaluate(found, NOW_S).items() if one.ability is Ability.OFF}


@pytest.mark.slow
@given(dags(), conditions)
def test_exactly_the_functions_that_depend_on_what_is_missing_are_off(
    functions: list[FunctionInfo], states: dict[str, dict[str, object]]
) -> None:
    missing = {name for name in NODES if states[name] in WRONG}
    expected = {one.name for one in functions if reachable(functions, one.name) & missing}
    assert off(machine(functions, states)) == expected


@pytest.mark.slow
@given(dags(), conditions, st.sampled_from(NODES))
def test_stopping_a_node_turns_off_exactly_what_needs_it(
    functions: list[FunctionInfo], states: dict[str, dict[str, object]], name: str
) -> None:
    before, after = off(machine(functions, states)), off(machine(functions, {**states, name: {"state": "stopped"}}))
    needs_it = {one.name for one in functions if name in reachable(functions, one.name)}
    assert after == before | needs_it
    assert {one.name for one in needing(functions, name)} == needs_it


@given(graphs(), conditions)
def test_any_declaration_is_judged_and_never_breaks(
    functions: list[FunctionInfo], states: dict[str, dict[str, object]]
) -> None:
    own = {one.name for one in functions}
    named = {name for one in functions for name in one.depends_on}
    missing = {name for name in NODES if states[name] in WRONG} | (named - own - set(NODES))
    expected = {name for name in own if reachable(functions, name) & missing or _meets_a_circle(functions, name)}
    states_now = evaluate(machine(functions, states), NOW_S)
    assert {name for name, one in states_now.items() if one.ability is Ability.OFF} == expected
    for one in states_now.values():
        assert bool(one.why) == bool(one.turns_on) == (one.ability is not Ability.ON)


def _meets_a_circle(functions: list[FunctionInfo], name: str) -> bool:
    own = {one.name for one in functions}
    return any(one in reachable(functions, one) for one in {name, *reachable(functions, name)} & own)


@given(graphs())
def test_the_tree_shows_each_function_once_below_one_that_names_it(functions: list[FunctionInfo]) -> None:
    places = tree(functions)
    assert sorted(one.name for one in places) == sorted({one.name for one in functions})
    at = {one.name: number for number, one in enumerate(places)}
    depth = {one.name: one.depth for one in places}
    for one in places:
        if one.parent:
            assert at[one.parent] < at[one.name]
            assert one.depth == depth[one.parent] + 1
        else:
            assert one.depth == 0


def test_without_a_factsheet_nothing_is_claimed() -> None:
    assert evaluate(replace(r.RUNNING, factsheet=None), NOW_S) == {}
    assert evaluate(r.NEVER_HEARD, NOW_S) == {}


@pytest.mark.parametrize(
    ("change", "why", "turns_on"),
    [
        ({"stamp": Stamp(NOW_S - 41, NOW_S - 41)}, "Rear camera lost", "Restart Rear camera"),
        ({"state": "stopped"}, "Rear camera stopped", "Start Rear camera"),
        ({"state": "failure", "text": "No picture."}, "Rear camera failed", "Restart Rear camera"),
        ({"rate_hz": 2.0}, "Rear camera runs at 2 Hz, usual 10 Hz", SLOW),
        ({"state": "starting"}, "Rear camera is starting", "Wait until Rear camera has started"),
    ],
)
def test_it_says_why_and_what_turns_it_on(change: dict[str, object], why: str, turns_on: str) -> None:
    found = robot([node("cam", **change)], [function("back-up", "cam")], [info("cam", "Rear camera")])
    state = evaluate(found, NOW_S)["back-up"]
    assert (state.ability, state.why, state.turns_on) == (Ability.OFF, why, turns_on)


def test_a_function_names_the_root_of_what_is_missing_and_counts_the_rest() -> None:
    functions = [function("plant", "path", "crane"), function("path", "gnss")]
    found = robot([node("gnss", "stopped"), node("crane", "failure")], functions)
    assert evaluate(found, NOW_S)["plant"].why == "crane failed, and 1 more"
    assert evaluate(found, NOW_S)["plant"].turns_on == "Restart crane; start gnss"


def test_what_only_betters_it_limits_it_and_holds_nothing_back() -> None:
    functions = [function("plant", "gnss", better=("cam",)), function("all", "plant")]
    states = evaluate(robot([node("gnss"), node("cam", "stopped")], functions), NOW_S)
    assert [one.ability for one in states.values()] == [Ability.LIMITED, Ability.ON]


def test_a_node_that_declares_a_longer_period_is_silent_only_after_three_of_them() -> None:
    slow = node("gnss", period_s=30.0, stamp=Stamp(NOW_S - 80, NOW_S - 80))
    assert off(robot([slow], [function("localise", "gnss")])) == set()
    assert off(robot([replace(slow, stamp=Stamp(NOW_S - 91, NOW_S - 91))], [function("localise", "gnss")])) != set()


def body(*, age_s: float = 0.0, **values: float) -> Body:
    """Return measured values; ``boom`` is a joint, everything else a gauge."""
    joints = {name: value for name, value in values.items() if name == "boom"}
    gauges = {name: value for name, value in values.items() if name != "boom"}
    return Body(joints, {}, gauges, None, None, None, (), Stamp(NOW_S - age_s, NOW_S - age_s))


@pytest.mark.parametrize(
    ("measured", "why", "turns_on"),
    [
        (body(load=97.0, boom=0.1), "Crane joint 3 at 97 %, limit 95 %", "Bring Crane joint 3 under 95 %"),
        (body(load=10.0, boom=1.2), "Boom at 69°, limit 57°", "Drive Boom under 57°, or retract it"),
        (body(load=10.0, boom=-0.6), "Boom at -34°, limit -29°", "Drive Boom above -29°, or retract it"),
        (body(boom=0.1), "Crane joint 3 is not known", WAIT),
        (body(age_s=3.0, load=1.0, boom=0.1), "Crane joint 3 is not known, and 1 more", WAIT),
        (body(load=float("nan"), boom=0.1), "Crane joint 3 is not known", WAIT),
        (body(load=10.0, boom=0.1), "", ""),
    ],
)
def test_functions_may_depend_on_what_the_machine_measures(measured: Body, why: str, turns_on: str) -> None:
    gauge = GaugeInfo("load", "Crane joint 3", "%", 0, 100, None, 95, "")
    boom = JointInfo("boom", "Boom", "rad", -1, 1.5, 0.3, -0.5, 1.0)
    found = robot([], [function("plant", "load", "boom")], gauges=(gauge,), joints=(boom,))
    state = evaluate(replace(found, body=measured), NOW_S)["plant"]
    assert (state.why, state.turns_on) == (why, turns_on)


FUNCTIONS = [
    function("plant", "follow-path", "crane", label="Plant trees"),
    function("follow-path", "gnss", label="Follow a path"),
    function("manual-drive", "drive", label="Drive by hand"),
    function("move-tool", "crane", label="Move the crane"),
]


def with_stopped(*names: str) -> Robot:
    """Return a planter of which these nodes are stopped."""
    nodes: list[Node] = [node(one, "stopped" if one in names else "started") for one in ("gnss", "crane", "drive")]
    return robot(nodes, FUNCTIONS)


@pytest.mark.parametrize(
    ("stopped", "off_actions"),
    [
        (set(), set()),
        ({"gnss"}, {Action.START, Action.RESUME, Action.RETURN_HOME, Action.GO_TO}),
        ({"crane"}, {Action.START, Action.RESUME, Action.TOOL_RETRACT, Action.TOOL_GO_TO}),
        ({"drive"}, {Action.DRIVE_OPEN}),
    ],
)
def test_an_order_is_off_with_the_function_it_uses(stopped: set[str], off_actions: set[Action]) -> None:
    found = with_stopped(*stopped)
    assert {action for action in Action if obstacle(found, action)} == off_actions
    assert bool(jog_obstacle(found)) == ("crane" in stopped)


def test_a_camera_takes_no_orders_while_its_node_is_stopped() -> None:
    functions = [function("take-pictures", "gnss", label="Take pictures")]
    assert camera_obstacle(robot([node("gnss", "started")], functions)) == ""
    assert camera_obstacle(robot([node("gnss", "stopped")], functions)).startswith("Take pictures is off: ")
    assert camera_obstacle(with_stopped("gnss")) == "", "it declares no such function"


def test_the_reason_names_the_function_the_cause_and_what_to_do() -> None:
    reason = obstacle(with_stopped("gnss"), Action.RETURN_HOME)
    assert reason == "Follow a path is off: gnss stopped. Start gnss on Supervisor."


def test_stopping_work_and_nodes_is_never_held_back() -> None:
    nothing = with_stopped("gnss", "crane", "drive")
    for action in (Action.PAUSE, Action.ABORT, Action.DRIVE_CLOSE, Action.NODE_RESTART, Action.NODE_START):
        assert obstacle(nothing, action) == ""


def test_a_robot_that_declares_no_functions_is_held_back_by_none() -> None:
    assert all(obstacle(robot([node("gnss", "failure")]), action) == "" for action in Action)


def test_a_robot_that_tells_nothing_of_its_nodes_decides_for_itself() -> None:
    mute = robot([], FUNCTIONS)
    assert all(obstacle(mute, action) == "" for action in Action)
    assert off(mute) == {"plant", "follow-path", "manual-drive", "move-tool"}
