"""Why a robot is not moving, in one sentence for its kind of machine: what clears it, who can, how long that takes."""

from __future__ import annotations

from typing import Any

from hmi.domain.robot import Family, Mode, OrderStatus, Robot
from hmi.presenters.actions import stands, why
from hmi.presenters.help_needed import hover_s
from hmi.presenters.units import milliseconds, percent, span_text
from hmi.presenters.words import has_mission

Sentence = dict[str, Any]

TAKES_S: dict[str, float] = {
    "stop_latched": 60.0,
    "paused": 10.0,
    "ready": 10.0,
    "stopped": 10.0,
    "not_registered": 60.0,
    "continued": 20.0,
    "moved_while_paused": 120.0,
    "rebooted": 20.0,
    "link_lost": 20.0,
    "operator_lost": 20.0,
    "after_stop": 10.0,
    "manual": 10.0,
}
"""How long clearing takes a person at the screen; what needs somebody at the machine is not guessed."""

_STANDS: dict[Family, str] = {
    Family.WEEDER: "Laser off, tracks brake.",
    Family.PLANTER: "Drive and crane stand, hydraulics hold.",
    Family.UAV: "It brakes and hovers.",
}
_MOVES_YET = "It does not say yet that it stands with its tool off."
_PAUSED: dict[Family, str] = {
    Family.PLANTER: "Planting is paused; the crane holds.",
    Family.UAV: "It holds its place in the air.",
}


def sentence(robot: Robot) -> Sentence | None:
    """Return ``why`` in the words of its family with ``takes_s``; ``None`` if it moves or has nothing to do.

    ``takes_s`` is how many seconds clearing it takes once somebody does, ``None`` where nobody can say.
    """
    found = why(robot) or _charging(robot)
    if found is None:
        return None
    code = found["code"]
    is_braking = code == "stop_latched" and not stands(robot)  # nobody resets it before it stands
    takes_s = None if is_braking else TAKES_S.get(code)
    return {**found, "text": _text(robot, code, found["text"]), "takes_s": takes_s}


def _text(robot: Robot, code: str, text: str) -> str:
    family = robot.factsheet.family if robot.factsheet is not None else Family.OTHER
    if code == "stop_latched":
        return f"{text} {_STANDS.get(family, '') if stands(robot) else _MOVES_YET}".rstrip()
    if code == "paused":
        words = _PAUSED.get(family, text)
        left_s = hover_s(robot)
        return words if left_s is None else f"{words} Battery for {span_text(left_s)} more."
    if code == "no_link" and family is Family.UAV and robot.state is not None and robot.state.mode is Mode.AUTO:
        return f"{text} It was in the air when last heard."
    return text


def _charging(robot: Robot) -> Sentence | None:
    """A robot that only charges has nothing wrong with it; the sentence says so and asks nobody."""
    battery = robot.telemetry.battery if robot.telemetry is not None else None
    if battery is None or not battery.is_charging or has_mission(robot, OrderStatus.RUNNING):
        return None
    since = milliseconds(robot.state.path_since_s) if robot.state is not None else None
    text = f"It charges, {percent(battery.soc)} %."
    return {"code": "charging", "text": text, "clears": "It is ready when charged.", "who": "nobody", "since": since}
