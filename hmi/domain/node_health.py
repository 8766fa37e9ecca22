"""Is each software node of a robot there, and what is wrong with it; pure.

Times are seconds of the console's monotonic clock.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from hmi.domain.machine import NodeInfo
from hmi.domain.robot import Node, Robot

SILENT_PERIODS = 3.0  # docs/safety.md: a slow stream is stale after three of its periods
SLOW_SHARE = 0.5  # below half its usual rate a node is no help
CLOCK_LIMIT_S = 0.05  # at 1 m/s a measurement is then 5 cm from where it belongs
ORDER_MARGIN_S = 0.2  # nodes started together, told in two messages
RESTARTED_S = 600.0  # a node that came back by itself longer ago is steady again


class Trouble(StrEnum):
    """What can be wrong with a node, the worst first."""

    FAILED = "failed"
    SILENT = "silent"
    SLOW = "slow"
    CLOCK = "clock"
    ORDER = "order"
    RESTARTS = "restarts"


@dataclass(frozen=True, slots=True)
class NodeFinding:
    """One thing that is wrong: a sentence, and since when if that is known."""

    trouble: Trouble
    text: str
    since_s: float | None = None


@dataclass(frozen=True, slots=True)
class NodeHealth:
    """One node as judged now.

    Args:
        info: what the robot declared of it, ``None`` for one that is only heard.
        node: what was heard of it last, ``None`` for one that is only declared.
        absent: why nothing may rely on it, without a full stop; empty while it is there.
        cure: what brings it back, in the imperative; empty while it is there.
        since_s: since when it is not there.
    """

    name: str
    label: str
    info: NodeInfo | None
    node: Node | None
    absent: str
    cure: str
    since_s: float | None
    findings: tuple[NodeFinding, ...]

    @property
    def is_there(self) -> bool:
        """Whether functions may rely on it."""
        return not self.absent

    def has(self, trouble: Trouble) -> bool:
        """Say whether this is wrong with it."""
        return any(one.trouble is trouble for one in self.findings)


def judge(robot: Robot, now_s: float) -> dict[str, NodeHealth]:
    """Return every node by name: those declared, in the robot's order, then those only heard."""
    infos = {info.name: info for info in robot.factsheet.nodes} if robot.factsheet is not None else {}
    names = dict.fromkeys([*infos, *sorted(robot.nodes)])
    return {name: _judge(name, infos, robot.nodes, now_s) for name in names}


def is_silent(node: Node, now_s: float) -> bool:
    """Say whether three of its reports are missing."""
    return now_s - node.stamp.source_s > SILENT_PERIODS * node.period_s


def is_slow(node: Node, usual_hz: float | None) -> bool:
    """Say whether a started node runs at less than half its usual rate; without both rates it is not."""
    return node.state == "started" and node.rate_hz is not None and node.rate_hz < SLOW_SHARE * (usual_hz or 0.0)


def _judge(name: str, infos: dict[str, NodeInfo], nodes: dict[str, Node], now_s: float) -> NodeHealth:
    info, node = infos.get(name), nodes.get(name)
    label = info.label if info is not None and info.label else name
    if node is None:
        return NodeHealth(name, label, info, None, f"{label} was not heard", f"Start {label}", None, ())
    usual_hz = info.rate_hz if info is not None else None
    absent, cure, since_s = _absence(label, node, usual_hz, now_s)
    findings = [
        *_life(node, usual_hz, now_s),
        *_clock(node),
        *_order(info, node, infos, nodes),
        *_restarts(node, now_s),
    ]
    return NodeHealth(name, label, info, node, absent, cure, since_s, tuple(findings))


def _absence(label: str, node: Node, usual_hz: float | None, now_s: float) -> tuple[str, str, float | None]:
    if is_silent(node, now_s):
        return f"{label} lost", f"Restart {label}", node.stamp.source_s
    because = f": {node.text.rstrip('.')}" if node.text else ""
    match node.state:
        case "started" if is_slow(node, usual_hz):
            told = f"{label} runs at {node.rate_hz:.3g} Hz, usual {usual_hz:g} Hz"
            return told, f"Restart {label}, or look at what loads its computer", None
        case "started":
            return "", "", None
        case "failure":
            return f"{label} failed{because}", f"Restart {label}", node.since_s
        case "stopped":
            cure = f"Start {label}" if not node.text else f"Mend what stopped it, then start {label}"
            return f"{label} stopped{because}", cure, node.since_s
        case "starting":
            return f"{label} is starting", f"Wait until {label} has started", node.since_s
        case "stopping":
            return f"{label} is stopping", f"Start {label} when it has stopped", node.since_s
    return f"State of {label} is not known", f"Restart {label}", node.since_s


def _life(node: Node, usual_hz: float | None, now_s: float) -> list[NodeFinding]:
    if is_silent(node, now_s):
        return [NodeFinding(Trouble.SILENT, "Not heard any more. What is shown of it is old.", node.stamp.source_s)]
    if node.state == "failure":
        return [NodeFinding(Trouble.FAILED, f"Failed. {node.text}".strip(), node.since_s)]
    if is_slow(node, usual_hz):
        return [NodeFinding(Trouble.SLOW, f"Runs at {node.rate_hz:.3g} Hz, usual {usual_hz:g} Hz.")]
    return []


def _clock(node: Node) -> list[NodeFinding]:
    offset_s = node.clock_offset_s
    if offset_s is None or abs(offset_s) <= CLOCK_LIMIT_S:
        return []
    way = "ahead" if offset_s > 0 else "behind"
    host = f" Set up the time service on {node.host}." if node.host else " Set up the time service."
    text = f"Its clock is {_span(abs(offset_s))} {way}: what it measures is put at the wrong place and time.{host}"
    return [NodeFinding(Trouble.CLOCK, text)]


def _order(info: NodeInfo | None, node: Node, infos: dict[str, NodeInfo], nodes: dict[str, Node]) -> list[NodeFinding]:
    if info is None or node.state != "started":
        return []
    found = []
    for name in info.starts_after:
        other = infos.get(name)
        label = other.label if other is not None and other.label else name
        first = nodes.get(name)
        if first is None or first.state != "started":
            text = f"It needs {label} first, which is not started. Start {label}, then restart this one."
        elif _is_before(node.since_s, first.since_s):
            text = f"It was started before {label} and may have missed it. Restart it."
        else:
            continue
        found.append(NodeFinding(Trouble.ORDER, text, node.since_s))
    return found


def _is_before(since_s: float | None, other_s: float | None) -> bool:
    return since_s is not None and other_s is not None and since_s < other_s - ORDER_MARGIN_S


def _restarts(node: Node, now_s: float) -> list[NodeFinding]:
    if node.restarts == 0 or node.since_s is None or now_s - node.since_s > RESTARTED_S:
        return []
    times = "once" if node.restarts == 1 else f"{node.restarts} times"
    return [NodeFinding(Trouble.RESTARTS, f"Restarted {times}, the last time just now.", node.since_s)]


def _span(span_s: float) -> str:
    return f"{span_s * 1000:.0f} ms" if span_s < 1 else f"{span_s:.1f} s"
