"""The simulated world: robots that live by ``step(dt)`` and can crash and boot again."""

from __future__ import annotations

import random
import secrets
from collections.abc import Iterable
from pathlib import Path

from backend_clients.edge import messages_down as down
from backend_clients.edge import messages_up as up
from backend_clients.simulator import faults as fault_kinds
from backend_clients.simulator.brain import Brain
from backend_clients.simulator.cameras.sight import Sight
from backend_clients.simulator.config import RobotConfig
from backend_clients.simulator.farm_ways import FarmWays
from backend_clients.simulator.faults import Fault, Faults
from backend_clients.simulator.journal import Happening
from backend_clients.simulator.kinematics import Base
from backend_clients.simulator.limbs import Limbs
from backend_clients.simulator.machine import STOPPED, Machine
from backend_clients.simulator.orders import OrderDesk
from backend_clients.simulator.planter_rig import PlanterRig
from backend_clients.simulator.reports import Reporter
from backend_clients.simulator.state_folder import StateFolder
from hmi.clock import Clock

MAX_STEP_S = 0.1  # steering gets coarse above; hastened time is cut into steps of this
MAX_RAIL_STEP_S = 0.5  # what is not steered may take longer ones
AT_SITE_TICKS, RESTING_TICKS, LEAN_TICKS = 2, 4, 10  # of the world's steps, between two of the robot's


class Boot:
    """One run of the robot's software from power-up to crash."""

    def __init__(self, brain: Brain) -> None:
        self.brain = brain
        self.reporter = Reporter(brain)
        self.desk = OrderDesk(brain, self.reporter)


