"""What the robot itself reports: faults of its state, and alarms it told as events."""

from __future__ import annotations

from collections.abc import Collection

from hmi.domain.alarm.finding import MAX_TEXT, NOTHING, Finding, Findings, detail_of_id
from hmi.domain.alarm.priority import Priority
from hmi.domain.event import RobotEvent
from hmi.domain.robot import Fault, RobotState
from hmi.ingest.supervision.view import View

LEVELS = {"critical": Priority.CRITICAL, "high": Priority.HIGH, "medium": Priority.MEDIUM, "low": Priority.LOW}
UNKNOWN = "robot-fault"
MAX_TOLD = 32
NODE_FAILURE = "node-failure"  # says in short what each node says for itself, where nodes are reported


class Faults:
    """Faults by code: known ones become their type, others ``robot-fault`` in the robot's own words.

    Args:
        known: codes of the catalogue that a robot may report.
    """

    def __init__(self, known: Collection[str]) -> None:
        self._known = known
        self.codes = frozenset({*known, UNKNOWN})
        self._told: dict[str, tuple[Fault, float]] = {}
        self._listed: set[str] = set()
        self._state: RobotState | None = None
        self._boot: str | None = None
        self._found: Findings = NOTHING

    def hear(self, event: RobotEvent) -> bool:
        """Take an event; return whether it told of an alarm."""
        code = str(event.data.get("code") or event.name)
        if event.kind == "alarm_raised" and len(self._told) < MAX_TOLD:
            level, hint = str(event.data.get("level", "medium")), str(event.data.get("hint", ""))
            at_s = event.stamp.source_s if event.stamp is not None else 0.0
            self._told[code] = Fault(code, level, event.text, hint), at_s
        elif event.kind == "alarm_cleared":
            self._told.pop(code, None)
        else:
            return False
        self._state = None
        return True

    def look(self, view: View) -> Findings | None:
        """See ``Rule``; a robot whose state was never heard cannot be judged."""
        state = view.robot.state
        if view.robot.link.boot != self._boot:
            self._boot, self._state = view.robot.link.boot, None
            self._told.clear()
        if state is None:
            return None
        if state is not self._state:
            self._state, self._found = state, self._find(state)
        if view.robot.nodes and any(one.detail == NODE_FAILURE for one in self._found):
            return tuple(one for one in self._found if one.detail != NODE_FAILURE)
        return self._found

    def _find(self, state: RobotState) -> Findings:
        if not state.faults and not self._told:
            return NOTHING
        faults = {fault.code: (fault, state.stamp.source_s) for fault in state.faults}
        self._listed |= faults.keys()
        for code, (fault, at_s) in list(self._told.items()):
            # the state is the truth for what it lists at all; the event only comes first
            if code not in faults and code in self._listed and state.stamp.source_s > at_s:
                del self._told[code]
            else:
                faults[code] = fault, min(at_s, faults.get(code, (fault, at_s))[1])
        return tuple(self._finding(fault, at_s) for fault, at_s in faults.values())

    def _finding(self, fault: Fault, at_s: float) -> Finding:
        text = fault.text[:MAX_TEXT]
        if fault.code in self._known:
            return Finding(fault.code, text, since_s=at_s)
        level = LEVELS.get(fault.level, Priority.MEDIUM)
        return Finding(UNKNOWN, text or fault.code, detail_of_id(fault.code), level, fault.hint[:MAX_TEXT], at_s)
