"""Keeps the planter's running supervisor in step with orders, STOP, waiting and people; reports what it did."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from backend_clients.simulator.activity import Step
from backend_clients.simulator.chart_tree import ChartTree
from backend_clients.simulator.planting import Planting
from backend_clients.simulator.planting_cycle import TreeResult
from backend_clients.simulator.top_chart import top_of

if TYPE_CHECKING:
    from backend_clients.simulator.brain import Brain

STAYS = ("start_horn", "person_inside", "person_ahead")  # its guard or its place in the chart says it already
MUST_WAIT = ("rtk_float",)
_GUARDS = {
    ("area-clear", "person-near"): "came_near",
    ("area-clear", "person-inside"): "came_inside",
    ("person-near", "person-inside"): "came_inside",
    ("person-inside", "person-near"): "went_out",
    ("person-near", "area-clear"): "went_away",
    ("person-inside", "area-clear"): "went_away",
}


class PlanterSupervisor:
    """Follows what the brain decides; the states of a site are moved by the work itself."""

    def __init__(self, tree: ChartTree, work: Planting) -> None:
        self.tree, self._work = tree, work
        self._machine = work.states
        self._states: tuple[str, ...] = ("start-up",)

    def look(self, brain: Brain) -> tuple[Sequence[str], Sequence[Step]]:
        """Bring the machine to where the robot is; return its states and what it took since the last look."""
        machine = self._machine
        self._follow_top(brain)
        if "mission" in machine.active:
            self._follow_waiting(brain)
        if "plant-site" in machine.active:
            self._follow_people(brain)
        for result in self._work.take_results():
            note_tree(brain, result)
        self._tell_log(brain)
        if not machine.taken:
            return self._states, ()
        steps, machine.taken = machine.taken, []
        self._states = self.tree.configuration(machine.active)
        return self._states, steps

    def _follow_top(self, brain: Brain) -> None:
        now = next(one for one in self._machine.active if self.tree.states[one].parent is None)
        wanted = top_of(brain)
        if now == wanted:
            if wanted != "mission" and "end" in self._machine.active:
                self._machine.fire("to_idle")
            return
        is_done = brain.run is not None and brain.run.status == "done" and now == "mission"
        if is_done and wanted == "idle" and "end" not in self._machine.active:
            self._machine.fire("last_point")  # a look of its own, then idle
            return
        for move in self.tree.way(now, wanted):
            self._machine.fire(f"to_{move.target.replace('-', '_')}")
        if now == "mission":
            self._work.interrupted()

    def _follow_waiting(self, brain: Brain) -> None:
        code, machine = brain.hold_code, self._machine
        is_planting = "plant-site" in machine.active
        if not code:
            if "begin" in machine.active and brain.pilot.followed is not None:
                machine.fire("horn_sounded")
            elif brain.is_on_lead and not is_planting and "transit" not in machine.active:
                machine.fire("go_on_driving")
            return
        if code == "start_horn" or (code in STAYS and is_planting):
            return
        event, state = self._event_of(code, is_planting=is_planting)
        if state not in machine.active:
            machine.fire(event)
            self._work.interrupted()

    def _event_of(self, code: str, *, is_planting: bool) -> tuple[str, str]:
        if code in MUST_WAIT:
            return "must_wait", "wait"
        if code == "tray_empty" and (is_planting or "refill" in self._machine.active):
            return "tray_empty", "refill"
        return "person_needed", "wait-person"

    def _follow_people(self, brain: Brain) -> None:
        machine = self._machine
        now = next(one for one in ("area-clear", "person-near", "person-inside") if one in machine.active)
        wanted = self._work.rig.guard(brain.machine.base, brain.machine.person)
        if now != wanted:
            machine.fire(_GUARDS[now, wanted])

    def _tell_log(self, brain: Brain) -> None:
        lines, self._work.cycle.log = self._work.cycle.log, []
        for node, line in lines:
            brain.journal.log(brain.mono_ms(), line, node=node)


def note_tree(brain: Brain, result: TreeResult) -> None:
    """Write one attempt at planting as an event."""
    number = result.target.id.removeprefix("tree-")
    word = "planted" if result.outcome == "done" else "failed"
    brain.note(
        "treatment",
        f"Tree {number} {word}",
        "",
        target=result.target.id,
        outcome=result.outcome,
        code=result.code,
        x_m=result.target.x_m,
        y_m=result.target.y_m,
        stop=result.stop,
        duration_s=result.duration_s,
        mission_id=brain.run.mission.mission_id if brain.run is not None else "",
    )
