"""The UAV's supervisor as a chart: its way, its camera, and its link, side by side while it flies a mission."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from backend_clients.edge.machine import Chart, ChartState, ChartTransition
from backend_clients.simulator.top_chart import top_of, top_states, top_transitions
from backend_clients.simulator.weeder_chart import place_of

if TYPE_CHECKING:
    from backend_clients.simulator.brain import Brain

_WAY = {"approach": "fly-there", "row": "line", "turn": "turn", "headland": "line", "exit": "leave"}


def _state(state: str, label: str, parent: str, subsystem: str = "", **more: object) -> ChartState:
    return ChartState(id=state, label=label, parent=parent, subsystem=subsystem, **more)  # type: ignore[arg-type]


def _both(one: str, other: str, there: str, back: str) -> list[ChartTransition]:
    return [
        ChartTransition(source=one, target=other, event=there),
        ChartTransition(source=other, target=one, event=back),
    ]


CHART = Chart(
    states=[
        *top_states(),
        _state("take-off", "Set off", "mission", "Drive", is_initial=True, normal_s=3.0, entry=["horn 3 s"]),
        _state("search", "Search", "mission", kind="parallel"),
        _state("wait", "Hover and wait", "mission", "Waiting", entry=["brake", "hover"]),
        _state("end", "End", "mission", "Operator", entry=["camera off", "report the mission"]),
        _state("way", "Way", "search", kind="region"),
        _state("fly-there", "Fly there", "way", "Drive", is_initial=True),
        _state("line", "Search line", "way", "Drive"),
        _state("turn", "Turn", "way", "Drive"),
        _state("leave", "Leave", "way", "Drive"),
        _state("camera", "Camera", "search", kind="region"),
        _state("camera-off", "Camera off", "camera", "Camera", is_initial=True),
        _state("camera-on", "Searching", "camera", "Camera", entry=["take pictures"]),
        _state("link", "Link", "search", kind="region"),
        _state("farm-heard", "Farm heard", "link", "Link", is_initial=True),
        _state("farm-silent", "Farm silent", "link", "Link", entry=["finish the minimum of the mission"]),
    ],
    transitions=[
        *top_transitions(),
        ChartTransition(source="take-off", target="search", event="horn sounded"),
        ChartTransition(source="search", target="end", event="last point"),
        *_both("search", "wait", "must wait", "settled"),
        *_both("take-off", "wait", "must wait", "settled"),
        ChartTransition(source="search", target="take-off", event="horn again"),
        *(
            ChartTransition(source=a, target=b, event=f"{b} begins")
            for a in ("fly-there", "line", "turn", "leave")
            for b in ("fly-there", "line", "turn", "leave")
            if a != b
        ),
        *_both("camera-off", "camera-on", "line begins", "line ends"),
        *_both("farm-heard", "farm-silent", "nothing heard for 3 s", "heard"),
    ],
)


def leaves(brain: Brain, before: frozenset[str]) -> Sequence[str]:
    """Return the innermost active states of a UAV."""
    top = top_of(brain)
    if top != "mission":
        is_done = brain.run is not None and brain.run.status == "done" and "mission" in before
        return ("end",) if top == "idle" and is_done and "end" not in before else (top,)
    if brain.hold_code in ("start_horn", "climbing") or (brain.pilot.followed is None and "take-off" in before):
        return ("take-off",)
    if brain.hold_code:
        return ("wait",)
    camera = "camera-on" if brain.machine.tool_on else "camera-off"
    return (_WAY[place_of(brain)], camera, "farm-heard" if brain.is_farm_heard else "farm-silent")
