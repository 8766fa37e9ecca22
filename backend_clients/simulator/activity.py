"""Which states of its chart a robot is in, since when, and what changed last."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from backend_clients.edge.machine import ActiveState, LastTransition
from backend_clients.simulator.chart_tree import ChartTree


@dataclass(frozen=True, slots=True)
class Step:
    """One transition that was taken: by which event, and with which result code of the action that ended."""

    source: str
    target: str
    event: str
    result: str = ""


@dataclass(frozen=True, slots=True)
class Change:
    """A state that was entered or left; ``duration_ms`` and ``result`` only when left."""

    state: str
    is_entered: bool
    duration_ms: int = 0
    result: str = ""


class Activity:
    """The active states of one chart; ``become`` is the only way they change."""

    def __init__(self, tree: ChartTree, first: Sequence[str], now_ms: int) -> None:
        self.tree = tree
        self._since = dict.fromkeys(first, now_ms)
        self.last: LastTransition | None = None

    @property
    def states(self) -> tuple[str, ...]:
        """Every active state, outer first."""
        return tuple(self._since)

    def active(self) -> list[ActiveState]:
        """Return them as the state message says them."""
        return [ActiveState(id=one, since_ms=since) for one, since in self._since.items()]

    def become(self, states: Sequence[str], now_ms: int, steps: Sequence[Step] = ()) -> list[Change]:
        """Take a new configuration; return what was left (inner first) and entered (outer first)."""
        results = {step.source: step.result for step in steps if step.result}
        wanted = set(states)
        left = [
            Change(one, False, max(now_ms - since, 0), results.get(one, ""))
            for one, since in reversed(self._since.items())
            if one not in wanted
        ]
        entered = [Change(one, True) for one in states if one not in self._since]
        if left or entered:
            self._since = {one: self._since.get(one, now_ms) for one in states}
        if steps:
            step = steps[-1]
            self.last = LastTransition(
                source=step.source, target=step.target, event=step.event, result=step.result, at_ms=now_ms
            )
        return left + entered
