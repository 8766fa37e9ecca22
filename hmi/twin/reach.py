"""How far an arm reaches near the ground: found once for a model, drawn as an arc around what it turns on."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import viser

from backend_clients.edge.machine import Joint
from hmi.twin.machine import Form
from hmi.twin.model import ModelJoint
from hmi.twin.rotation import turned

LOW_M, HIGH_M = -0.2, 1.7  # of the tip above the ground: what an arm works at
POSTURES = 1000  # tried at most: a tenth of a second, once for a model
MOST_MOVERS = 4  # with more joints so few postures would say too little
NEGLIGIBLE_M = 0.01
INK = (70, 84, 92)
STEP_RAD = math.radians(4)


@dataclass(frozen=True, slots=True)
class Reach:
    """Metres and radians in the frame of the body: an arc of ``radius_m`` around a place, from one end to the other."""

    x_m: float
    y_m: float
    radius_m: float
    from_rad: float
    to_rad: float


def reach_of(form: Form, joints: list[Joint]) -> Reach | None:
    """Return how far the tip comes within the soft limits; ``None`` where that cannot be said."""
    soft = {one.name: one for one in joints}
    chain = [joint for joint in _chain(form) if joint.moves and joint.name in soft]
    if not chain or chain[0].kind == "prismatic" or abs(chain[0].axis[2]) < 0.9:
        return None
    slew, *others = chain
    rest = {joint.name: _nearest(0.0, _span(joint, soft)) for joint in chain}
    middle = form.kinematics.in_base(rest)[slew.child].xyz
    movers = [joint for joint in others if _moves_tip(form, rest, joint, _span(joint, soft))]
    if len(movers) > MOST_MOVERS:
        return None
    count = max(2, int(POSTURES ** (1 / max(1, len(movers)))))
    best = 0.0
    for values in itertools.product(*(np.linspace(*_span(joint, soft), count) for joint in movers)):
        posture = {**rest, **{joint.name: float(value) for joint, value in zip(movers, values, strict=True)}}
        x, y, z = form.kinematics.in_base(posture)[form.tip].xyz
        if LOW_M <= z <= HIGH_M:
            best = max(best, math.dist((x, y), middle[:2]))
    if best < NEGLIGIBLE_M:
        return None
    ahead = _bearing(form, {**rest, slew.name: 0.0}, middle[:2])
    lower, upper = _span(slew, soft)
    return Reach(middle[0], middle[1], best, ahead + lower, ahead + upper)


def draw_reach(scene: viser.SceneApi, name: str, reach: Reach | None) -> None:
    """Draw the arc below a frame that stands with the body, or replace it; nothing for ``None``."""
    if reach is None:
        scene.remove_by_name(name)
        return
    steps = max(8, math.ceil(min(reach.to_rad - reach.from_rad, 2 * math.pi) / STEP_RAD))
    angles = np.linspace(reach.from_rad, min(reach.to_rad, reach.from_rad + 2 * math.pi), steps + 1)
    xs, ys = reach.x_m + reach.radius_m * np.cos(angles), reach.y_m + reach.radius_m * np.sin(angles)
    arc = np.column_stack([xs, ys, np.full(len(angles), 0.02)]).astype(np.float32)
    lines = np.stack([arc[:-1], arc[1:]], axis=1)
    scene.add_line_segments(f"{name}/arc", lines, colors=INK, thickness=2.0, thickness_units="screen")
    x, y, z = (float(one) for one in arc[len(arc) // 4])
    scene.add_label(f"{name}/text", f"Reach {reach.radius_m:.1f} m", position=(x, y, z))


def _chain(form: Form) -> list[ModelJoint]:
    by_child = {joint.child: joint for joint in form.model.joints}
    chain, link = [], form.tip
    while link in by_child:
        chain.append(by_child[link])
        link = by_child[link].parent
    return chain[::-1]


def _span(joint: ModelJoint, soft: Mapping[str, Joint]) -> tuple[float, float]:
    known = soft[joint.name]
    lower = known.lower if known.soft_lower is None else known.soft_lower
    upper = known.upper if known.soft_upper is None else known.soft_upper
    return lower, upper


def _nearest(value: float, span: tuple[float, float]) -> float:
    return min(max(value, span[0]), span[1])


def _moves_tip(form: Form, rest: Mapping[str, float], joint: ModelJoint, span: tuple[float, float]) -> bool:
    ends = [form.kinematics.in_base({**rest, joint.name: value})[form.tip].xyz for value in span]
    return math.dist(*ends) > NEGLIGIBLE_M


def _bearing(form: Form, posture: Mapping[str, float], middle: tuple[float, float]) -> float:
    """Where the arm points with its slew at zero: along its tip, or ahead if the tip stands over the middle."""
    places = form.kinematics.in_base(posture)
    x, y, _ = places[form.tip].xyz
    if math.dist((x, y), middle) > NEGLIGIBLE_M:
        return math.atan2(y - middle[1], x - middle[0])
    x, y, _ = turned(places[form.tip].wxyz, (1.0, 0.0, 0.0))
    return math.atan2(y, x)
