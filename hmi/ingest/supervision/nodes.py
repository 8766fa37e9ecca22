"""Parts of the robot's own software that failed."""

from __future__ import annotations

from collections.abc import Mapping

from hmi.domain.alarm.finding import MAX_TEXT, NOTHING, Finding, Findings, detail_of
from hmi.domain.robot import Node
from hmi.ingest.supervision.view import View


class Nodes:
    """One alarm for each node that reports a failure."""

    codes = frozenset({"node-failed"})

    def __init__(self) -> None:
        self._nodes: Mapping[str, Node] = {}
        self._found: Findings = NOTHING

    def look(self, view: View) -> Findings | None:
        """See ``Rule``."""
        nodes = view.robot.nodes
        if not nodes:
            return None
        if nodes is not self._nodes:
            self._nodes, self._found = nodes, tuple(_failed(one) for one in nodes.values() if one.state == "failure")
        return self._found


def _failed(node: Node) -> Finding:
    text = f"{node.name} failed. {node.text}".strip()[:MAX_TEXT]
    return Finding("node-failed", text, detail_of(node.name), since_s=node.stamp.source_s)
