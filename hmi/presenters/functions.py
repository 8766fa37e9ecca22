"""What the robot can do now, and why not, as the live lane and REST carry it; pure."""

from __future__ import annotations

from typing import Any

from hmi.domain.functions import Ability, FunctionState, Place, evaluate, in_sentence, tree
from hmi.domain.robot import Robot
from hmi.presenters.units import milliseconds


def present(robot: Robot, now_s: float) -> dict[str, Any] | None:
    """Return the group ``functions`` of topic ``inside``; ``None`` while nothing is known.

    Functions come in reading order, each below the first one that names it. ``since`` is when the reason began.
    """
    states = evaluate(robot, now_s)
    if not states or robot.factsheet is None:
        return None
    places = [place for place in tree(robot.factsheet.functions) if place.name in states]
    return {
        "functions": [_function(states[place.name], place) for place in places],
        "on": sum(one.ability is Ability.ON for one in states.values()),
        "total": len(states),
        "hint": _hint([states[place.name] for place in places]),
    }


def _function(state: FunctionState, place: Place) -> dict[str, Any]:
    info = state.info
    return {
        "name": info.name,
        "label": info.label,
        "state": state.ability.value,
        "why": state.why,
        "turns_on": state.turns_on,
        "since": milliseconds(state.since_s),
        "level": min((one.level for one in state.causes if one.level is not None), default=None),
        "depends_on": list(info.depends_on),
        "better_with": list(info.better_with),
        "depth": place.depth,
        "parent": place.parent,
    }


def _hint(states: list[FunctionState]) -> str:
    """Say what turns on the first function that is off, or frees the first that is limited."""
    for ability, doing in ((Ability.OFF, "turn on"), (Ability.LIMITED, "have all of")):
        for one in states:
            if one.ability is ability:
                return f"To {doing} {one.info.label}: {in_sentence(one.turns_on)}."
    return ""
