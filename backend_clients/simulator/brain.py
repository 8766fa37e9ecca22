"""The brain of a robot of any family: what it does in each control step, and what makes it wait.

Orders come in through ``orders``; reports go out through ``reports``. Two times are used: the clock
for everything that protects people (leases, dead-man, lost operator), and the machine's own time,
which may be hastened while a mission runs, for everything that is work.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from backend_clients.edge.fields import Mode
from backend_clients.edge.messages_down import Mission
from backend_clients.simulator.action_log import ActionLog
from backend_clients.simulator.config import RobotConfig
from backend_clients.simulator.enu import EnuFrame, Point
from backend_clients.simulator.farm_ways import FarmWays
from backend_clients.simulator.faults import Faults
from backend_clients.simulator.guard import Guard
from backend_clients.simulator.journal import EventKind, Journal
from backend_clients.simulator.latch import Latch
from backend_clients.simulator.machine import Machine
from backend_clients.simulator.memory import Memory
from backend_clients.simulator.mission_run import MissionRun
from backend_clients.simulator.nodes import Nodes
from backend_clients.simulator.people_rules import check
from backend_clients.simulator.pilot import START_HORN_S, DriveState, Pilot
from backend_clients.simulator.route import straight
from backend_clients.simulator.state_folder import StateFolder
from backend_clients.simulator.tracking import Tracker, tracker_on
from backend_clients.simulator.watch import Watch
from backend_clients.simulator.work import work_of
from hmi.clock import Clock

if TYPE_CHECKING:
    from backend_clients.simulator.crane_task import CraneTask
    from backend_clients.simulator.machine_orders import JogState

FARM_HEARD_S = 3.0
LEAD_IN_M = 0.3  # nearer than this the tracker pulls it on the line while driving
CHARGER_REACH_M = 2.0
REASONS = {
    "paused": "by an operator",
    "operator_lost": "no page of its operator was open",
    "link_lost": "the farm was not heard",
    "battery_low": "the battery is low",
    "after_stop": "STOP",
    "manual": "for driving by hand",
    "return_home": "to return home",
    "low_charge": "to charge",
    "function_off": "a function it needs is off",
}


class Brain:
    """One boot of the robot's software, commanding ``machine``.

    Args:
        config: identity and home.
        machine: the body; it outlives a reboot.
        clock: the robot's clocks.
        store: what survives a reboot.
        faults: faults switched on by a tester.
        boot: id of this boot.
        make_challenge: source of challenges.
        ways: of the farm, for what drives home; ``None`` where there is no map, then it is a straight line.
    """

    def __init__(
        self,
        config: RobotConfig,
        machine: Machine,
        clock: Clock,
        store: StateFolder,
        faults: Faults,
        boot: str,
        make_challenge: Callable[[], str],
        ways: FarmWays | None = None,
    ) -> None:
        self.config, self.machine, self.clock, self.faults, self.boot = config, machine, clock, faults, boot
        self.profile, self._ways = config.profile, ways
        self.memory = Memory(store)
        self.work = work_of(self.profile, machine)
        self._boot_s = clock.mono_s()
        self.frame = EnuFrame(config.datum_lat_deg, config.datum_lon_deg)
        self.journal = Journal(boot)
        self.actions = ActionLog()
        self.nodes = Nodes(self.profile, faults, lambda node, line: self.journal.log(self.mono_ms(), line, node=node))
        self.drive: DriveState | None = None
        self.last_drive: DriveState = DriveState()
        self.run: MissionRun | None = None
        self.home_run: Tracker | None = None
        self.errand_is_supervised = True
        self.errand_name = "return-home"
        self.crane_task: CraneTask | None = None
        self.jog: JogState | None = None
        self.pilot = Pilot(self)
        self.hold_code = ""
        self.operator_heard_s = self.link_heard_s = clock.mono_s()
        self.is_button_known = False
        saved = self.memory.load_safety(boot)
        self.latch = Latch(saved.latch)
        self.braked_from_m: float | None = None  # driven when the latch was set; not known of a latch before this boot
        self.guard = Guard(make_challenge, lease_token=saved.lease_token, revoked_token=saved.revoked_token)
        self.memory.load_progress(self)
        self.watch = Watch(self)

    # ---- time and place -------------------------------------------------------------------------------

    def mono_ms(self) -> int:
        """Return the robot's monotonic time since boot."""
        return max(int((self.clock.mono_s() - self._boot_s) * 1000), 0)

    def mono_ms_of(self, mono_s: float) -> int:
        """Return a time of the clock as milliseconds since boot, never negative."""
        return max(int((mono_s - self._boot_s) * 1000), 0)

    @property
    def place(self) -> Point:
        """Where the machine truly stands."""
        return self.machine.base.x_m, self.machine.base.y_m

    # ---- what it is doing -----------------------------------------------------------------------------

    @property
    def is_stopped(self) -> bool:
        """Whether a STOP or the button on the machine forbids all motion."""
        return self.latch.is_set or self.machine.is_hardware_stop

    @property
    def is_auto(self) -> bool:
        """Whether it moves by itself now: a mission, the way home or to a place, or its crane."""
        return bool(self.errand) or (self.run is not None and self.run.status == "running")

    @property
    def errand(self) -> str:
        """What it does by itself instead of its mission, as its chart calls it; empty if nothing."""
        if self.crane_task is not None:
            return "move-crane"
        return self.errand_name if self.home_run is not None else ""

    @property
    def mode(self) -> Mode:
        """The operating mode as reported."""
        if self.is_stopped:
            return "stopped"
        if self.machine.soc <= 0:
            return "fault"
        if self.drive is not None:
            return "manual"
        if self.is_auto:
            return "auto"
        return "paused" if self.run is not None and self.run.status == "paused" else "idle"

    @property
    def is_farm_heard(self) -> bool:
        """Whether the console was heard lately."""
        return self.is_farm_known and self.clock.mono_s() - self.link_heard_s < FARM_HEARD_S

    @property
    def is_farm_known(self) -> bool:
        """Whether the console was ever heard since the boot: it may come up after the robot."""
        return self.link_heard_s > self._boot_s

    @property
    def is_on_lead(self) -> bool:
        """Whether it is on its way to the path of the mission."""
        return self.pilot.lead is not None

    @property
    def cross_track_m(self) -> float | None:
        """Distance from the line being followed, left positive; ``None`` while there is none."""
        tracker = self.pilot.tracker
        return tracker.left_of_line_m if tracker is not None and self.is_auto else None

    # ---- one step -------------------------------------------------------------------------------------

    def check_people(self) -> None:
        """Apply every rule that protects people; on the clock, never hastened."""
        check(self)

    def step(self, dt_s: float) -> None:
        """Decide, and let the machine live, for ``dt_s`` of its own time."""
        self.hold_code = ""
        run, machine = self.run, self.machine
        before_m, driven_m = run.tracker.s_m if run is not None else 0.0, machine.base.distance_m
        wanted = self.pilot.decide(dt_s)
        machine.is_charging = self._is_at_charger()
        machine.is_airborne = self._is_airborne()
        is_braking = wanted.v_mps == 0 and not wanted.is_pivoting
        machine.step(dt_s, wanted, is_braking=is_braking, tool_on=self.pilot.doing.tool_on)
        if self.pilot.followed is not None:
            self.pilot.followed.carry(machine.base, machine.base.distance_m - driven_m)
        if run is not None and run.status == "running" and self.pilot.lead is None and not self.errand:
            self._count(run, before_m, dt_s)
        self._note_rest()
        self.watch.look()

    def _note_rest(self) -> None:
        if self.run is None or not self.run.is_coming_to_rest:
            return
        is_driven = self.drive is not None and (self.drive.v_mps != 0 or self.drive.yaw_rate_radps != 0)
        if self.machine.base.is_still or is_driven:
            self.run.rest(self.place)
            self.save()

    def _count(self, run: MissionRun, before_m: float, dt_s: float) -> None:
        is_working = self.pilot.doing.is_working and (self.machine.tool_on or not self.pilot.doing.tool_on)
        run.advance(
            before_m,
            is_working=is_working,
            count=self.work.count(run, dt_s),
            journal=self.journal,
            mono_ms=self.mono_ms(),
            row=self.work.row,
        )

    # ---- what orders and rules do ---------------------------------------------------------------------

    def note(self, kind: EventKind, name: str, text: str = "", **data: Any) -> None:
        """Write one event, with where and when it happened."""
        lat_deg, lon_deg = self.frame.to_wgs84(*self.place)
        place = {"lat_deg": round(lat_deg, 8), "lon_deg": round(lon_deg, 8)}
        if self.run is not None and kind == "mission":
            place["mission_id"] = self.run.mission.mission_id  # type: ignore[assignment]
        self.journal.event(self.mono_ms(), kind, name, text, **{**data, **place})

    def load(self, mission: Mission) -> None:
        """Take a mission on board; moves nothing.

        Raises:
            RouteError: its path cannot be driven.
        """
        self.run = MissionRun(mission, self.frame, (self.config.x_m, self.config.y_m), self.profile)
        self.memory.save_mission(self.run)
        self.note("mission", "Mission loaded", mission.name)
        self.save()

    def renew(self, run: MissionRun) -> None:
        """Take a mission that goes on with what was done; moves nothing that does not move already."""
        if self.run is not None and self.run.status == "running" and run.status == "running":
            run.tracker.go_on_as(self.run.tracker)
        else:
            self.pilot.lead = None
        self.run = run
        self.memory.save_mission(run)
        self.note("mission", "Mission changed", run.mission.name, revision=run.mission.revision)
        self.save()

    def begin(self, *, is_supervised: bool) -> None:
        """Start the loaded mission, or rejoin its path after it was moved; the horn sounds first."""
        assert self.run is not None
        if self.run.status == "paused":
            self.run.rejoin(self.place)
            self.run.run(is_supervised=is_supervised)
        else:
            self.run.begin(is_supervised=is_supervised)
        self.pilot.lead = self._way_to(self.run.route.point_at(self.run.tracker.s_m))
        self._set_off()
        self.note("mission", "Mission started", self.run.mission.name)

    def resume(self, *, is_supervised: bool) -> None:
        """Go on with the paused mission; the horn sounds first."""
        assert self.run is not None
        self.run.run(is_supervised=is_supervised)
        if self.pilot.lead is None:
            self.pilot.lead = self._way_to(self.run.route.point_at(self.run.tracker.s_m))
        else:
            self.pilot.lead.align()
        self._set_off()
        self.note("mission", "Mission resumed", self.run.mission.name)

    def pause(self, code: str) -> None:
        """Stop what is driven by itself and keep its progress; ``code`` is the reason shown."""
        self.home_run = self.crane_task = None
        if self.run is not None and self.run.status == "running":
            self.run.pause(code)
            self.note("mission", "Mission paused", REASONS.get(code, ""), reason=code)
        self.actions.close("failed" if code != "paused" else "finished", REASONS.get(code, ""))
        self.save()

    def abort(self) -> None:
        """End the mission for good; it stays loaded and can be started from its beginning."""
        self.home_run = self.pilot.lead = self.crane_task = None
        if self.run is not None and self.run.is_open:
            self.run.status = "aborted"
            self.note("mission", "Mission aborted", self.run.mission.name)
        self.actions.close("failed", "aborted")
        self.save()

    def go_home(self, by: str = "return_home") -> None:
        """Drive home with the tool off; a running mission is paused where it is, ``by`` is the reason."""
        is_supervised = self.run.is_supervised if self.run is not None and self.run.is_open else True
        self.pause(by)
        self._travel("return-home", self._way_home(), is_supervised=is_supervised)
        self.note("mission", "Returning home")

    def go_to(self, point: Point) -> None:
        """Drive straight to a place with the tool off; somebody has to look on."""
        self._travel("go-to", [self.place, point], is_supervised=True)
        self.note("mission", "Going to a place")

    def move_crane(self, task: CraneTask) -> None:
        """Move the crane alone, after the horn; somebody has to look on."""
        self.errand_is_supervised, self.crane_task = True, task
        self._set_off()

    def crane_arrived(self) -> None:
        """The crane is where it was sent."""
        assert self.crane_task is not None
        self.note("mission", self.crane_task.name)
        self.crane_task = None
        self.actions.close("finished")
        self.pilot.horn_left_s = START_HORN_S  # before a mission goes on

    def _travel(self, errand: str, way: list[Point], *, is_supervised: bool) -> None:
        self.errand_name, self.errand_is_supervised = errand, is_supervised
        self.home_run = tracker_on(straight(way, self.profile.home_speed_mps, self.profile.motion))
        self._set_off()

    def _way_home(self) -> list[Point]:
        """Along roads and round what is closed, if it drives and knows the farm."""
        if self._ways is None or self.profile.motion.is_on_rails:
            return [self.place, self.home]
        return self._ways.way(self.frame, self.place, self.home)

    @property
    def home(self) -> Point:
        """Where home is, in the robot's frame."""
        return self.run.home if self.run is not None else (self.config.x_m, self.config.y_m)

    def open_drive(self) -> None:
        """Let a person drive; what runs by itself is paused and the laser goes off."""
        self.pause("manual")
        self.drive = DriveState(heard_s=-math.inf)
        self.operator_heard_s = self.clock.mono_s()
        self.note("mission", "Driving by hand")

    def close_drive(self) -> None:
        """End driving by hand; the machine brakes."""
        if self.drive is not None:
            self.drive = self.jog = None
            self.note("mission", "Driving by hand ended")
            self.save()

    def halt(self, code: str) -> None:
        """Brake now and end everything that could move it again: STOP and the button do this."""
        self.drive = self.jog = None
        self.pause("after_stop")
        self.guard.revoke()
        self.memory.save_safety(self)
        self.journal.log(self.mono_ms(), f"halt {code}")

    def save(self) -> None:
        """Write place and progress to disk."""
        self.memory.save(self)

    def button_changed(self) -> None:
        self.is_button_known = self.machine.is_hardware_stop
        if self.is_button_known:
            self.note("safety", "Button on the machine pressed")
            self.halt("hardware_stop")
        else:
            self.note("safety", "Button on the machine released")

    def _set_off(self) -> None:
        now = self.clock.mono_s()
        self.pilot.horn_left_s = START_HORN_S
        self.operator_heard_s = max(self.operator_heard_s, now)
        self.link_heard_s = max(self.link_heard_s, now)
        self.save()

    def _way_to(self, point: Point) -> Tracker | None:
        if math.dist(self.place, point) <= LEAD_IN_M:
            return None
        return tracker_on(straight([self.place, point], self.profile.lead_speed_mps, self.profile.motion))

    def _is_at_charger(self) -> bool:
        return self.machine.soc < 1.0 and self.is_at_home

    def _is_airborne(self) -> bool:
        """Whether it has to carry itself: a UAV anywhere but on its pad, or landed at the home of its mission."""
        is_flying = self.profile.energy.hover_w > 0 and self.machine.soc > 0
        return is_flying and not self.is_at_home and not self._rests_at(self.home)

    @property
    def is_at_home(self) -> bool:
        """Whether it stands in its bay and does not set off."""
        return self._rests_at((self.config.x_m, self.config.y_m))

    def _rests_at(self, point: Point) -> bool:
        is_at_rest = self.machine.base.is_still and not self.is_auto
        return is_at_rest and math.dist(self.place, point) < CHARGER_REACH_M
