"""A console's queue with robots that take missions, drive them and tell; all clocks move only when told."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, cast

from hmi.app.queue import QueueDesk
from hmi.clock import FakeClock
from hmi.commands.desk import CommandDesk, CommandPorts
from hmi.commands.mission_book import MissionBook, MissionParts
from hmi.commands.queue_book import EntryOrder
from hmi.domain.command import Acknowledgement, Action, CommandOrder, Order
from hmi.domain.freshness import TickRing
from hmi.domain.mission import MissionStatus
from hmi.domain.mission_document import mission_sha256
from hmi.domain.queue.entry import Conditions, Entry
from hmi.domain.robot import Battery, Family, Gnss, Mode, OrderStatus, Pose, Robot, Stamp, Telemetry
from hmi.domain.robot import Order as MissionOrder
from hmi.domain.role import Role
from hmi.planning.mission import plan_mission
from hmi.security.authorization import Authorizer
from hmi.security.session_info import SessionInfo
from hmi.settings import Settings
from hmi.store.database import Database
from hmi.store.features import Features
from hmi.store.maps import Maps
from hmi.store.mission_tracking import MissionTracking
from hmi.store.missions import Mission, Missions
from hmi.store.robots import RegisteredRobot, Robots
from hmi.store.stop_list import StopList
from hmi.store.users import Users
from tests.hmi.commands.field import FARM, AuditLog, FakeRobot, Wire, person
from tests.hmi.missions.rig import HerePlanner
from tests.hmi.missions.test_document import wish

PIETER = person("Pieter Bos", Role.OPERATOR)
MORNING = datetime(2026, 6, 15, 8, 0, tzinfo=UTC)  # a Monday, 10:00 in Amsterdam
EASY = Conditions(battery_reserve=None, needs_rtk=False)


class FieldRobot(FakeRobot):
    """A robot that holds missions and drives them."""

    def take(self, document: dict[str, Any], sha256: str) -> None:
        """Store a mission as a robot does."""
        self.mission = MissionOrder(
            document["mission_id"], 1, sha256, OrderStatus.LOADED, 0, 4, 0, 0.0, 1e3, 0.0, 0.0, None, True
        )

    def drive(self, order: CommandOrder) -> None:
        """Begin."""
        self.tell(OrderStatus.RUNNING, Mode.AUTO)
        assert self.mission is not None
        self.mission = replace(self.mission, is_supervised=order.is_supervised)

    def tell(self, status: OrderStatus, mode: Mode = Mode.IDLE) -> None:
        """Report another state of the mission."""
        assert self.mission is not None
        self.mission, self.mode = replace(self.mission, status=status), mode

    @property
    def starts(self) -> list[CommandOrder]:
        """The starts that reached it."""
        return [o for o in self.orders if isinstance(o, CommandOrder) and o.action is Action.START]

    @property
    def holds(self) -> str | None:
        """The mission it holds."""
        return None if self.mission is None else self.mission.mission_id


class FieldWire(Wire):
    """Carries missions too."""

    def __init__(self, robots: dict[str, FieldRobot]) -> None:
        super().__init__(cast("dict[str, FakeRobot]", robots))
        self._field = robots

    def send(self, order: Order) -> bool:
        """Deliver; a start that the robot takes lets it drive."""
        robot, before = self._field[order.robot_id], len(self._field[order.robot_id].done)
        is_sent = super().send(order)
        if isinstance(order, CommandOrder) and order.action is Action.START and len(robot.done) > before:
            robot.drive(order)
        return is_sent

    async def upload_mission(self, robot_id: str, document: dict[str, Any]) -> Acknowledgement:
        """Store and read back."""
        robot = self._field[robot_id]
        if robot.refuse_with is None:
            robot.stored_sha256 = mission_sha256(document)
        answer = await super().upload_mission(robot_id, document)
        if answer.is_accepted:
            robot.take(document, str(answer.sha256))
        return answer


@dataclass
class Kept:
    """What ``Records`` is to the queue."""

    database: Database
    robots: Robots
    missions: Missions
    users: Users
    audit: AuditLog = field(default_factory=AuditLog)


class _Fleet:
    """The farm's robots as the fleet store shows them."""

    def __init__(self, farm: QueueFarm) -> None:
        self.robot, self.robots = farm.robot, farm.seen


