"""What a robot can do now: the tree of its functions, judged from its nodes and its measured values; pure.

A function is on only while everything it depends on is there. It is limited while something is missing that it would
be better with. What cannot be judged is off and says why; nothing here raises.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from enum import StrEnum

from hmi.domain.freshness import STALE_S
from hmi.domain.machine import FunctionInfo, GaugeInfo, JointInfo
from hmi.domain.node_health import NodeHealth, Trouble, judge
from hmi.domain.robot import Robot


class Ability(StrEnum):
    """Whether a function can be used."""

    ON = "on"
    LIMITED = "limited"
    OFF = "off"


@dataclass(frozen=True, slots=True)
class Cause:
    """One thing that is missing: why, without a full stop; what brings it back; since when; how bad it is by itself.

    ``level`` is the priority a person would see it at, ``None`` for what was switched off by somebody. ``is_node``: it
    is mended where nodes are started.
    """

    why: str
    cure: str
    since_s: float | None = None
    level: int | None = None
    is_node: bool = False


@dataclass(frozen=True, slots=True)
class FunctionState:
    """One function as judged now; ``causes`` are the roots of what is missing, none while it is on."""

    info: FunctionInfo
    ability: Ability
    causes: tuple[Cause, ...] = ()

    @property
    def why(self) -> str:
        """What is missing, without a full stop; empty while it is on."""
        if not self.causes:
            return ""
        more = len(self.causes) - 1
        return self.causes[0].why + (f", and {more} more" if more else "")

    @property
    def turns_on(self) -> str:
        """What brings it back, without a full stop; empty while it is on."""
        cures = list(dict.fromkeys(one.cure for one in self.causes))
        return "; ".join([*cures[:1], *(in_sentence(one) for one in cures[1:])])

    @property
    def since_s(self) -> float | None:
        """Since when the first cause holds, if that is known."""
        return self.causes[0].since_s if self.causes else None


@dataclass(frozen=True, slots=True)
class Place:
    """Where a function stands in the tree: below ``parent``, the first one that names it."""

    name: str
    depth: int
    parent: str


def evaluate(robot: Robot, now_s: float) -> dict[str, FunctionState]:
    """Return every declared function by name, in the robot's order; empty without a factsheet."""
    if robot.factsheet is None:
        return {}
    infos: dict[str, FunctionInfo] = {}
    for info in robot.factsheet.functions:
        infos.setdefault(info.name, info)
    things = _Things(robot, now_s, infos)
    missing = _missing(infos, things)
    return {name: _state(info, missing, things) for name, info in infos.items()}


def tree(infos: Iterable[FunctionInfo]) -> list[Place]:
    """Return all functions in reading order: each below the first one that names it; cycles are cut."""
    known: dict[str, FunctionInfo] = {}
    for one in infos:
        known.setdefault(one.name, one)
    named = {part for one in known.values() for part in _parts(one) if part != one.name}
    placed: dict[str, Place] = {}
    for root in [*(name for name in known if name not in named), *known]:
        stack = [Place(root, 0, "")]
        while stack:
            place = stack.pop()
            if place.name in placed:
                continue
            placed[place.name] = place
            below = [part for part in _parts(known[place.name]) if part in known]
            stack.extend(Place(part, place.depth + 1, place.name) for part in reversed(below))
    return list(placed.values())


def needing(infos: Iterable[FunctionInfo], name: str) -> list[FunctionInfo]:
    """Return the functions that go off with a node or function, itself not counted, in the robot's order."""
    known = list(infos)
    lost, grew = {name}, True
    while grew:
        more = {one.name for one in known if lost & set(one.depends_on)}
        grew = not more <= lost
        lost |= more
    return [one for one in known if one.name in lost and one.name != name]


def in_sentence(text: str) -> str:
    """Return words as they stand inside a sentence; names that begin with capitals stay."""
    return text[:1].lower() + text[1:] if text[1:2].islower() else text


class _Things:
    """What functions depend on besides each other: nodes, gauges, joints."""

    def __init__(self, robot: Robot, now_s: float, functions: Mapping[str, FunctionInfo]) -> None:
        self._nodes, self._functions = judge(robot, now_s), functions
        sheet, body = robot.factsheet, robot.body
        self._gauges = {one.key: one for one in sheet.gauges} if sheet is not None else {}
        self._joints = {one.name: one for one in sheet.joints} if sheet is not None else {}
        is_fresh = body is not None and now_s - body.stamp.source_s <= STALE_S
        self._measured = {**body.joints, **body.gauges} if body is not None and is_fresh else {}

    def is_function(self, name: str) -> bool:
        """Say whether a name stands for a function; a node of the same name comes first."""
        return name in self._functions and name not in self._nodes

    def cause(self, name: str) -> Cause | None:
        """Return why something that is no function is not there, ``None`` if it is."""
        if name in self._nodes:
            return _of_node(self._nodes[name])
        if name in self._gauges:
            return _of_gauge(self._gauges[name], self._measured.get(name))
        if name in self._joints:
            return _of_joint(self._joints[name], self._measured.get(name))
        return Cause(f"It needs {name}, which the robot does not have", f"Add {name} to the robot", level=3)


