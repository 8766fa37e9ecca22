"""Looks at robots when they change and once a second when they are silent, and tells the alarms what holds.

Cheap on purpose: a robot with nothing wrong costs a few comparisons a look.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

from hmi.clock import Clock
from hmi.domain.alarm.alarm import CONSOLE, Alarm
from hmi.domain.alarm.conditions import Change, Conditions
from hmi.domain.alarm.finding import NOTHING, Finding, Findings
from hmi.domain.event import RobotEvent
from hmi.domain.robot import Robot
from hmi.ingest.supervision.faults import Faults
from hmi.ingest.supervision.silence import AllSilent
from hmi.ingest.supervision.view import MakeRules, Mission, MissionOf, Rule, View
from hmi.store.fleet import FleetStore

MISSION_S = 2.0  # figures of a mission change when it is planned anew
SILENT_S = 0.9  # robots that speak are looked at twice a second; the round looks at the others
ROBOTS_A_STEP = 100  # some 10 ms; thousands at once would keep people waiting
RESTORED = "restored"  # the reporter that speaks for those of before a restart until they have looked
log = logging.getLogger(__name__)


@dataclass(slots=True)
class _Watched:
    """What is known of one source: what each rule and each reporter found last."""

    rules: Sequence[Rule] = ()
    found: list[Findings] = field(default_factory=list)
    told: dict[str, Findings] = field(default_factory=dict)
    looked_s: float = float("-inf")
    mission: Mission | None = None
    mission_id: str = ""
    asked_s: float = float("-inf")

    def all(self) -> Sequence[Finding]:
        """Return everything that holds."""
        if not self.told and not any(self.found):
            return ()
        return [one for some in (*self.found, *self.told.values()) for one in some]


class Watch:
    """The supervision of all robots of a console.

    Args:
        make_rules: makes the rules of one robot.
        mission_of: stored mission by id, from memory.
        tell: takes what came and went.
    """

    def __init__(
        self,
        fleet: FleetStore,
        clock: Clock,
        conditions: Conditions,
        make_rules: MakeRules,
        mission_of: MissionOf,
        tell: Callable[[list[Change]], None],
    ) -> None:
        self._fleet, self._clock, self._conditions, self._tell = fleet, clock, conditions, tell
        self._make_rules, self._mission_of = make_rules, mission_of
        self._watched: dict[str, _Watched] = {}
        self._silence = AllSilent(fleet.is_online, fleet.said_goodbye)

    def see(self, robot: Robot) -> None:
        """Look at a robot that changed; on the event loop, does not wait."""
        if robot.is_registered:
            self._look(robot, self._clock.mono_s())

    def see_event(self, event: RobotEvent) -> None:
        """Take an event of a robot."""
        robot = self._fleet.robot(event.robot_id)
        if robot is None or not robot.is_registered:
            return
        heard = [rule.hear(event) for rule in self._of(robot.id).rules if isinstance(rule, Faults)]
        if any(heard):
            self._look(robot, self._clock.mono_s())

    def report(self, source: str, reporter: str, findings: Findings) -> None:
        """Take everything that one reporter finds at a source now, at once."""
        watched = self._of(source)
        if findings:
            watched.told[reporter] = findings
        elif watched.told.pop(reporter, None) is None:
            return
        self._settle(source, watched, self._clock.mono_s())

    def sweep(self) -> None:
        """Look at every robot that was not looked at lately, and let delays run out; see ``sweeping``."""
        for _ in self.sweeping():
            pass

    def sweeping(self) -> Iterator[None]:
        """Do so in steps, once a second; between two of them others may have the event loop."""
        now_s = self._clock.mono_s()
        registered = set(self._fleet.registered_ids())
        # before the robots one by one: what explains all of them has to be known first
        self.report(CONSOLE, "silence", self._silence.look(registered, now_s))
        for number, robot_id in enumerate(registered, 1):
            robot = self._fleet.robot(robot_id)
            if robot is not None and robot.is_registered and now_s - self._of(robot_id).looked_s >= SILENT_S:
                self._look(robot, now_s)
            if number % ROBOTS_A_STEP == 0:
                yield
                now_s = self._clock.mono_s()  # what was heard meanwhile is not of the future
        registered = set(self._fleet.registered_ids())
        for source in [s for s in self._watched if s not in registered and self._watched[s].rules]:
            self.forget(source)
        self._tell(self._conditions.pass_time(now_s))

    def forget(self, source: str) -> None:
        """Let everything of a source go that is no more."""
        self._watched.pop(source, None)
        self._tell(self._conditions.forget(source))

    def restore(self, alarm: Alarm) -> None:
        """Take over a condition that held before a restart; it holds until its rule or reporter can tell otherwise."""
        key = alarm.key
        finding = Finding(key.code, alarm.text, key.detail, alarm.priority, alarm.advice)
        self._conditions.restore(key, finding)
        watched = self._of(key.source)
        for number, rule in enumerate(watched.rules):
            if key.code in rule.codes:
                watched.found[number] = (*watched.found[number], finding)
                return
        watched.told[RESTORED] = (*watched.told.get(RESTORED, NOTHING), finding)

    def let_go_restored(self, is_judged: Callable[[str, str], bool]) -> None:
        """Let go what was restored and no rule watches, where all who report it have looked since.

        Args:
            is_judged: whether they have, by source and type.
        """
        for source in [one for one, watched in self._watched.items() if RESTORED in watched.told]:
            held = self._watched[source].told[RESTORED]
            open_ones = tuple(one for one in held if not is_judged(source, one.code))
            if len(open_ones) < len(held):
                self.report(source, RESTORED, open_ones)

    def _of(self, source: str) -> _Watched:
        watched = self._watched.get(source)
        if watched is None:
            watched = self._watched[source] = _Watched()
        if not watched.rules and source != CONSOLE and self._fleet.registration(source) is not None:
            watched.rules = self._make_rules()
            watched.found = [NOTHING] * len(watched.rules)
        return watched

    def _look(self, robot: Robot, now_s: float) -> None:
        watched = self._of(robot.id)
        watched.looked_s = now_s
        view = View(robot, now_s, self._mission(watched, robot, now_s))
        for number, rule in enumerate(watched.rules):
            try:
                found = rule.look(view)
            except Exception:  # one rule that cannot cope must not silence the others
                log.exception("rule %s failed on %s", type(rule).__name__, robot.id)
                continue
            if found is not None:
                watched.found[number] = found
        self._settle(robot.id, watched, now_s)

    def _mission(self, watched: _Watched, robot: Robot, now_s: float) -> Mission | None:
        order = robot.state.order if robot.state is not None else None
        if order is None:
            return None
        if order.mission_id != watched.mission_id or now_s - watched.asked_s >= MISSION_S:
            watched.mission_id, watched.asked_s = order.mission_id, now_s
            watched.mission = self._mission_of(order.mission_id)
        return watched.mission

    def _settle(self, source: str, watched: _Watched, now_s: float) -> None:
        changes = self._conditions.see(source, watched.all(), now_s)
        if changes:
            self._tell(changes)
