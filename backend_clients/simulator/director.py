"""Plays situations on the robots of a farm: those a person asks for, and by itself a few that come and go."""

from __future__ import annotations

import random
from collections.abc import Mapping
from dataclasses import dataclass

from backend_clients.simulator.faults import name_of
from backend_clients.simulator.situations import BY_ID, SITUATIONS, Situation
from backend_clients.simulator.world import SimRobot
from hmi.clock import Clock

LOOK_EVERY_S = 1.0
SETTLED_S = 12.0  # robots have begun to work before anything happens to them
BETWEEN_S = (12.0, 30.0)
REST_S = 180.0  # of one robot between two situations
AT_ONCE = 4  # so that about as many robots need somebody


@dataclass(slots=True)
class Scene:
    """One situation that is on; ``until_s`` is ``None`` where a person ends it."""

    situation: Situation
    until_s: float | None


class Director:
    """Keeps at most one situation a robot.

    Args:
        robots: all robots of the world.
        players: ids of robots to which things happen by themselves; none plays nothing by itself.
        opening: what happens first, by robot id.
    """

    def __init__(
        self,
        robots: Mapping[str, SimRobot],
        clock: Clock,
        *,
        players: frozenset[str] = frozenset(),
        opening: Mapping[str, str] | None = None,
        seed: int = 1,
    ) -> None:
        self._robots, self._clock = robots, clock
        self._players = sorted(players & robots.keys())
        self._opening = dict(opening or {})
        self._rng = random.Random(f"director/{seed}")  # noqa: S311
        self._scenes: dict[str, Scene] = {}
        self._rested_s: dict[str, float] = {}
        self._looked_s = clock.mono_s()
        self._next_s = clock.mono_s() + SETTLED_S

    def now(self) -> dict[str, str]:
        """Return which situation each robot is in; robots without one are left out."""
        return {robot_id: scene.situation.id for robot_id, scene in self._scenes.items()}

    def provoke(self, robot_id: str, situation_id: str | None) -> None:
        """Play a situation until it is ended by ``None``, in place of the one that is on.

        Raises:
            KeyError: there is no such robot or situation.
            ValueError: it cannot happen to this machine.
        """
        robot = self._robots[robot_id]
        situation = BY_ID[situation_id] if situation_id is not None else None
        if situation is not None and robot.config.family not in situation.families:
            raise ValueError(f"{situation.title} cannot happen to a {robot.config.family}")
        self._end(robot_id)
        if situation is not None:
            self._begin(robot_id, situation, None)

    def look(self) -> None:
        """End what is over, begin what is due."""
        now_s = self._clock.mono_s()
        if now_s - self._looked_s < LOOK_EVERY_S:
            return
        self._looked_s = now_s
        for robot_id, scene in list(self._scenes.items()):
            if self._is_over(robot_id, scene, now_s):
                self._end(robot_id)
        if now_s >= self._next_s and self._players:
            self._next_s = now_s + self._rng.uniform(*BETWEEN_S)
            self._play(now_s)

    def _is_over(self, robot_id: str, scene: Scene, now_s: float) -> bool:
        robot = self._robots[robot_id]
        if not robot.faults.is_on(name_of(scene.situation.fault)):
            return True  # it rebooted, or a tester mended it
        if scene.situation.id == "crane-limit" and not robot.machine.is_crane_at_limit:
            return True  # somebody drove it free
        return scene.until_s is not None and now_s >= scene.until_s

    def _play(self, now_s: float) -> None:
        if self._opening:
            played = [one for one in self._opening if self._is_at_work(one, now_s)]
            for robot_id in played:
                situation = BY_ID[self._opening.pop(robot_id)]
                self._begin(robot_id, situation, now_s + self._rng.uniform(*situation.lasts_s))
            if played:
                return
        by_itself = sum(scene.until_s is not None for scene in self._scenes.values())
        free = [one for one in self._players if self._is_at_work(one, now_s)]
        if by_itself >= AT_ONCE or not free:
            return
        robot_id = self._rng.choice(free)
        family = self._robots[robot_id].config.family
        known = [one for one in SITUATIONS if one.weight > 0 and family in one.families]
        [situation] = self._rng.choices(known, [one.weight for one in known])
        self._begin(robot_id, situation, now_s + self._rng.uniform(*situation.lasts_s))

    def _is_at_work(self, robot_id: str, now_s: float) -> bool:
        boot = self._robots[robot_id].boot
        is_rested = now_s - self._rested_s.get(robot_id, -REST_S) >= REST_S
        is_free = robot_id not in self._scenes and is_rested
        return boot is not None and is_free and boot.brain.is_auto and not boot.brain.hold_code

    def _begin(self, robot_id: str, situation: Situation, until_s: float | None) -> None:
        self._robots[robot_id].set_fault(situation.fault)
        self._scenes[robot_id] = Scene(situation, until_s)

    def _end(self, robot_id: str) -> None:
        scene = self._scenes.pop(robot_id, None)
        if scene is not None:
            self._rested_s[robot_id] = self._clock.mono_s()
            self._robots[robot_id].clear_fault(name_of(scene.situation.fault))