class QueueFarm:
    """One console with one queue; ``again`` is the console after a restart."""

    def __init__(self, folder: Path, clock: FakeClock) -> None:
        self.folder, self.clock = folder, clock
        self.robots: dict[str, FieldRobot] = {}
        self.soc, self.fix = 0.9, "fixed"
        self.events: list[dict[str, Any]] = []
        self.ticks = TickRing("console1", clock.mono_s, clock.utc)

    @classmethod
    async def open(cls, folder: Path) -> QueueFarm:
        """Start for the first time."""
        made = cls(folder, FakeClock(MORNING))
        made.build(epoch=1)
        await made.database.run(made.kept.users.add, "pieter", FARM, "Pieter Bos", Role.OPERATOR, "x")
        made.put_robot("weeder-01", "Weeder 01")
        for number in (1, 2, 3):
            made.put_mission(f"wheat-{number}", f"Wheat {number}")
        await made.prepare()
        return made

    def build(self, *, epoch: int) -> None:
        """Put the console's parts together."""
        clock = self.clock
        self.database = Database(f"sqlite:///{self.folder / 'headland.db'}")
        robots = Robots(self.database, FARM, clock, StopList(self.database, FARM, self.folder / "stop"))
        self.missions = Missions(self.database, clock)
        self.kept = Kept(self.database, robots, self.missions, Users(self.database, clock))
        self.authorize = Authorizer(robots.of_any_farm)
        features = Features(self.database, clock)
        self.book = MissionBook(
            MissionParts(
                self.missions,
                features,
                self.database,
                self,
                HerePlanner(),
                self.kept.audit,
                self.authorize,
                clock,
                Maps(self.database, clock),
            )
        )
        self.wire = FieldWire(self.robots)
        self.desk = CommandDesk(
            CommandPorts(
                fleet=self,
                ticks=self.ticks,
                sender=self.wire,
                audit=self.kept.audit,
                missions=self.book,
                clock=clock,
                authorize=self.authorize,
                on_event=self.events.append,
                epoch=epoch,
                next_epoch=self._next_epoch,
                ack_limit_s=0.0,
            )
        )
        self.wire.desk = self.desk
        settings = Settings(demo=True, farm_id=FARM, time_zone="Europe/Amsterdam")  # type: ignore[call-arg]
        self.queue = QueueDesk(
            settings,
            clock,
            cast("Any", self.kept),
            cast("Any", _Fleet(self)),
            self.ticks,
            self.desk,
            self.book,
            self.authorize,
            self.events.append,
        )
        self.tracking = MissionTracking(self.missions, self.database, FARM)

    async def prepare(self) -> None:
        """Read everything into memory, as a console does at its start."""
        self.kept.robots.load()
        await self.book.load()
        await self.queue.prepare()

    async def again(self) -> None:
        """Restart the console: nothing in memory survives."""
        await self.close()
        self.ticks = TickRing("console2", self.clock.mono_s, self.clock.utc)
        self.build(epoch=2)
        await self.prepare()

    async def crash(self) -> None:
        """Let the console die without a word, and start it again."""
        await self.queue.runner.close()
        self.database.close()
        self.build(epoch=2)
        await self.prepare()

    async def close(self) -> None:
        """End the console."""
        await self.queue.stop()
        await self.desk.close()
        self.database.close()

    def put_robot(self, robot_id: str, name: str, *, is_unattended_allowed: bool = True) -> FieldRobot:
        """Register a robot that is heard."""
        self.kept.robots.add(
            RegisteredRobot(
                id=robot_id,
                farm_id=FARM,
                name=name,
                family=Family.WEEDER,
                added_by="admin",
                added_at=self.clock.utc(),
                is_unattended_allowed=is_unattended_allowed,
            )
        )
        robot = self.robots[robot_id] = FieldRobot(robot_id, self.clock, name)
        robot.beat()
        return robot

    def put_mission(self, mission_id: str, name: str, *, is_supervised: bool = False) -> Mission:
        """Store a mission that is ready."""
        planned = plan_mission(wish(mission_id=mission_id, name=name))
        now = self.clock.utc()
        mission = Mission(
            id=mission_id,
            farm_id=FARM,
            name=name,
            field_name="Home field",
            status=MissionStatus.VALIDATED,
            sha256=planned.sha256,
            created_by="Pieter Bos",
            created_at=now,
            updated_at=now,
            robot_id="weeder-01",
            is_supervised=is_supervised,
            statistics=planned.statistics,
        )
        return self.missions.add(mission, planned.document)

    @property
    def weeder(self) -> FieldRobot:
        """The first robot."""
        return self.robots["weeder-01"]

    def robot(self, robot_id: str) -> Robot | None:
        """Return what is known of one."""
        robot = self.robots.get(robot_id)
        if robot is None:
            return None
        stamp = Stamp(robot.heard_s or 0.0, robot.heard_s or 0.0)
        telemetry = Telemetry(
            Pose(51.78, 4.26, 0, 0, 0, robot.speed_mps, 0, stamp),
            Gnss(self.fix, 0.02, 20, 1.0),
            Battery(self.soc, None, False),
            None,
            None,
            None,
        )
        return replace(robot.known(), telemetry=telemetry)

    def registration(self, robot_id: str) -> RegisteredRobot | None:
        """Return the registry's entry."""
        return self.kept.robots.get(robot_id)

    def seen(self) -> list[Robot]:
        """Return every robot."""
        return [one for robot_id in self.robots if (one := self.robot(robot_id)) is not None]

    async def step(self, seconds: float = 1.0, *, stride_s: float = 1.0, hears: bool = True) -> None:
        """Let time pass in strides, with heartbeats, reports and looks of the queue."""
        left = seconds
        while left > 0:
            part = min(stride_s, left)
            left -= part
            self.clock.advance(part)
            for robot in self.robots.values():
                robot.own_s += part
                if hears:
                    robot.beat()
            await self.look()

    async def look(self) -> None:
        """Hear what robots report, then let the queue look once."""
        for one in self.seen():
            self.tracking.see(one)
            self.queue.see(one)
        await self.tracking.settle()
        await self.desk.tend()
        await self.queue.runner.look()
        await self.queue.runner.settled()

    async def add(self, mission_id: str, *, robot_id: str = "weeder-01", **more: Any) -> Entry:
        """Put a mission into the queue, to be started by the queue unless said otherwise."""
        order = EntryOrder(**{"is_unattended": True, "conditions": EASY, **more})
        return await self.queue.book.add(PIETER, mission_id, robot_id, order)

    async def arm(self, who: SessionInfo = PIETER, duration_s: float = 3600.0, *robots: str) -> None:
        """Slide to arm what is shown."""
        wanted = {robot: self.queue.store.revision(robot) for robot in robots or ("weeder-01",)}
        await self.queue.arming.arm(who, wanted, duration_s, self.ticks.issue().id)

    def is_armed(self, robot_id: str = "weeder-01") -> bool:
        """Say whether a queue is armed."""
        return self.queue.arming.book.of(robot_id) is not None

    def disarmed(self, robot_id: str = "weeder-01") -> str:
        """Return why a queue is not armed any more."""
        ended = self.queue.arming.book.ended(robot_id)
        return "" if ended is None else ended[0]

    def why(self, entry: Entry) -> str:
        """Return the sentence that is shown for an entry."""
        shown = self.queue.runner.shown(entry.id)
        return "" if shown is None else shown.verdict.waiting.text

    def code(self, entry: Entry) -> str:
        """Return the code of what it waits for."""
        shown = self.queue.runner.shown(entry.id)
        return "" if shown is None else shown.verdict.waiting.code

    def status(self, mission_id: str) -> str:
        """Return where a mission is."""
        mission = self.missions.known(mission_id)
        return "" if mission is None else mission.status.value

    def press_stop(self, stop_id: str = "stop-1", by: str = "Vera Lang", *robots: str) -> None:
        """Press STOP at robots, as the gateway does: only they know."""
        for robot_id in robots or ("weeder-01",):
            self.robots[robot_id].press(stop_id, by)

    async def _next_epoch(self) -> int:
        return 9
