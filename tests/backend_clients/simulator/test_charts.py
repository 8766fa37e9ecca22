"""What a robot says of its supervisor is always a legal configuration of the chart it declares."""

from __future__ import annotations

import random

import pytest

from backend_clients.edge.machine import Chart, ChartState
from backend_clients.simulator import faults
from backend_clients.simulator.chart_tree import ChartTree
from tests.backend_clients.simulator.rig import Rig, small_mission

FAMILIES = ("weeder", "planter", "uav")
FAULTS = {
    "weeder": [faults.PersonAhead(distance_m=2.0), faults.RtkFloat(), faults.WeedUnsure(), faults.ToolInterlock()],
    "planter": [faults.PersonAhead(distance_m=2.0), faults.PersonAhead(distance_m=9.0), faults.CraneLimit(),
                faults.TrayEmpty(), faults.RtkFloat(), faults.NodeFailure(node="crane")],
    "uav": [faults.ToolInterlock(), faults.Silence(deaf=True), faults.LowBattery(soc=0.0)],
}  # fmt: skip


def check(rig: Rig, tree: ChartTree) -> None:
    """Assert that what the robot says now is possible."""
    state = rig.state
    ids = [one.id for one in state.active]
    assert tree.is_legal(ids), ids
    depths = [len(tree.lineages[one]) for one in ids]
    assert depths == sorted(depths), "outer states come first"
    assert all(one.since_ms <= state.mono_ms for one in state.active)
    last = state.last_transition
    if last is not None:
        declared = {(move.source, move.target, move.event) for move in tree.chart.transitions}
        assert (last.source, last.target, last.event) in declared


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("seed", [1, 2])
def test_active_states_are_legal_whatever_happens(family: str, seed: int) -> None:
    rng = random.Random(f"{family}/{seed}")
    rig = Rig(family=family)
    chart = rig.boot.reporter.factsheet().chart
    assert chart is not None
    tree, mission = ChartTree(chart), small_mission(length_m=14.0, width_m=4.0)
    seen: set[str] = set()
    rig.start(mission)
    for step in range(160):
        match rng.randrange(24):
            case 0:
                rig.stop(f"stop-{step:06d}")
            case 1 | 2 | 3:
                rig.reset(*[press.stop_id for press in rig.safety.presses] or ["stop-000000"])
            case 4 | 5 | 6 | 7:
                rig.do("resume")
            case 8:
                rig.do(rng.choice(["pause", "abort", "return_home", "drive_open", "drive_close"]))
            case 9:
                rig.robot.set_fault(rng.choice(FAULTS[family]))
            case 10 | 11:
                rig.robot.clear_fault()
            case 12 | 13:
                rig.start(mission)
        for _ in range(8):
            rig.run(0.25)
            check(rig, tree)
            seen.update(one.id for one in rig.state.active)
    assert {"mission", "stopped", "paused"} <= seen


@pytest.mark.parametrize("family", FAMILIES)
def test_each_state_that_is_left_was_entered_and_says_how_long_it_was(family: str) -> None:
    rig = Rig(family=family)
    rig.start(small_mission(length_m=12.0, width_m=4.0))
    rig.run(120.0)
    inside: dict[str, int] = {"start-up": 0}
    for event in rig.events:
        if event.kind == "state_entered":
            assert event.data["state"] not in inside
            inside[event.data["state"]] = event.mono_ms
        elif event.kind == "state_left":
            assert event.data["duration_ms"] == event.mono_ms - inside.pop(event.data["state"])
    assert set(inside) == {one.id for one in rig.state.active}


def test_a_weeder_goes_through_its_sequence_and_fires_in_rows_only() -> None:
    rig = Rig()
    rig.start(small_mission(rows=2))
    rig.run(60.0)
    entered = [e.data["state"] for e in rig.events if e.kind == "state_entered"]
    sequence = [one for one in entered if one in ("select", "perceive", "decide", "command", "forward", "treat", "end")]
    once = ["perceive", "decide", "command", "forward", "treat", "forward"]
    assert sequence == ["select", "forward", *once, *once[:-1], "end"]
    place, fires = "", set()
    for one in entered:
        place = one if one in ("approach", "row", "turn", "headland", "exit") else place
        if one == "laser-on":
            fires.add(place)
    assert fires == {"row"}


def test_lean_robots_have_no_chart_and_tell_their_path_in_words() -> None:
    rig = Rig(is_lean=True)
    assert rig.boot.reporter.factsheet().chart is None
    rig.start()
    rig.run(5.0)
    assert rig.state.active == []
    assert any(e.kind == "state_entered" and e.name == "Mission > Start > Horn" for e in rig.events)


def test_a_chart_with_a_missing_parent_is_refused() -> None:
    with pytest.raises(ValueError, match="not there"):
        ChartTree(Chart(states=[ChartState(id="a", label="A", parent="b")]))
