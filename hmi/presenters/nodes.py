"""Software nodes with their life cycle, as the live lane and REST carry them; pure."""

from __future__ import annotations

from typing import Any

from hmi.domain.functions import needing
from hmi.domain.node_health import NodeHealth, Trouble, judge
from hmi.domain.robot import Node, Robot
from hmi.presenters.units import milliseconds

LEVELS = {Trouble.FAILED: 2, Trouble.SILENT: 2, Trouble.SLOW: 3, Trouble.ORDER: 3, Trouble.CLOCK: 3}
"""Priority at which each trouble is shown; restarts alone are none."""


def present(robot: Robot, now_s: float) -> dict[str, Any] | None:
    """Return the group ``nodes`` of topic ``inside``; ``None`` while nothing is known.

    ``finding`` is the worst thing wrong with a node, ``findings`` all of them, ``off`` what goes off without it.
    """
    known = judge(robot, now_s)
    if not known:
        return None
    return {"nodes": [_node(robot, one) for one in known.values()]}


def _node(robot: Robot, health: NodeHealth) -> dict[str, Any]:
    info = health.info
    findings = [one.text for one in health.findings]
    functions = robot.factsheet.functions if robot.factsheet is not None else ()
    return {
        "name": health.name,
        "label": health.label,
        "subsystem": info.subsystem if info is not None else "",
        "usual_hz": info.rate_hz if info is not None else None,
        "starts_after": list(info.starts_after) if info is not None else [],
        **_heard(health.node),
        "finding": findings[0] if findings else "",
        "findings": findings,
        "level": min((LEVELS[o.trouble] for o in health.findings if o.trouble in LEVELS), default=None),
        "off": [one.label for one in needing(functions, health.name)],
    }


def _heard(node: Node | None) -> dict[str, Any]:
    if node is None:
        nothing = dict.fromkeys(("rate_hz", "cpu_pct", "restarts", "since", "t", "offset_ms"))
        return {**nothing, "state": "unknown", "text": "", "host": "", "period_ms": 5000}
    return {
        "state": node.state,
        "rate_hz": node.rate_hz,
        "cpu_pct": node.cpu_pct,
        "restarts": node.restarts,
        "text": node.text,
        "host": node.host,
        "since": milliseconds(node.since_s),
        "t": milliseconds(node.stamp.source_s),
        "period_ms": round(node.period_s * 1000),
        "offset_ms": None if node.clock_offset_s is None else round(node.clock_offset_s * 1000, 1),
    }
