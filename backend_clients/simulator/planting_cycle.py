"""What crane and planting tool do at one site, action by action; each answers with a result code.

A seedling is fetched, dropped into the head, carried to a point, planted and photographed. What fails is tried
otherwise: docked again, backed off, the next point with the seedling still held; in the end a person is asked.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from backend_clients.edge.machine import Target
from backend_clients.simulator.crane import TRANSPORT, OutOfReach, Pose, pose_for
from backend_clients.simulator.planting_site import CARRY_M, HOVER_M, to_machine

if TYPE_CHECKING:
    from backend_clients.simulator.kinematics import Base
    from backend_clients.simulator.planter_chart import PlanterMachine
    from backend_clients.simulator.planter_rig import PlanterRig

TRANSFER_S, DROP_S, PLANT_S, PICTURE_S = 5.1, 3.1, 8.1, 0.3  # bench times and what the software adds
DOCK_TRIES = 3
TINY_S = 1e-9
MOST_EVENTS = 40  # in one step; more would be a loop
TRAY = (-0.6, 2.4)  # where the seedling arm holds out a seedling, in the machine's frame
DOCK, WAYPOINT = pose_for((*TRAY, 1.5)), pose_for((TRAY[0] - 0.2, TRAY[1] + 0.6, 2.3))
PHOTO_UP_M, PHOTO_BACK_M, BACK_OFF_M = 1.7, 1.0, 0.9
SHARE = {
    "transport": 0.791,
    "dock-waypoint": 0.522,
    "dock": 0.0853,
    "above-plant": 0.268,
    "on-ground": 0.1053,
    "photo": 0.2785,
    "back-off": 0.30,
    "retract": 0.30,
}
"""Of the joints' speed, by action: chosen so that the times are those published for the simulated machine."""
MOVES_OF_CRANE = tuple(SHARE)
_DONE = {
    "dock-waypoint": "waypoint_reached",
    "above-plant": "above_point",
    "on-ground": "grounded",
    "photo": "photo_taken",
    "back-off": "backed_off",
    "transport": "folded",
    "retract": "retracted",
}
"""The event of an action of the crane that went well."""
_TOOL_S = {"transfer": TRANSFER_S, "drop": DROP_S, "plant": PLANT_S}
FAILED = {
    "FAIL_SCAR": ("failed_tool", "SAVE_FAIL_SCAR", "The head could not open the ground."),
    "FAIL_GROUND": ("failed_ground", "SAVE_FAIL_GROUND", "The head found no ground."),
    "FAIL_CRANE": ("failed_machine", "SAVE_FAIL_CRANE", "The crane did not reach the point."),
}


@dataclass(frozen=True, slots=True)
class TreeResult:
    """One attempt that is over: the point, what became of it, its code, and how long it took."""

    target: Target
    outcome: str
    code: str
    stop: int
    duration_s: float


