"""The software nodes of a robot: their life cycles, what starts before what, and what is on without them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from backend_clients.edge.fields import NodeState
from backend_clients.simulator.faults import ClockSkew, Faults, NodeFailure, NodeSilent, NodeSlow
from backend_clients.simulator.profile import Node, Profile
from backend_clients.simulator.verdict import OK, Verdict, accepted, refused

STOPPING_S, STARTING_S = 0.8, 2.0
FIRST_MS, EACH_MS = 400, 700  # the nodes come up one after the other, before the robot says anything
Log = Callable[[str, str], None]


@dataclass(slots=True)
class Life:
    """One node's life: its state since when, and what it shall become."""

    node: Node
    state: NodeState = "started"
    since_ms: int = 0
    restarts: int = 0
    text: str = ""
    due_s: float | None = None
    is_coming_back: bool = False


class Nodes:
    """All nodes of one boot.

    Args:
        profile: which there are.
        faults: what a tester switched on.
        log: told of each change as node and line.
    """

    def __init__(self, profile: Profile, faults: Faults, log: Log) -> None:
        self._profile, self._faults, self._log = profile, faults, log
        self.lives = {node.name: Life(node, since_ms=since) for node, since in _first_starts(profile)}
        self._off: dict[str, str] = {}
        self._needs_look = True
        self._is_tool_locked = False

    def look(self, now_s: float, now_ms: int, *, is_tool_locked: bool) -> None:
        """Go on with what is starting or stopping, and take up faults."""
        for life in self.lives.values():
            if life.due_s is not None and now_s >= life.due_s:
                self._next(life, now_s, now_ms)
        failing = self._faults.of(NodeFailure)
        if failing is not None and self._is_up(failing.node):
            self._enter(self.lives[failing.node], "failure", now_ms, "Segmentation fault (exit code 139)")
        self._is_tool_locked = is_tool_locked

    def start(self, name: str, now_s: float, now_ms: int) -> Verdict:
        """Start a node that is not there."""
        life = self.lives.get(name)
        if life is None:
            return refused("unknown_node")
        if life.state in ("started", "starting"):
            return accepted("already_started", "It runs already.")
        missing = [one for one in life.node.starts_after if self.lives[one].state != "started"]
        if missing:
            label = self.lives[missing[0]].node.label
            return refused("starts_after", f"{label} has to be started first.")
        self._faults.clear_node(name)
        self._enter(life, "starting", now_ms)
        life.due_s = now_s + STARTING_S
        return OK

    def stop(self, name: str, now_s: float, now_ms: int, *, comes_back: bool = False) -> Verdict:
        """Stop a node, or restart it."""
        life = self.lives.get(name)
        if life is None:
            return refused("unknown_node")
        if life.state in ("stopped", "stopping") and not comes_back:
            return accepted("already_stopped", "It is stopped already.")
        self._faults.clear_node(name)
        if life.state in ("stopped", "failure"):
            if comes_back:
                life.restarts += 1
                return self.start(name, now_s, now_ms)
            self._enter(life, "stopped", now_ms)
            return OK
        self._enter(life, "stopping", now_ms)
        life.due_s, life.is_coming_back = now_s + STOPPING_S, comes_back
        return OK

    def mend(self, name: str, now_s: float, now_ms: int) -> None:
        """A tester took a fault away: the node is started again."""
        if name in self.lives and self.lives[name].state == "failure":
            self.stop(name, now_s, now_ms, comes_back=True)

    def start_too_early(self, name: str, now_ms: int) -> None:
        """Let a node have been started before what it needs: it found nothing there and works without."""
        life = self.lives[name]
        for one in life.node.starts_after:
            self._enter(self.lives[one], "started", now_ms)
        life.text = f"no data from {', '.join(life.node.starts_after)} at start"
        self._log(name, f"warning: {life.text}")

    def is_started(self, name: str) -> bool:
        """Say whether a node runs."""
        return self.lives[name].state == "started"

    def why_off(self, function: str) -> str:
        """Return why a function is off, as the label of what it lacks; empty if it is on."""
        if self._needs_look:
            self._off = functions_off(self._profile, self)
            self._needs_look = False
        return self._off.get(function, "")

    @property
    def failed(self) -> list[str]:
        """The nodes that failed."""
        return [name for name, life in self.lives.items() if life.state == "failure"]

    def fields(self) -> list[dict[str, Any]]:
        """Return the node messages without their headers; a silent node says nothing."""
        silent, slow = self._faults.of(NodeSilent), self._faults.of(NodeSlow)
        skewed = self._faults.of(ClockSkew)
        found = []
        for name, life in self.lives.items():
            if silent is not None and silent.node == name:
                continue
            is_locked = self._is_tool_locked and name == self._profile.tool_node
            runs = life.state == "started" and not is_locked
            share = slow.share if slow is not None and slow.node == name else 1.0
            found.append(
                {
                    "name": name,
                    "state": "stopped" if is_locked else life.state,
                    "rate_hz": round(life.node.rate_hz * share, 2) if runs else 0.0,
                    "cpu_pct": life.node.cpu_pct if runs else 0.0,
                    "restarts": life.restarts,
                    "text": f"{self._profile.words.cover} is open" if is_locked else life.text,
                    "host": life.node.host,
                    "since_ms": life.since_ms,
                    "clock_offset_ms": skewed.offset_ms if skewed is not None and skewed.node == name else 0.4,
                }
            )
        return found

    def _is_up(self, name: str) -> bool:
        return name in self.lives and self.lives[name].state in ("started", "starting")

    def _next(self, life: Life, now_s: float, now_ms: int) -> None:
        life.due_s = None
        if life.state == "stopping":
            self._enter(life, "stopped", now_ms)
            if life.is_coming_back:
                life.is_coming_back = False
                life.restarts += 1
                self._enter(life, "starting", now_ms)
                life.due_s = now_s + STARTING_S
        elif life.state == "starting":
            self._enter(life, "started", now_ms)

    def _enter(self, life: Life, state: NodeState, now_ms: int, text: str = "") -> None:
        life.state, life.since_ms, life.text, life.due_s = state, now_ms, text, None
        self._needs_look = True
        self._log(life.node.name, f"{state} {text}".rstrip())


def functions_off(profile: Profile, nodes: Nodes) -> dict[str, str]:
    """Return the functions that are off, each with the label of the node it lacks."""
    known = {one.name: one for one in profile.functions}
    off: dict[str, str] = {}

    def lacks(name: str) -> str:
        if name in nodes.lives:
            return "" if nodes.is_started(name) else nodes.lives[name].node.label
        return next((why for one in known[name].depends_on if (why := lacks(one))), "")

    for name in known:
        if why := lacks(name):
            off[name] = why
    return off


def _first_starts(profile: Profile) -> list[tuple[Node, int]]:
    """Return each node with when it came up, in an order that keeps what starts after what."""
    waiting, done = list(profile.nodes), set[str]()
    found: list[tuple[Node, int]] = []
    while waiting:
        ready = [node for node in waiting if done.issuperset(node.starts_after)]
        for node in ready:
            found.append((node, FIRST_MS + EACH_MS * len(found)))
            done.add(node.name)
        waiting = [node for node in waiting if node not in ready]
    order = {node.name: number for number, node in enumerate(profile.nodes)}
    return sorted(found, key=lambda one: order[one[0].name])
