"""The supervisor of one robot: what its chart says it is in, read from what it does.

A family whose supervisor is no machine of its own is described by a chart and a function that names its innermost
active states; the transitions taken follow from the chart.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import TYPE_CHECKING, Protocol

from backend_clients.edge.machine import Chart
from backend_clients.simulator import uav_chart, weeder_chart
from backend_clients.simulator.activity import Step
from backend_clients.simulator.chart_tree import ChartTree

if TYPE_CHECKING:
    from backend_clients.simulator.brain import Brain
    from backend_clients.simulator.profile import Family

Leaves = Callable[["Brain", "frozenset[str]"], Sequence[str]]


class Supervisor(Protocol):
    """Says at each control step which states are active, and by which transitions it came there."""

    tree: ChartTree

    def look(self, brain: Brain) -> tuple[Sequence[str], Sequence[Step]]:
        """Return all active states, outer first, and the transitions since the last look, oldest first."""
        ...


class ReadSupervisor:
    """A supervisor whose states follow from what the robot does.

    Args:
        tree: its chart.
        leaves: names the innermost active states; told what was active before.
    """

    def __init__(self, tree: ChartTree, leaves: Leaves) -> None:
        self.tree, self._leaves = tree, leaves
        self._states: tuple[str, ...] = ("start-up",)
        self._wanted: tuple[str, ...] = ()

    def look(self, brain: Brain) -> tuple[Sequence[str], Sequence[Step]]:
        """Compare with the last look."""
        wanted = tuple(self._leaves(brain, frozenset(self._states)))
        if wanted == self._wanted:
            return self._states, ()
        self._wanted = wanted
        before, self._states = self._states, self.tree.configuration(wanted)
        return self._states, steps_between(self.tree, before, self._states)


def steps_between(tree: ChartTree, before: Sequence[str], after: Sequence[str]) -> list[Step]:
    """Return the last transition in each part of the chart that changed and was active before and after."""
    now = {tree.states[one].parent: one for one in after if not _is_region(tree, one)}
    steps = []
    for one in before:
        target = now.get(tree.states[one].parent, one)
        if _is_region(tree, one) or target == one:
            continue
        way = tree.way(one, target)
        if way:
            steps.append(Step(way[-1].source, target, way[-1].event))
    return steps


def _is_region(tree: ChartTree, state: str) -> bool:
    parent = tree.states[state].parent
    return parent is not None and tree.states[parent].kind == "parallel"


@cache
def tree_of(family: Family) -> ChartTree:
    """Return the chart of a family."""
    return ChartTree(_chart_of(family))


def supervisor_of(brain: Brain) -> Supervisor:
    """Return what tells the states of a robot."""
    family = brain.profile.family
    if family == "planter":
        from backend_clients.simulator.planter_supervisor import PlanterSupervisor
        from backend_clients.simulator.planting import Planting

        assert isinstance(brain.work, Planting)
        return PlanterSupervisor(tree_of(family), brain.work)
    return ReadSupervisor(tree_of(family), weeder_chart.leaves if family == "weeder" else uav_chart.leaves)


def _chart_of(family: Family) -> Chart:
    # the library behind the planter's machine is not loaded where no planter lives
    if family == "planter":
        from backend_clients.simulator.planter_chart import chart

        return chart()
    return weeder_chart.CHART if family == "weeder" else uav_chart.CHART