class PlantingCycle:
    """Works at the site of ``rig``; stands where nobody calls ``step``.

    Args:
        states: the running supervisor; actions follow from its active states and their results are sent to it.
        rig: the machine's crane, head and arm.
    """

    def __init__(self, states: PlanterMachine, rig: PlanterRig) -> None:
        self._states, self._rig = states, rig
        self._sent_for = ""
        self._tool_left_s = self._picture_left_s = 0.0
        self._tool_for = ""
        self._dock_tries = 0
        self._attempt_s = 0.0
        self._is_loading = False
        self._planted: Target | None = None
        self.needs_person = False
        self.results: list[TreeResult] = []
        self.log: list[tuple[str, str]] = []

    def step(self, dt_s: float, base: Base, tray: int, share: float, *, may_fetch: bool = False) -> int:
        """Live for ``dt_s``, the crane at ``share`` of its speed; return how many seedlings left the tray.

        ``may_fetch``: take a seedling although no point is chosen yet.
        """
        taken, left_s = 0, dt_s
        for _ in range(MOST_EVENTS):
            used_s, fed = self._advance(left_s, base, tray - taken, share, may_fetch=may_fetch)
            taken, left_s = taken + fed, left_s - used_s
            if left_s <= TINY_S:
                break
        return taken

    def fold(self, dt_s: float, base: Base, share: float) -> None:
        """Bring the crane where the machine may drive."""
        if "transport" not in self._states.active:
            self._send("fold")
        self._move("transport", base, dt_s, share)

    def _acting(self) -> tuple[str, str]:
        """Return the active states of crane and tool that are actions, empty if they are at rest."""
        active = self._states.active
        crane_state = next((one for one in MOVES_OF_CRANE if one in active), "")
        return crane_state, next((one for one in _TOOL_S if one in active), "")

    def _advance(self, left_s: float, base: Base, tray: int, share: float, *, may_fetch: bool) -> tuple[float, int]:
        """Live until the next action ends, at most ``left_s``; return how long that was, and the seedlings taken."""
        crane_state, tool_state = self._acting()
        if not crane_state and not tool_state:
            self._sent_for = self._tool_for = ""
            self._rig.crane.halt()
            return (0.0 if self._decide(tray, may_fetch=may_fetch) else left_s), 0
        if tool_state != self._tool_for:
            self._tool_for, self._tool_left_s = tool_state, _TOOL_S.get(tool_state, 0.0)
        span_s = min(left_s, self._tool_left_s) if tool_state else left_s
        if crane_state:
            span_s = self._move(crane_state, base, span_s, share)
        self._attempt_s += span_s
        taken = 0
        if tool_state:
            self._tool_left_s -= span_s
            if self._tool_left_s <= TINY_S:
                self._tool_for = ""
                taken = self._tool_done(tool_state)
        elif self._wants_seedling(tray):
            self._send("feed")
        return span_s, taken

    def forget(self) -> None:
        """Begin anew: somebody moved the crane, or the supervisor was elsewhere meanwhile."""
        self._sent_for = self._tool_for = ""
        self._is_loading = False
        self._record()
        self._rig.crane.halt()

    def give_up(self, status: str, text: str) -> Target | None:
        """Leave the current point; return it."""
        site = self._rig.site
        target = site.current if site is not None else None
        if site is not None and target is not None:
            site.mark(target.id, status, text)
        self.forget()
        return target

    # ---- decisions ---------------------------------------------------------------------------------------

    def _decide(self, tray: int, *, may_fetch: bool) -> bool:
        """Begin the next action; say whether there was one."""
        rig, site = self._rig, self._rig.site
        if self._is_loading:
            return self._load(tray)
        target = site.take_next() if site is not None else None
        can_fetch = rig.in_arm or tray > 0
        if target is not None and rig.in_head:
            return self._send("go_to_point")
        if can_fetch and (target is not None or (may_fetch and not rig.in_head)):
            self._attempt_s = 0.0
            return self._send("fetch")
        if target is None and not self._rig.is_folded and not may_fetch:
            return self._send("fold")
        return False

    def _load(self, tray: int) -> bool:
        """Stay docked for one more seedling."""
        if self._rig.in_arm:
            return self._send("docked")
        if tray > 0:
            return self._send("feed")
        self._is_loading = False
        return True

    def _wants_seedling(self, tray: int) -> bool:
        if self._rig.in_arm or tray <= 0:
            return False
        return not self._states.active.isdisjoint(("dock-waypoint", "dock"))

    # ---- the tool ----------------------------------------------------------------------------------------

    def _tool_done(self, state: str) -> int:
        rig = self._rig
        if state == "transfer":
            rig.in_arm = True
            self._send("fed", "OK")
            return 1
        if state == "drop":
            rig.in_arm, rig.in_head = False, rig.in_head + 1
            self._is_loading = rig.in_head < rig.tuning.seedlings_per_head
            self._send("dropped", "OK")
        elif self._chance(rig.tuning.fail_scar):
            self._fail("FAIL_SCAR")
            self._send("scar_failed", "FAIL_SCAR")
        else:
            rig.in_head -= 1
            self._plant()
            self._send("planted", "OK")
        return 0

    def _plant(self) -> None:
        """The tree stands; it counts even if its picture is never taken."""
        site = self._rig.site
        self._planted = site.current if site is not None else None
        if site is not None and self._planted is not None:
            site.mark(self._planted.id, "done")

    # ---- the crane ---------------------------------------------------------------------------------------

    def _move(self, state: str, base: Base, left_s: float, share: float) -> float:
        """Go on with an action of the crane until it ends, at most ``left_s``; return how long that was."""
        crane = self._rig.crane
        if self._sent_for != state:
            self._sent_for, self._picture_left_s = state, PICTURE_S
            try:
                crane.send(*self._poses(state, base))
            except OutOfReach as problem:
                self.log.append(("crane", f"{state}: out of reach, {problem}"))
                crane.send(dict(crane.pose))
                self._arrived(state, is_reached=state not in ("above-plant", "on-ground"))
                return 0.0
        if not crane.is_there:
            left_s = min(left_s, crane.time_left_s(SHARE[state] * share))
            crane.step(left_s, SHARE[state] * share)
        elif state == "photo" and self._picture_left_s > TINY_S:
            left_s = min(left_s, self._picture_left_s)
            self._picture_left_s -= left_s
            crane.halt()
        elif state == "dock" and not self._rig.in_arm:
            crane.halt()  # the arm is still on its way with the seedling
            return left_s
        else:
            left_s = 0.0
        if crane.is_there and (state != "photo" or self._picture_left_s <= TINY_S):
            self._arrived(state, is_reached=True)
        return left_s

    def _arrived(self, state: str, *, is_reached: bool) -> None:
        tuning = self._rig.tuning
        if state == "dock":
            self._docked()
        elif not is_reached or (state == "above-plant" and self._chance(tuning.fail_crane)):
            self._fail("FAIL_CRANE")
            self._send("crane_failed", "FAIL_CRANE")
        elif state == "on-ground" and self._chance(tuning.fail_ground):
            self._fail("FAIL_GROUND")
            self._send("no_ground", "FAIL_GROUND")
        else:
            if state == "photo":
                self._record()
            self._send(_DONE[state], "OK")

    def _docked(self) -> None:
        if not self._rig.in_arm:
            return
        if self._chance(self._rig.tuning.fail_dock):
            self._dock_tries += 1
            if self._dock_tries >= DOCK_TRIES:
                self._dock_tries, self.needs_person = 0, True
            self._send("dock_failed", "FAIL_DOCK")
            return
        self._dock_tries = 0
        self._send("docked", "OK")

    def _poses(self, state: str, base: Base) -> list[Pose]:
        crane = self._rig.crane
        if state == "transport":
            return [dict(TRANSPORT)]
        if state in ("dock-waypoint", "retract"):
            return [dict(WAYPOINT)]
        if state == "dock":
            return [dict(DOCK)]
        if state == "back-off":
            x, y, _ = crane.tip
            return [pose_for((x, y, BACK_OFF_M))]
        site = self._rig.site
        target = self._planted or (site.current if site is not None else None)
        if target is None:
            return [dict(crane.pose)]
        x, y = to_machine(base, (target.x_m, target.y_m))
        if state == "on-ground":
            return [pose_for((x, y, HOVER_M * part)) for part in (0.66, 0.33, 0.0)]
        if state == "photo":
            return [pose_for((x, y, HOVER_M)), pose_for((x - PHOTO_BACK_M, y, PHOTO_UP_M))]
        return [pose_for((x, y, CARRY_M)), pose_for((x, y, HOVER_M))]

    # ---- outcomes ----------------------------------------------------------------------------------------

    def _fail(self, code: str) -> None:
        outcome, saved, text = FAILED[code]
        site = self._rig.site
        target = site.current if site is not None else None
        if site is not None and target is not None:
            site.mark(target.id, outcome, text)
            self._note(target, outcome, saved)

    def _record(self) -> None:
        """Note the tree that was planted last, once."""
        target, self._planted = self._planted, None
        if target is not None:
            self._note(target, "done", "SAVE_SUCCESS")

    def _note(self, target: Target, outcome: str, code: str) -> None:
        self.results.append(TreeResult(target, outcome, code, self._rig.stops, round(self._attempt_s, 1)))
        self._attempt_s = 0.0

    def _chance(self, share: float) -> bool:
        return share > 0 and self._rig.chance.random() < share

    def _send(self, event: str, result: str = "") -> bool:
        self._states.has_seedling = self._rig.in_head > 0
        self._states.fire(event, result)
        if result:
            node = "planter" if event in ("fed", "dropped", "planted", "scar_failed") else "crane"
            self.log.append((node, f"{event.replace('_', ' ')}: {result}"))
        return True
