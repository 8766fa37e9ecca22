"""The weeder's supervisor as a chart: its published sequence A0 to A6, where it is, its laser, who is near.

A0 select and start, A1 perceive, A2 decide, A3 command, A4 forward, A5 treat, A6 end; A1 to A5 repeat. The laser goes
on when it enters the rows and off in the turns.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from backend_clients.edge.machine import Chart, ChartState, ChartTransition
from backend_clients.simulator.top_chart import top_of, top_states, top_transitions

if TYPE_CHECKING:
    from backend_clients.simulator.brain import Brain

FIND_ROW_M = 1.0  # so far before a row its cameras look for the plants
PERSON_CODES = ("person_ahead", "tool_interlock", "weed_unsure")


def _state(state: str, label: str, parent: str, subsystem: str = "", **more: object) -> ChartState:
    return ChartState(id=state, label=label, parent=parent, subsystem=subsystem, **more)  # type: ignore[arg-type]


def _both(one: str, other: str, there: str, back: str) -> list[ChartTransition]:
    return [
        ChartTransition(source=one, target=other, event=there),
        ChartTransition(source=other, target=one, event=back),
    ]


PLACES = ("approach", "row", "turn", "headland", "exit")
CHART = Chart(
    states=[
        *top_states(),
        _state(
            "select", "A0 Select and start", "mission", "Operator", is_initial=True, normal_s=3.0, entry=["horn 3 s"]
        ),
        _state("treat-field", "Treat the field", "mission", kind="parallel"),
        _state("wait-person", "Wait for a person", "mission", "Waiting", entry=["brake", "laser off"]),
        _state("wait", "Wait", "mission", "Waiting", entry=["brake", "laser off"]),
        _state("end", "A6 End", "mission", "Operator", entry=["laser off", "report the mission"]),
        _state("sequence", "Sequence", "treat-field", kind="region"),
        _state("perceive", "A1 Perceive", "sequence", "Perception", is_initial=True, entry=["look for the row"]),
        _state("decide", "A2 Decide", "sequence", "Perception", entry=["tell crop and weeds apart"]),
        _state("command", "A3 Command", "sequence", "Laser", entry=["set speed and dose"]),
        _state("forward", "A4 Forward", "sequence", "Drive"),
        _state("treat", "A5 Treat", "sequence", "Laser", entry=["laser on"], exit=["laser off"]),
        _state("place", "Place", "treat-field", kind="region"),
        _state("approach", "Approach", "place", "Drive", is_initial=True),
        _state("row", "Row", "place", "Drive"),
        _state("turn", "Headland turn", "place", "Drive"),
        _state("headland", "Headland pass", "place", "Drive"),
        _state("exit", "Exit", "place", "Drive"),
        _state("laser", "Laser", "treat-field", kind="region"),
        _state("laser-off", "Laser off", "laser", "Laser", is_initial=True),
        _state("laser-on", "Laser firing", "laser", "Laser"),
    ],
    transitions=[
        *top_transitions(),
        ChartTransition(source="select", target="treat-field", event="horn sounded"),
        ChartTransition(source="treat-field", target="end", event="last point"),
        *_both("treat-field", "wait-person", "person needed", "settled"),
        *_both("treat-field", "wait", "must wait", "settled"),
        ChartTransition(source="wait-person", target="select", event="settled"),
        ChartTransition(source="wait", target="select", event="settled"),
        *_both("wait", "wait-person", "person needed", "must wait"),
        *_both("select", "wait-person", "person needed", "settled"),
        *_both("select", "wait", "must wait", "settled"),
        ChartTransition(source="treat-field", target="select", event="horn again"),
        ChartTransition(source="perceive", target="decide", event="plants seen"),
        ChartTransition(source="decide", target="command", event="decided"),
        ChartTransition(source="command", target="forward", event="set"),
        *_both("forward", "treat", "in the row", "row left"),
        ChartTransition(source="forward", target="perceive", event="row ahead"),
        ChartTransition(source="perceive", target="forward", event="no row"),
        *(
            ChartTransition(source=a, target=b, event=f"{b} begins")
            for a in PLACES
            for b in PLACES
            if a != b and (a != "exit" or b == "approach")
        ),
        *_both("laser-off", "laser-on", "laser on", "laser off"),
    ],
)


def leaves(brain: Brain, before: frozenset[str]) -> Sequence[str]:
    """Return the innermost active states of a weeder."""
    top = top_of(brain)
    if top != "mission":
        # the end is worth a moment of its own
        return ("end",) if top == "idle" and _has_just_ended(brain, before) else (top,)
    if brain.hold_code:
        if brain.hold_code == "start_horn":
            return ("select",)
        return ("wait-person" if brain.hold_code in PERSON_CODES else "wait",)
    if brain.pilot.followed is None and "select" in before:
        return ("select",)
    tool = "laser-on" if brain.machine.tool_on else "laser-off"
    return (_sequence(brain, before), place_of(brain), tool)


def place_of(brain: Brain) -> str:
    """Return on which kind of path a robot with a running mission is."""
    if brain.is_on_lead or brain.run is None:
        return "approach"
    return brain.run.leg.kind


def is_row_near(brain: Brain) -> bool:
    """Say whether the next row begins within a metre."""
    run = brain.run
    if run is None or brain.is_on_lead or run.leg.kind == "row":
        return False
    after = run.route.next_leg(run.leg)
    return after is not None and after.kind == "row" and run.leg.end_m - run.tracker.s_m < FIND_ROW_M


_NEXT = {"perceive": "decide", "decide": "command", "command": "forward", "treat": "forward"}


def _sequence(brain: Brain, before: frozenset[str]) -> str:
    """Return the step of A1 to A5; from one to the next it takes one control step each."""
    now = next((one for one in ("perceive", "decide", "command", "forward", "treat") if one in before), "forward")
    if is_row_near(brain):
        return "perceive" if now in ("perceive", "forward") else "forward"
    if brain.machine.tool_on:
        return "treat" if now in ("forward", "treat") else _NEXT[now]
    if now == "perceive" and brain.run is not None and brain.run.leg.kind != "row":
        return "forward"
    return _NEXT.get(now, "forward")


def _has_just_ended(brain: Brain, before: frozenset[str]) -> bool:
    return brain.run is not None and brain.run.status == "done" and "mission" in before and "end" not in before
