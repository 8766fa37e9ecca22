"""The planter's work: drive four metres, map the site, plant it, fold the crane, drive on.

It runs the supervisor of ``planter_chart``: its states decide what base, crane and tool may do.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from backend_clients.simulator.machine import STOPPED, Machine
from backend_clients.simulator.planter_chart import PlanterMachine
from backend_clients.simulator.planting_cycle import PlantingCycle, TreeResult
from backend_clients.simulator.planting_site import AREA_M, Site, Stretch, area_of, map_site
from backend_clients.simulator.planting_stops import Stops, width_of
from backend_clients.simulator.tracking import Setpoint
from backend_clients.simulator.verdict import Verdict, accepted, refused
from backend_clients.simulator.work import Doing, approach

if TYPE_CHECKING:
    from backend_clients.simulator.mission_run import MissionRun
    from backend_clients.simulator.planter_rig import PlanterRig

MOVE_MPS = 0.39  # between two sites
SETTLE_S, MAP_S = 0.2, 0.6
AT_STOP_M = 0.06
TREE_S, STOP_S = 70.0, 6.0  # of one attempt, and of each stop besides
SLOW = 0.5  # of its speed, with a person near
SLOW_MPS = 0.3
BEGIN_FROM_M = ELSEWHERE_M = 0.5


class Planting:
    """Works along the rows of a mission, site by site."""

    def __init__(self, machine: Machine) -> None:
        assert machine.rig is not None
        self.states = PlanterMachine()
        self.rig: PlanterRig = machine.rig
        self.cycle = PlantingCycle(self.states, self.rig)
        self._machine = machine
        self._stops: Stops | None = None
        self._settle_left_s, self._map_left_s = SETTLE_S, MAP_S
        self._fresh = 0
        self.is_at_site = False
        self.row: int | None = None

    # ---- what every work does --------------------------------------------------------------------------

    def guide(self, run: MissionRun, wanted: Setpoint, dt_s: float) -> Doing:
        """Return what base and tool shall do now; the crane moves in here and nowhere else while a mission runs."""
        if run.driven_m == 0 and run.tracker.s_m < BEGIN_FROM_M:
            self.rig.worked.clear()  # the mission begins from its first point
        stop = self._stop(run)
        if stop is None or run.tracker.s_m < stop.from_m:
            self._leave_site()
            return self._travel(wanted, dt_s)
        if self.is_at_site and abs(stop.stop_m - run.tracker.s_m) > ELSEWHERE_M:
            self.is_at_site = False  # it was moved meanwhile
            return Doing(STOPPED)
        self.row = stop.row
        self._be_at("plant-site")
        guard = self.rig.guard(self._machine.base, self._machine.person)
        share = SLOW if guard == "person-near" else 1.0
        if self.is_at_site:
            return self._plant(stop, dt_s, share)
        ahead_m = stop.stop_m - run.tracker.s_m
        if ahead_m > AT_STOP_M:
            return self._drive(wanted, ahead_m, dt_s, share)
        return self._open(run, stop, dt_s)

    def waits_for(self) -> str:
        """Wait for a tray, for a crane somebody brings back, for people who are too near, or for help."""
        machine, rig = self._machine, self.rig
        if machine.is_crane_at_limit:
            return "crane_limit"
        if self.cycle.needs_person:
            return "ask_person"
        if rig.guard(machine.base, machine.person) == "person-inside":
            return "person_inside"
        is_out = machine.seedlings == 0 and not rig.in_head and not rig.in_arm
        return "tray_empty" if is_out and "photo" not in self.states.active else ""

    def count(self, run: MissionRun, dt_s: float) -> float:
        """Return the trees planted."""
        fresh, self._fresh = self._fresh, 0
        return fresh

    # ---- what others ask -------------------------------------------------------------------------------

    def take_results(self) -> list[TreeResult]:
        """Return the attempts that ended since the last call."""
        found, self.cycle.results = self.cycle.results, []
        return found

    def interrupted(self) -> None:
        """The supervisor is somewhere else now: what was under way begins anew."""
        self.cycle.forget()
        self._settle_left_s, self._map_left_s = SETTLE_S, MAP_S

    def skip(self, target_id: str | None = None) -> Verdict:
        """Leave the current point for the next one, its seedling still held."""
        site = self.rig.site
        if target_id is not None and site is not None and site.current is not None and site.current.id != target_id:
            return refused("other_target")
        if "plant" in self.states.active:
            return refused("too_late")
        target = self.cycle.give_up("skipped", "Skipped by a person.")
        if target is None:
            return refused("no_target")
        self.states.fire("skip", "SKIPPED")
        return accepted("ok", f"Tree {target.id.removeprefix('tree-')} is left out.")

    def person_helped(self) -> None:
        """Somebody looked at what the machine asked for."""
        self.cycle.needs_person = False

    def work_left_s(self, run: MissionRun) -> float:
        """Return how long it will stand at the sites that are left."""
        if self._stops is None or self._stops.route is not run.route:
            self._stops = Stops(run)
        from_m = run.tracker.s_m - AT_STOP_M
        return self._stops.trees_left(from_m) * TREE_S + self._stops.length_left_m(from_m) * STOP_S / AREA_M

    # ---- on the way ------------------------------------------------------------------------------------

    def _travel(self, wanted: Setpoint, dt_s: float) -> Doing:
        if not self.rig.is_folded:
            self._be_at("plant-site")
            self.cycle.fold(dt_s, self._machine.base, 1.0)
            return Doing(STOPPED, tool_on=True)
        self._be_at("transit")
        self.row = None
        return Doing(wanted)

    def _drive(self, wanted: Setpoint, ahead_m: float, dt_s: float, share: float) -> Doing:
        is_fetching = self.rig.tuning.docks_while_driving and "drive" in self.states.active
        if not self.rig.is_folded and not is_fetching:
            self.cycle.fold(dt_s, self._machine.base, share)
            return Doing(STOPPED, tool_on=True)
        if "hold" in self.states.active:
            self.states.new_site = True
            self.states.fire("drive_on")
        if is_fetching:
            self._step_cycle(dt_s, share, may_fetch=True)
        if wanted.is_pivoting:
            return Doing(wanted, is_working=True)
        most = MOVE_MPS if share == 1.0 else SLOW_MPS
        v = approach(min(wanted.v_mps, most), ahead_m, self._machine.profile.motion.planned_decel_mps2)
        turn = wanted.yaw_rate_radps * (v / wanted.v_mps if wanted.v_mps else 0.0)
        return Doing(Setpoint(v, turn), tool_on=self.rig.crane.is_moving, is_working=True)

    def _open(self, run: MissionRun, stop: Stretch, dt_s: float) -> Doing:
        """Stand, settle, map the site."""
        states = self.states
        if not self._machine.base.is_still:
            return Doing(STOPPED, is_working=True)
        if "drive" in states.active:
            states.fire("arrived")
        if "settle" in states.active:
            self._settle_left_s -= dt_s
            if self._settle_left_s <= 1e-9:
                states.fire("settled")
        if "settle" not in states.active and "map-site" not in states.active:
            self._settle_left_s, self._map_left_s = SETTLE_S, MAP_S
            states.new_site = True
            states.fire("site_reached")
        elif "map-site" in states.active:
            self._map_left_s -= dt_s
            if self._map_left_s <= 1e-9:
                self._map(run, stop)
                states.new_site = False
                states.fire("mapped")
                self.is_at_site = True
        return Doing(STOPPED, tool_on=True, is_working=True)

    def _map(self, run: MissionRun, stop: Stretch) -> None:
        rig, width_m = self.rig, width_of(run)
        ends = (run.route.point_at(stop.from_m), run.route.point_at(stop.to_m))
        if rig.site is not None and rig.site.is_left and rig.site.row == stop.row and rig.site.is_around(ends[0]):
            return  # the same site, after an interruption
        rig.stops += 1
        rig.site = Site(rig.stops, stop.row, [(round(x, 3), round(y, 3)) for x, y in area_of(ends, width_m)])
        seed = f"{rig.seed}/{round(ends[0][0])}/{round(ends[0][1])}"
        most = rig.tuning.most_points
        map_site(rig.site, self._machine.base, width_m, seed, first_tree=rig.trees + 1, most=most, line=stop)
        rig.trees += len(rig.site.targets)

    # ---- at a site -------------------------------------------------------------------------------------

    def _plant(self, stop: Stretch, dt_s: float, share: float) -> Doing:
        site = self.rig.site
        before = site.planted if site is not None else 0
        self._step_cycle(dt_s, share)
        if site is not None:
            self._fresh += site.planted - before
        if (site is None or not site.is_left) and self.rig.is_folded and "crane-idle" in self.states.active:
            self.is_at_site = False
            assert self._stops is not None
            self.rig.worked.add(self._stops.key(stop))
        return Doing(STOPPED, tool_on=True, is_working=True)

    def _step_cycle(self, dt_s: float, share: float, *, may_fetch: bool = False) -> None:
        machine = self._machine
        taken = self.cycle.step(dt_s, machine.base, machine.seedlings, share, may_fetch=may_fetch)
        machine.seedlings = max(machine.seedlings - taken, 0)

    def _leave_site(self) -> None:
        self.is_at_site = False

    # ---- the supervisor --------------------------------------------------------------------------------

    def _be_at(self, state: str) -> None:
        """Bring the supervisor to driving or planting from wherever in the mission it is."""
        active = self.states.active
        if state in active or (state == "plant-site" and "map-site" in active):
            return
        if "begin" in active:
            self.states.fire("horn_sounded" if state == "transit" else "go_on_planting")
        elif "transit" in active:
            self.states.fire("row_begins")
        elif "plant-site" in active:
            self.states.fire("row_done")
        else:
            self.states.fire("go_on_driving" if state == "transit" else "go_on_planting")

    def _stop(self, run: MissionRun) -> Stretch | None:
        if self._stops is None or self._stops.route is not run.route:
            self._stops = Stops(run)
            self.is_at_site = False
        if self.is_at_site and self._current is not None:
            return self._current
        self._current = self._stops.next(run.tracker.s_m - AT_STOP_M, self.rig.worked)
        return self._current

    _current: Stretch | None = None
