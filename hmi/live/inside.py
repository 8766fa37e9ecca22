"""Topic ``inside/{id}``: what goes on in one machine. Made only while somebody watches, ten times a second at most."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from hmi.domain.robot import Robot
from hmi.live.frames import INSIDE
from hmi.live.topics import Groups
from hmi.presenters import functions, inside, nodes, state_chart
from hmi.store.robot_record import ALL_PARTS, Part

REVIEW_S = 1.0
"""Nodes fall silent and functions go off without a message, or by a gauge that moves all the time."""
_Make = Callable[[Robot, float], dict[str, Any] | None]

MAKE: dict[str, _Make] = {
    "chart": lambda robot, _now_s: state_chart.chart_name(robot),
    "active": lambda robot, _now_s: state_chart.active(robot),
    "nodes": nodes.present,
    "functions": functions.present,
    "joints": lambda robot, _now_s: inside.joints(robot),
    "gauges": lambda robot, _now_s: inside.gauges(robot),
    "site": lambda robot, _now_s: inside.site(robot),
    "seen": lambda robot, _now_s: inside.seen(robot),
    "detections": lambda robot, _now_s: inside.detections(robot),
}
GROUPS_OF: dict[Part, tuple[str, ...]] = {
    Part.REGISTRY: (),
    Part.LINK: (),
    Part.FACTSHEET: ("chart", "nodes", "functions", "joints", "gauges"),
    Part.TELEMETRY: (),
    Part.STATE: ("active",),
    Part.SAFETY: (),
    Part.NODES: ("nodes", "functions"),
    Part.BODY: ("joints", "gauges", "site", "seen"),
    Part.WORKSITE: ("site",),
    Part.SIGHT: ("detections",),
}
REVIEWED = ("nodes", "functions")


class InsideTopic:
    """The groups of one robot. ``note`` is cheap and comes with each change; ``update`` makes what is due."""

    def __init__(self, robot_id: str) -> None:
        self.robot_id = robot_id
        self.name = INSIDE + robot_id
        self._groups = Groups()
        self._parts: set[Part] = set(ALL_PARTS)
        self._reviewed_s = float("-inf")

    def note(self, parts: Iterable[Part]) -> None:
        """Remember what changed until the next update."""
        self._parts.update(parts)

    def update(self, robot: Robot | None, now_s: float) -> str | None:
        """Return the changed groups as JSON, ``None`` if nothing did."""
        names = {name for part in self._parts for name in GROUPS_OF[part]}
        self._parts.clear()
        if now_s - self._reviewed_s >= REVIEW_S:
            self._reviewed_s = now_s
            names.update(REVIEWED)
        if not names:
            return None
        return self._groups.put({name: MAKE[name](robot, now_s) if robot else None for name in MAKE if name in names})

    def whole(self) -> str:
        """Return all groups as JSON."""
        return self._groups.whole()
