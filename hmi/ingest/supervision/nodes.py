"""The error monitor of all nodes of a robot: failed, silent, slow, restarting, a wrong clock, started too early."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping

from hmi.domain.alarm.catalogue import AlarmType
from hmi.domain.alarm.finding import MAX_TEXT, NOTHING, Finding, Findings, detail_of_id
from hmi.domain.alarm.steady import Limit
from hmi.domain.machine import NodeInfo
from hmi.domain.node_health import RESTARTED_S, SILENT_PERIODS, NodeHealth, Trouble, judge
from hmi.domain.robot import Node, Robot
from hmi.ingest.supervision.view import View

RESTARTS = 3  # so many within ten minutes are no chance
PERIOD_S = 5.0  # docs/protocols/edge.md, where nothing else is said
PAST_S = 0.01  # looked at when a limit is passed, not when it is met
SAME_START_S = 0.1  # the robot's clock is mapped on ours anew with each message
CODES = {"node-failed", "node-silent", "node-slow", "node-clock", "node-start-order", "node-restarting"}


class Nodes:
    """One alarm for each node and each thing that is wrong with it; one alone where no node is reported any more.

    A node that is declared and was never heard is silent, too; where none of them was, that is one alarm.

    Args:
        slow_of: the type as it is set now; its limit is in percent of the usual rate.
        clock_of: the type as it is set now; its limit is in milliseconds.
    """

    codes = frozenset(CODES)

    def __init__(self, slow_of: Callable[[], AlarmType], clock_of: Callable[[], AlarmType]) -> None:
        self._slow_of, self._clock_of = slow_of, clock_of
        self._passed: dict[tuple[str, str], bool] = {}
        self._restarts: dict[str, deque[float]] = {}
        self._nodes: Mapping[str, Node] = {}
        self._found: Findings = NOTHING
        self._online_s: float | None = None
        self._due_s = float("-inf")
        self._silent: set[str] = set()

    @property
    def _slow(self) -> Limit:
        limit = self._slow_of().limit
        assert limit is not None
        return Limit(limit.at, limit.deadband, is_lower=True)

    @property
    def _clock(self) -> Limit:
        limit = self._clock_of().limit
        assert limit is not None
        return limit

    def look(self, view: View) -> Findings | None:
        """See ``Rule``; while the robot is not heard, what held goes on."""
        robot, nodes = view.robot, view.robot.nodes
        if not robot.link.is_online:
            self._online_s = None
            return None
        if self._online_s is None:
            self._online_s = view.now_s
        if not nodes:
            return self._none_ever(robot, view.now_s)
        if nodes is not self._nodes:
            self._count_restarts(nodes, view.now_s)
            before = self._nodes
            is_news = any(
                not _is_alike(before.get(name), one) or (name in self._silent and one is not before.get(name))
                for name, one in nodes.items()
            )
            self._nodes = nodes
            if is_news or view.now_s >= self._due_s:
                self._judge(robot, view.now_s)
        elif view.now_s >= self._due_s:
            self._judge(robot, view.now_s)
        return self._found

    def _none_ever(self, robot: Robot, now_s: float) -> Findings | None:
        """Judge a robot none of whose nodes was heard since the console started: its node supervisor may be dead."""
        infos = () if robot.factsheet is None else robot.factsheet.nodes
        if not infos or now_s <= max(self._missed_s(one, robot) for one in infos):
            return None
        text = (
            f"None of its {len(infos)} nodes was ever heard."
            if len(infos) > 1
            else f"{infos[0].label} was never heard."
        )
        return (Finding("node-silent", text, since_s=self._online_s),)

    def _judge(self, robot: Robot, now_s: float) -> None:
        every = list(judge(robot, now_s).values())
        healths = [one for one in every if one.node is not None]
        silent = [one for one in healths if self._is_silent(one.node, now_s)]
        self._silent = {one.name for one in silent}
        found: list[Finding] = []
        if len(silent) == len(healths) and len(silent) > 1:
            text = f"None of its {len(silent)} nodes is reported any more."
            found.append(Finding("node-silent", text, since_s=max(_heard_s(one) for one in silent)))
        else:
            found += [_finding("node-silent", one, f"{one.label} is not heard any more.", _heard_s(one))
                      for one in silent]  # fmt: skip
        if len(silent) < len(healths):
            found += [_finding("node-silent", one, f"{one.label} was never heard.", self._online_s)
                      for one in every if one.info is not None and one.node is None
                      and now_s > self._missed_s(one.info, robot)]  # fmt: skip
        for one in healths:
            if one not in silent:
                found += self._wrong(one, now_s)
        self._found = tuple(found)
        self._due_s = self._next_s(robot, now_s)

    def _is_silent(self, node: Node | None, now_s: float) -> bool:
        return node is not None and now_s > self._silent_s(node)

    def _silent_s(self, node: Node) -> float:
        """Return from when on it is silent; after an outage of the link it has as long as after its last report."""
        return max(node.stamp.source_s, self._online_s or 0.0) + SILENT_PERIODS * node.period_s

    def _missed_s(self, info: NodeInfo, robot: Robot) -> float:
        """Return from when on a declared node is missed that never reported.

        By the period it declares, else by the slowest of those that do report: its own is not known yet.
        """
        period_s = info.period_s or max((PERIOD_S, *(one.period_s for one in robot.nodes.values())))
        return (self._online_s or 0.0) + SILENT_PERIODS * period_s

    def _next_s(self, robot: Robot, now_s: float) -> float:
        """Return when the next node would be silent; a minute at most, for restarts are forgotten with time."""
        infos = () if robot.factsheet is None else robot.factsheet.nodes
        missed = (self._missed_s(info, robot) for info in infos if info.name not in robot.nodes)
        times = (*map(self._silent_s, robot.nodes.values()), *missed)
        return min((one for one in times if one >= now_s), default=now_s + 60.0) + PAST_S

    def _wrong(self, health: NodeHealth, now_s: float) -> list[Finding]:
        node, label, found = health.node, health.label, []
        assert node is not None
        if node.state == "failure":
            found.append(_finding("node-failed", health, f"{label} failed. {node.text}".strip(), node.since_s))
        usual_hz = health.info.rate_hz if health.info is not None else None
        share = node.rate_hz / usual_hz * 100 if usual_hz and node.rate_hz is not None else None
        if self._is_past(self._slow, "slow", node, share if node.state == "started" else 100.0):
            text = f"{label} runs at {node.rate_hz:.3g} Hz, usual {usual_hz:g} Hz."
            found.append(_finding("node-slow", health, text))
        offset_ms = None if node.clock_offset_s is None else abs(node.clock_offset_s) * 1000
        if self._is_past(self._clock, "clock", node, offset_ms) and offset_ms is not None:
            way = "ahead of" if (node.clock_offset_s or 0) > 0 else "behind"
            found.append(_finding("node-clock", health, f"{label}: {offset_ms:.0f} ms {way} the robot's clock."))
        found += [_finding("node-start-order", health, f"{label}: {one.text}", one.since_s)
                  for one in health.findings if one.trouble is Trouble.ORDER][:1]  # fmt: skip
        times = self._restarts.get(node.name, ())
        if sum(now_s - at < RESTARTED_S for at in times) >= RESTARTS:
            found.append(_finding("node-restarting", health, f"{label} was restarted {RESTARTS} times in 10 minutes."))
        return found

    def _is_past(self, limit: Limit, what: str, node: Node, value: float | None) -> bool:
        key = (what, node.name)
        self._passed[key] = is_past = limit.is_passed(value, was_passed=self._passed.get(key, False))
        return is_past and value is not None

    def _count_restarts(self, nodes: Mapping[str, Node], now_s: float) -> None:
        for name, node in nodes.items():
            before = self._nodes.get(name)
            if before is not None and node.restarts > before.restarts:
                self._restarts.setdefault(name, deque(maxlen=RESTARTS)).append(now_s)


def _is_alike(before: Node | None, now: Node) -> bool:
    """Say whether a report brings no news but that the node was heard."""
    if before is now:
        return True
    if before is None or (before.state, before.restarts, before.text) != (now.state, now.restarts, now.text):
        return False
    if abs((before.since_s or 0.0) - (now.since_s or 0.0)) > SAME_START_S:
        return False
    return (before.rate_hz, before.clock_offset_s) == (now.rate_hz, now.clock_offset_s)


def _heard_s(health: NodeHealth) -> float:
    return health.node.stamp.source_s if health.node is not None else 0.0


def _finding(code: str, health: NodeHealth, text: str, since_s: float | None = None) -> Finding:
    since_s = since_s if since_s is not None else _heard_s(health)
    return Finding(code, text[:MAX_TEXT], detail_of_id(health.name), since_s=since_s)
