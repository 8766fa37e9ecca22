"""A robot's state chart, what is active in it, and its newest change of state, as REST and the live lane carry them."""

from __future__ import annotations

import hashlib
import json
from typing import Any

from hmi.domain.robot import Robot
from hmi.domain.state_chart import Chart, ChartState, ChartTransition
from hmi.presenters.units import milliseconds


def chart(declared: Chart) -> dict[str, Any]:
    """Return the whole chart; ``hash`` names its content, so that a drawing of it can be kept."""
    shown = {
        "states": [_state(one) for one in declared.states],
        "transitions": [_transition(one) for one in declared.transitions],
    }
    content = json.dumps(shown, sort_keys=True).encode()
    return {"hash": hashlib.sha256(content).hexdigest()[:16], **shown}


def active(robot: Robot) -> dict[str, Any] | None:
    """Return which states are active since when, and the newest change; ``None`` before the first state."""
    state = robot.state
    if state is None:
        return None
    last = state.last_transition
    return {
        "t": milliseconds(state.stamp.source_s),
        "states": [[one.id, milliseconds(one.since_s)] for one in state.active],
        "last": None
        if last is None
        else {
            "source": last.source,
            "target": last.target,
            "event": last.event,
            "result": last.result,
            "at": milliseconds(last.at_s),
        },
    }


def chart_name(robot: Robot) -> dict[str, Any] | None:
    """Return which chart the robot has, by its hash; ``None`` without one."""
    declared = robot.factsheet.chart if robot.factsheet else None
    return None if declared is None else {"hash": chart(declared)["hash"]}


def _state(one: ChartState) -> dict[str, Any]:
    return {
        "id": one.id,
        "label": one.label,
        "parent": one.parent,
        "kind": one.kind,
        "is_initial": one.is_initial,
        "subsystem": one.subsystem,
        "normal_s": one.normal_s,
        "entry": list(one.entry),
        "exit": list(one.exit),
    }


def _transition(one: ChartTransition) -> dict[str, Any]:
    return {"source": one.source, "target": one.target, "event": one.event, "guard": one.guard}
