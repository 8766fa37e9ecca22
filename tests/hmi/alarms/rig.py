"""A room of alarms on a fake clock, fed with honest wire messages of robots that tests hold in their hands."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from hmi.app.witness import FleetWitness
from hmi.clock import FakeClock
from hmi.domain.alarm.catalogue import catalogue
from hmi.domain.alarm.conditions import Conditions
from hmi.domain.alarm.live_alarm import LiveAlarm, Step
from hmi.ingest.supervision.fence import Ground
from hmi.ingest.supervision.rules import rules_of
from hmi.ingest.supervision.view import Mission, Rule
from hmi.ingest.supervision.watch import Watch
from hmi.store.alarms import AlarmStore, Person
from tests.hmi.ingest.wire import FakeWireRobot
from tests.hmi.ingest.wire import Rig as WireRig

MARTHA = Person("Martha Keller", "Tablet 3")


class AlarmRig(WireRig):
    """Wire, fleet store, witness, watch and alarm store, as the console plugs them together."""

    def __init__(self, *registered: str) -> None:
        super().__init__(*registered)
        self.alarms = AlarmStore(self.clock, catalogue())
        self.steps: list[Step] = []
        self.alarms.listeners.append(self.steps.append)
        self.missions: dict[str, Mission] = {}
        self.ground: Ground | None = None
        self.conditions = Conditions(catalogue().__getitem__)
        self.watch = Watch(self.store, self.clock, self.conditions, self.rules, self.missions.get, self._apply)
        self._robots: dict[str, FakeWireRobot] = {}
        FleetWitness(self.store, self.clock, lambda _robot_id: None, [self.watch.see]).start()

    def rules(self) -> Sequence[Rule]:
        """Return the rules of a robot."""
        return rules_of(catalogue(), lambda: self.ground)

    def wire(self, robot_id: str = "weeder-01") -> FakeWireRobot:
        """Return the one robot of this id."""
        if robot_id not in self._robots:
            self._robots[robot_id] = self.robot(robot_id)
        return self._robots[robot_id]

    def beat(self, robot_id: str = "weeder-01", **telemetry: Any) -> None:
        """Let a heartbeat and telemetry of a robot arrive."""
        robot = self.wire(robot_id)
        self.say(robot.heartbeat())
        self.say(robot.telemetry(**telemetry))

    def run(self, seconds: float, *speaking: str, **telemetry: Any) -> None:
        """Let time pass in half seconds, with heartbeats of the robots that speak and a round each second."""
        for half in range(round(seconds * 2)):
            self.clock.advance(0.5)
            for robot_id in speaking:
                self.beat(robot_id, **telemetry)
            self.edge.look_after()
            if half % 2:
                self.round()

    def round(self) -> None:
        """Look at everything once, as the console does each second."""
        self.watch.sweep()
        self.alarms.pass_time()

    def states(self) -> dict[str, str]:
        """Return id and shown state of every alarm."""
        return {one.id: one.alarm.state.value for one in self.alarms.all()}

    def one(self, alarm_id: str) -> LiveAlarm:
        """Return one alarm."""
        return self.alarms.get(alarm_id)

    def _apply(self, changes: Any) -> None:
        self.alarms.apply(changes)


__all__ = ["MARTHA", "AlarmRig", "FakeClock"]
