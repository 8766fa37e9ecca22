"""Orders that concern the inside of the machine: crane, seedlings, places, software nodes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from msgspec import UNSET

from backend_clients.edge import messages_down as down
from backend_clients.edge.machine import Point3
from backend_clients.simulator.crane import BY_NAME, OutOfReach
from backend_clients.simulator.crane_task import retract, send_tip
from backend_clients.simulator.verdict import OK, Verdict, refused
from backend_clients.simulator.work import Sites

if TYPE_CHECKING:
    from backend_clients.simulator.brain import Brain

MAX_GO_TO_M = 500.0
MOVE_CRANE, JOG_CRANE = "move-crane", "manual-crane"
HELPED_BY_RETRACTING = ("crane_limit", "ask_person")
"""What a mission may wait for while the crane is retracted under it."""
FRESH_ONLY = ("pause", "abort", "node_start", "node_stop", "node_restart")
"""Orders that need no control of the robot."""


@dataclass(slots=True)
class JogState:
    """Joints moved by hand: the newest rates and when they came, on the robot's clock."""

    rates: dict[str, float]
    heard_s: float = -math.inf


def needs(brain: Brain, function: str) -> Verdict:
    """Refuse what needs a function that is off, naming it."""
    why = brain.nodes.why_off(function)
    if not why:
        return OK
    label = next(one.label for one in brain.profile.functions if one.name == function)
    return refused("function_off", f"{label} is off: {why} does not run.")


class MachineOrders:
    """Judges and carries out these orders for one brain; freshness and lease were judged before."""

    def __init__(self, brain: Brain) -> None:
        self._brain = brain

    def carry_out(self, order: down.Command, may_move: Verdict) -> Verdict:
        """Carry out one order; ``may_move`` is what STOP, the button and driving by hand say."""
        if order.action.startswith("node_"):
            return self._node(order)
        if not may_move.is_accepted:
            return may_move
        if order.action == "go_to":
            return self._go_to(order)
        if self._brain.machine.rig is None:
            return refused("not_supported")
        match order.action:
            case "tool_retract":
                return self._retract()
            case "tool_go_to":
                return self._send_tip(order)
            case "skip_target":
                return self._skip(order)
            case _:
                return self._refilled()

    def jog(self, order: down.Jog, may_move: Verdict, now_s: float) -> Verdict:
        """Take one setpoint for the joints; open driving by hand is needed."""
        brain = self._brain
        if brain.is_stopped:
            return may_move
        limbs, has_crane = brain.machine.limbs, brain.machine.rig is not None
        if limbs is None and not has_crane:
            return refused("not_supported")
        if brain.drive is None:
            return refused("not_in_manual")
        if any(name not in (BY_NAME if limbs is None else limbs.pose) for name in order.rates):
            return refused("unknown_joint")
        verdict = needs(brain, JOG_CRANE) if has_crane else OK
        if verdict.is_accepted and has_crane and brain.work.waits_for() == "person_inside":
            return refused("person_inside", "Somebody is within reach of the crane. Clear the area first.")
        if verdict.is_accepted:
            brain.jog = JogState(dict(order.rates), now_s)
            brain.drive.heard_s = max(brain.drive.heard_s, now_s - 1.0)  # in use: it is not closed for want of it
        return verdict

    # ---- places ------------------------------------------------------------------------------------------

    def _go_to(self, order: down.Command) -> Verdict:
        brain = self._brain
        place = _place(order)
        if place is None:
            return refused("no_place")
        verdict = self._must_be_free()
        if not verdict.is_accepted:
            return verdict
        verdict = needs(brain, brain.profile.drive_function)
        if not verdict.is_accepted:
            return verdict
        if math.dist(brain.place, place[:2]) > MAX_GO_TO_M:
            return refused("mission_too_far", "The place is too far to drive there alone.")
        if brain.machine.is_way_blocked():
            return refused("person_ahead")
        brain.go_to(place[:2])
        return OK

    # ---- the crane ---------------------------------------------------------------------------------------

    def _may_move_crane(self) -> Verdict:
        brain = self._brain
        verdict = needs(brain, MOVE_CRANE)
        if not verdict.is_accepted:
            return verdict
        if not brain.machine.base.is_still:
            return refused("not_standing")
        if brain.machine.is_cover_open:
            return refused("tool_interlock")
        return refused("person_inside") if brain.work.waits_for() == "person_inside" else OK

    def _retract(self) -> Verdict:
        brain, rig = self._brain, self._brain.machine.rig
        assert rig is not None
        is_helping = brain.is_auto and not brain.errand and brain.hold_code in HELPED_BY_RETRACTING
        verdict = OK if is_helping else self._must_be_free()
        if verdict.is_accepted:
            verdict = self._may_move_crane()
        if verdict.is_accepted:
            self._helped()
            brain.move_crane(retract(rig.crane))
        return verdict

    def _send_tip(self, order: down.Command) -> Verdict:
        brain, rig = self._brain, self._brain.machine.rig
        assert rig is not None
        place = _place(order)
        if place is None:
            return refused("no_place")
        verdict = self._must_be_free()
        if verdict.is_accepted:
            verdict = self._may_move_crane()
        if not verdict.is_accepted:
            return verdict
        try:
            brain.move_crane(send_tip(rig.crane, brain.machine.base, place))
        except OutOfReach:
            return refused("out_of_reach")
        return OK

    # ---- seedlings ---------------------------------------------------------------------------------------

    def _skip(self, order: down.Command) -> Verdict:
        work = self._brain.work
        assert isinstance(work, Sites)
        verdict = work.skip(None if order.target is UNSET else str(order.target))
        if verdict.is_accepted:
            self._helped()
            self._brain.note("mission", "Tree skipped", verdict.text)
        return verdict

    def _refilled(self) -> Verdict:
        brain, machine = self._brain, self._brain.machine
        if not machine.base.is_still or machine.tool_on:
            return refused("not_standing", "Crane and machine have to stand still while a tray is loaded.")
        machine.seedlings = machine.profile.tray
        brain.faults.clear("tray-empty")
        brain.note("mission", "Tray loaded", f"{machine.seedlings} seedlings")
        return OK

    def _helped(self) -> None:
        if isinstance(self._brain.work, Sites):
            self._brain.work.person_helped()

    # ---- nodes -------------------------------------------------------------------------------------------

    def _node(self, order: down.Command) -> Verdict:
        brain = self._brain
        if order.node is UNSET:
            return refused("unknown_node")
        name, now_s, now_ms = str(order.node), brain.clock.mono_s(), brain.mono_ms()
        if order.action == "node_start":
            return brain.nodes.start(name, now_s, now_ms)
        is_down = name in brain.nodes.lives and brain.nodes.lives[name].state in ("stopped", "failure")
        if not brain.machine.is_standing and not is_down:
            return refused("not_standing", "The robot moves. Pause it before you stop one of its nodes.")
        return brain.nodes.stop(name, now_s, now_ms, comes_back=order.action == "node_restart")

    def _must_be_free(self) -> Verdict:
        brain = self._brain
        if brain.errand:
            return refused("already_moving")
        return refused("mission_running") if brain.is_auto else OK


def _place(order: down.Command) -> Point3 | None:
    return None if isinstance(order.place, type(UNSET)) else order.place