class SimRobot:
    """A machine and, while it is switched on, the software that commands it.

    Args:
        config: who it is.
        clock: its clocks.
        seed: makes its noise repeatable.
        state_dir: its folder on disk, ``None`` to keep state in memory only.
        ways: of the farm it drives on, if it knows them.
    """

    def __init__(
        self,
        config: RobotConfig,
        clock: Clock,
        *,
        seed: int = 1,
        state_dir: Path | None = None,
        ways: FarmWays | None = None,
    ) -> None:
        self.config, self.clock, self._ways = config, clock, ways
        self.faults = Faults()
        self.store = StateFolder(state_dir)
        noise = random.Random(f"noise/{config.id}/{seed}")  # noqa: S311
        profile = config.profile
        rig = PlanterRig(f"{config.id}/{seed}") if profile.work == "plant" else None
        limbs = Limbs(profile.joints) if rig is None and profile.joints and not config.is_lean else None
        self.machine = Machine(
            noise, self._first_place(), profile, config.soc, seedlings=profile.tray, rig=rig, limbs=limbs
        )
        saved = self.store.load_progress()
        if saved is not None:
            self.machine.soc = saved.soc
        self._boot_at_s: float | None = None
        self.stopped_at_s: float | None = None
        self.lived_s = 0.0  # of the world's time
        self.stepped_s, self.pace = clock.mono_s(), 1.0  # when it stepped last, and how fast its time runs
        self.sights: dict[str, Sight] = {}  # of its cameras, while somebody pulls pictures
        self.is_lazy = False  # lean and in its usual round: not looked at before its turn
        self.is_awake = False  # an order came; what it changes is not to wait for the next long step
        self.boot: Boot | None = self.power_up()

    def receive(self, order: down.Order, *, is_retained: bool = False) -> up.Ack | None:
        """Hand one order to the software; ``None`` too when it is switched off."""
        if not isinstance(order, down.Ping):
            self.is_awake = True
        return self.boot.desk.receive(order, is_retained=is_retained) if self.boot is not None else None

    def step(self, dt_s: float, speed: float = 1.0) -> None:
        """Live for ``dt_s`` of the clock; missions run ``speed`` times faster than that."""
        self.stepped_s = self.clock.mono_s()
        if self.boot is None:
            self.machine.step(dt_s, STOPPED, is_braking=True, tool_on=False)
            if self._boot_at_s is not None and self.clock.mono_s() >= self._boot_at_s:
                self.faults.clear("crash")
                self._boot_at_s = None
                self.boot = self.power_up()
        else:
            brain = self.boot.brain
            brain.check_people()
            self.pace = speed if brain.is_auto else 1.0
            left_s = dt_s * self.pace
            is_easy = self.machine.profile.motion.is_on_rails or self.is_resting or brain.work.is_at_site
            most_s = MAX_RAIL_STEP_S if is_easy else MAX_STEP_S
            while left_s > 1e-9:
                step_s = min(left_s, most_s)
                brain.step(step_s)
                left_s -= step_s
            brain.memory.save_sometimes(brain)
        self._note_standstill()

    @property
    def is_reachable(self) -> bool:
        """Whether its software runs and its network carries something."""
        return self.boot is not None and self.faults.silence is None

    @property
    def is_resting(self) -> bool:
        """Whether nothing moves and nothing is about to: it may live in longer steps."""
        boot = self.boot
        if boot is None or self._boot_at_s is not None or not self.machine.base.is_still:
            return False
        brain = boot.brain
        return not brain.is_auto and brain.drive is None and not brain.machine.tool_on

    @property
    def every_ticks(self) -> int:
        """How many of the world's steps it takes together; orders, braking and driving by hand never wait."""
        if self.is_awake:
            return 1
        if self.is_resting:
            return LEAN_TICKS if self.config.is_lean else RESTING_TICKS
        if self.boot is not None and self.boot.brain.is_auto and self.boot.brain.work.is_at_site:
            return AT_SITE_TICKS  # its base stands; what its crane does ends where it ends inside a step
        if not self.config.is_lean or self.boot is None:
            return 1
        return LEAN_TICKS if self.boot.brain.is_auto and self.boot.brain.drive is None else 1

    def take_events(self) -> list[Happening]:
        """Return the events that happened since the last call."""
        return self.boot.brain.journal.take() if self.boot is not None else []

    def set_fault(self, fault: Fault) -> None:
        """Switch a fault on."""
        self.faults.set(fault)
        match fault:
            case fault_kinds.RtkFloat():
                self.machine.is_rtk_float = True
            case fault_kinds.LowBattery():
                self.machine.soc = fault.soc
            case fault_kinds.ToolInterlock():
                self.machine.is_cover_open = True
            case fault_kinds.PersonAhead():
                self.machine.put_person_ahead(fault.distance_m)
            case fault_kinds.WeedUnsure():
                self.machine.is_unsure = True
            case fault_kinds.CraneLimit() if self.machine.rig is not None:
                self.machine.rig.crane.push("stick", fault_kinds.BEYOND_SHARE)
            case fault_kinds.TrayEmpty():
                self.machine.seedlings = min(fault.left, self.machine.profile.tray)
            case fault_kinds.HardwareStop():
                self.machine.is_hardware_stop = True
            case fault_kinds.KeepsMoving():
                self.machine.ignores_brakes = True
            case fault_kinds.WrongStartOrder() if self.boot is not None:
                brain = self.boot.brain
                if fault.node in brain.nodes.lives:
                    brain.nodes.start_too_early(fault.node, brain.mono_ms())
            case fault_kinds.Crash():
                self.crash(fault.reboot_after_s)

    def clear_fault(self, name: str | None = None) -> None:
        """Switch one fault, or all, off."""
        for fault in self.faults.clear(name):
            match fault:
                case fault_kinds.RtkFloat():
                    self.machine.is_rtk_float = False
                case fault_kinds.LowBattery():
                    self.machine.soc = max(self.machine.soc, 0.9)
                case fault_kinds.ToolInterlock():
                    self.machine.is_cover_open = False
                case fault_kinds.PersonAhead():
                    self.machine.person = None
                case fault_kinds.WeedUnsure():
                    self.machine.is_unsure = False
                case fault_kinds.CraneLimit() if self.machine.rig is not None:
                    self.machine.rig.crane.pull_back()
                case fault_kinds.TrayEmpty():
                    self.machine.seedlings = self.machine.profile.tray
                case fault_kinds.HardwareStop():
                    self.machine.is_hardware_stop = False
                case fault_kinds.KeepsMoving():
                    self.machine.ignores_brakes = False
                case fault_kinds.NodeFailure() | fault_kinds.WrongStartOrder() if self.boot is not None:
                    brain = self.boot.brain
                    brain.nodes.mend(fault.node, self.clock.mono_s(), brain.mono_ms())
                case fault_kinds.Crash() if self.boot is None:
                    self._boot_at_s = self.clock.mono_s()

    def crash(self, reboot_after_s: float | None) -> None:
        """Let the software die; the machine's brakes close by themselves, its hydraulics hold."""
        self.boot = None
        if self.machine.rig is not None:
            self.machine.rig.crane.halt()
        self._boot_at_s = None if reboot_after_s is None else self.clock.mono_s() + reboot_after_s

    def power_up(self) -> Boot:
        """Return the software as it starts on the machine as it stands."""
        # never from the seed: a replayed order of an earlier run must find neither its boot nor its challenge
        boot_id = secrets.token_hex(8)
        brain = Brain(self.config, self.machine, self.clock, self.store, self.faults, boot_id, _challenge, self._ways)
        return Boot(brain)

    def _first_place(self) -> Base:
        motion = self.config.profile.motion
        saved = self.store.load_progress()
        if saved is not None:
            return Base(saved.x_m, saved.y_m, saved.theta_rad, motion=motion)
        return Base(self.config.x_m, self.config.y_m, self.config.theta_rad, motion=motion)

    def _note_standstill(self) -> None:
        if not self.machine.base.is_still:
            self.stopped_at_s = None
        elif self.stopped_at_s is None:
            self.stopped_at_s = self.clock.mono_s()


def _challenge() -> str:
    return secrets.token_hex(8)


class World:
    """All robots of one process.

    Args:
        robots: the robots.
        clock: shared by all; only ``mono_s`` decides anything.
        seed, speed, state_dir: see ``SimulatorConfig``.
        ways: of the farm they share, if they know them.
    """

    def __init__(
        self,
        robots: Iterable[RobotConfig],
        clock: Clock,
        *,
        seed: int = 1,
        speed: float = 1.0,
        state_dir: Path | None = None,
        ways: FarmWays | None = None,
    ) -> None:
        self.clock, self.speed, self._count, self._lived_s = clock, speed, 0, 0.0
        self.robots = {
            config.id: SimRobot(
                config, clock, seed=seed, state_dir=state_dir / config.id if state_dir else None, ways=ways
            )
            for config in robots
        }

    def step(self, dt_s: float) -> None:
        """Let every robot live for ``dt_s`` of the clock; the caller moves the clock.

        Robots that rest, and lean ones, take several steps together, not all of them in the same one.
        """
        self._count += 1
        self._lived_s += dt_s
        for number, robot in enumerate(self.robots.values()):
            turn = self._count + number
            is_lazy = robot.is_lazy and not robot.is_awake
            if (is_lazy and turn % LEAN_TICKS) or turn % robot.every_ticks:
                continue
            due_s, robot.lived_s = self._lived_s - robot.lived_s, self._lived_s
            robot.is_awake = False
            robot.step(due_s, self.speed)
            robot.is_lazy = robot.config.is_lean and robot.every_ticks == LEAN_TICKS