def _missing(infos: Mapping[str, FunctionInfo], things: _Things) -> dict[str, tuple[Cause, ...]]:
    """Return for each function the roots of what it depends on and is not there."""
    missing: dict[str, tuple[Cause, ...]] = {}
    waiting = dict(infos)
    while waiting:
        ready = [one for one in waiting.values() if not _waits(one, waiting, things)]
        for one in ready:
            missing[one.name] = _unique(_causes(one.depends_on, missing, things))
            del waiting[one.name]
        if not ready:
            missing.update(_in_circles(waiting, missing, things))
            break
    return missing


def _waits(info: FunctionInfo, waiting: Mapping[str, FunctionInfo], things: _Things) -> bool:
    return any(name in waiting and things.is_function(name) for name in info.depends_on)


def _in_circles(
    waiting: Mapping[str, FunctionInfo], missing: Mapping[str, tuple[Cause, ...]], things: _Things
) -> dict[str, tuple[Cause, ...]]:
    """Return causes for functions that need each other in a circle, or need one that does."""
    circle = Cause("It is declared to need itself", "Correct the robot's own description", level=3)
    return {
        one.name: _unique([circle, *_causes((n for n in one.depends_on if n not in waiting), missing, things)])
        for one in waiting.values()
    }


def _causes(names: Iterable[str], missing: Mapping[str, tuple[Cause, ...]], things: _Things) -> Iterator[Cause]:
    for name in names:
        if things.is_function(name):
            yield from missing.get(name, ())
        elif (cause := things.cause(name)) is not None:
            yield cause


def _state(info: FunctionInfo, missing: Mapping[str, tuple[Cause, ...]], things: _Things) -> FunctionState:
    if missing[info.name]:
        return FunctionState(info, Ability.OFF, missing[info.name])
    lacks = _unique(_causes(info.better_with, missing, things))
    return FunctionState(info, Ability.LIMITED if lacks else Ability.ON, lacks)


def _unique(causes: Iterable[Cause]) -> tuple[Cause, ...]:
    """Worst first, so that the sentence names a failure before what somebody switched off."""
    return tuple(sorted(dict.fromkeys(causes), key=lambda one: one.level or 9))


def _of_node(health: NodeHealth) -> Cause | None:
    if health.is_there:
        return None
    level = 2 if health.has(Trouble.FAILED) or health.has(Trouble.SILENT) else 3 if health.has(Trouble.SLOW) else None
    return Cause(health.absent, health.cure, health.since_s, level, is_node=True)


def _of_gauge(gauge: GaugeInfo, value: float | None) -> Cause | None:
    if value is None or not math.isfinite(value):
        return Cause(f"{gauge.label} is not known", "Wait for fresh values of the machine")
    low, high = gauge.ok_lower, gauge.ok_upper
    if low is not None and value < low:
        limit, cure = low, f"Bring {gauge.label} above {low:g} {gauge.unit}"
    elif high is not None and value > high:
        limit, cure = high, f"Bring {gauge.label} under {high:g} {gauge.unit}"
    else:
        return None
    why = f"{gauge.label} at {value:.3g} {gauge.unit}, limit {limit:g} {gauge.unit}"
    return Cause(why, cure, level=2)


def _of_joint(joint: JointInfo, value: float | None) -> Cause | None:
    if value is None or not math.isfinite(value):
        return Cause(f"{joint.label} is not known", "Wait for fresh values of the machine")
    low, high = joint.soft_lower, joint.soft_upper
    if low is not None and value < low:
        limit, way = low, "above"
    elif high is not None and value > high:
        limit, way = high, "under"
    else:
        return None
    why = f"{joint.label} at {_length(joint, value)}, limit {_length(joint, limit)}"
    return Cause(why, f"Drive {joint.label} {way} {_length(joint, limit)}, or retract it", level=2)


def _length(joint: JointInfo, value: float) -> str:
    return f"{math.degrees(value):.0f}°" if joint.unit == "rad" else f"{value:.2f} m"


def _parts(info: FunctionInfo) -> tuple[str, ...]:
    return (*info.depends_on, *info.better_with)
