"""A state chart as a tree: which states are active together, and how one leads to another; pure."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable

from backend_clients.edge.machine import Chart, ChartState, ChartTransition


class ChartTree:
    """Questions about one chart.

    Raises:
        ValueError: a parent or the end of a transition is missing, or the states form a loop.
    """

    def __init__(self, chart: Chart) -> None:
        self.chart = chart
        self.states: dict[str, ChartState] = {state.id: state for state in chart.states}
        self._order = {state.id: number for number, state in enumerate(chart.states)}
        self._children: dict[str | None, list[str]] = {}
        for state in chart.states:
            self._children.setdefault(state.parent, []).append(state.id)
        self.lineages = {state.id: self._lineage(state.id) for state in chart.states}
        self._by_source: dict[str, list[ChartTransition]] = {}
        for move in chart.transitions:
            if move.source not in self.states or move.target not in self.states:
                raise ValueError(f"transition {move.source} to {move.target} leads nowhere")
            self._by_source.setdefault(move.source, []).append(move)

    def configuration(self, leaves: Iterable[str]) -> tuple[str, ...]:
        """Return every active state, outer first, where ``leaves`` and what holds them is active.

        Regions and composites that no leaf names are entered at their initial state.
        """
        active = {one for leaf in leaves for one in self.lineages[leaf]}
        pending = list(active)
        while pending:
            fresh = self._missing(pending.pop(), active)
            active.update(fresh)
            pending += fresh
        return tuple(sorted(active, key=lambda one: (len(self.lineages[one]), self._order[one])))

    def is_legal(self, active: Iterable[str]) -> bool:
        """Say whether exactly one top state, one child of each composite, and all regions of a parallel are active."""
        found = set(active)
        if sum(one in found for one in self._children[None]) != 1:
            return False
        for one in found:
            state = self.states[one]
            if state.parent is not None and state.parent not in found:
                return False
            children = self._children.get(one, [])
            count = sum(child in found for child in children)
            if children and count != (len(children) if state.kind == "parallel" else 1):
                return False
        return True

    def labels(self, state: str) -> list[str]:
        """Return the labels from the outermost state to this one."""
        return [self.states[one].label for one in self.lineages[state]]

    def is_leaf(self, state: str) -> bool:
        """Say whether a state holds no other."""
        return state not in self._children

    def way(self, source: str, target: str) -> list[ChartTransition]:
        """Return the fewest transitions from one state to a sibling, empty if there are none."""
        came: dict[str, ChartTransition] = {}
        queue = deque([source])
        while queue:
            here = queue.popleft()
            if here == target:
                break
            for move in self._by_source.get(here, []):
                if move.target not in came and move.target != source:
                    came[move.target] = move
                    queue.append(move.target)
        steps: list[ChartTransition] = []
        while target != source and target in came:
            steps.append(came[target])
            target = came[target].source
        return steps[::-1] if target == source else []

    def _missing(self, state: str, active: set[str]) -> list[str]:
        children = self._children.get(state, [])
        if self.states[state].kind == "parallel":
            return [child for child in children if child not in active]
        if not children or any(child in active for child in children):
            return []
        return [next((child for child in children if self.states[child].is_initial), children[0])]

    def _lineage(self, state: str) -> tuple[str, ...]:
        found = [state]
        while (parent := self.states[found[-1]].parent) is not None:
            if parent not in self.states or parent in found:
                raise ValueError(f"state {found[-1]} lies in {parent}, which is not there")
            found.append(parent)
        return tuple(reversed(found))
