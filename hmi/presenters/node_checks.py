"""Guided checks of the robot's software: its nodes, their rates, clocks and order, and what is off because of them."""

from __future__ import annotations

from hmi.domain.functions import Ability, evaluate
from hmi.domain.node_health import NodeHealth, Trouble, judge
from hmi.presenters.scene import Look, Scene, unknown
from hmi.presenters.units import number

BUSY_PCT = 80.0


def alive(scene: Scene) -> Look:
    """Look for nodes that failed."""
    means = "A part of its software failed. Restart it, or the robot's computer."
    failed = [one.label for one in _healths(scene) if one.has(Trouble.FAILED)]
    return _look(scene, "Do all parts of its software run?", "Failed", failed, "run", means)


def heard(scene: Scene) -> Look:
    """Look for nodes whose reports are missing."""
    means = "The robot's watchdog does not report it any more: restart the node, or the robot's computer."
    silent = [one.label for one in _healths(scene) if one.has(Trouble.SILENT)]
    return _look(scene, "Are all its nodes heard?", "Silent", silent, "are heard", means)


def rate(scene: Scene) -> Look:
    """Look for nodes below half their rate."""
    means = "A node is too slow: look at the load of its computer, then restart it."
    slow = [one.absent for one in _healths(scene) if one.has(Trouble.SLOW)]
    return _look(scene, "Do all nodes keep their rate?", "Slow", slow, "do", means)


def load(scene: Scene) -> Look:
    """Look for the node that takes most of its computer."""
    text = "What takes the computer's time?"
    loads = [(one.node.cpu_pct, one.label) for one in _healths(scene) if one.node and one.node.cpu_pct is not None]
    if not loads:
        return unknown(text)
    most, label = max(loads)
    means = f"{label} takes nearly all of its computer. Restart it, or work without it."
    return Look(text, f"{label} with {number(most)} %.", most < BUSY_PCT, means)


def clocks(scene: Scene) -> Look:
    """Look for nodes whose clock is off."""
    off = [one.label for one in _healths(scene) if one.has(Trouble.CLOCK)]
    means = "Set up the time service on the computer of that node."
    return _look(scene, "Do the clocks of all nodes agree?", "Off", off, "agree", means)


def order(scene: Scene) -> Look:
    """Look for nodes that were started too early."""
    early = [(one.label, o.text) for one in _healths(scene) for o in one.findings if o.trouble is Trouble.ORDER]
    means = early[0][1] if early else ""
    names = list(dict.fromkeys(label for label, _ in early))
    return _look(scene, "Were all nodes started in their order?", "Early", names, "were", means)


def restarts(scene: Scene) -> Look:
    """Look for nodes that came back by themselves."""
    again = [f"{one.label} {one.node.restarts}" for one in _healths(scene) if one.node and one.node.restarts]
    means = "It fails again and again. Read its log under Supervisor before you restart it once more."
    return _look(scene, "Was a node restarted?", "Restarts", again, "run since they were started", means)


def functions(scene: Scene) -> Look:
    """Look for functions that are off."""
    text = "What is off because of it?"
    robot = scene.robot
    if robot is None or robot.factsheet is None or not robot.factsheet.functions or not robot.nodes:
        return unknown(text)
    states = evaluate(robot, scene.now_s).values()
    off = [one.info.label for one in states if one.ability is Ability.OFF]
    return Look(text, f"{', '.join(off)}." if off else "Nothing that it names.", not off)


def _healths(scene: Scene) -> list[NodeHealth]:
    return list(judge(scene.robot, scene.now_s).values()) if scene.robot is not None and scene.robot.nodes else []


def _look(scene: Scene, text: str, head: str, bad: list[str], good: str, means: str) -> Look:
    known = len(_healths(scene))
    if not known:
        return unknown(text)
    return Look(text, f"{head}: {', '.join(bad)}." if bad else f"All {known} {good}.", not bad, means)
