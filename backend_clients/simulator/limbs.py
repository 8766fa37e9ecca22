"""Joints of a camera head: they follow what the machine does, or the hand that moves them; each at its own speed."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from backend_clients.edge.machine import Joint
from backend_clients.simulator.joint_travel import moved_by_hand

AHEAD = {"tilt": -0.2}
"""Where a head looks that nobody moved."""


@dataclass(slots=True)
class Limbs:
    """Measured and planned joints; ``step`` moves them.

    ``hand`` is what a hand wants of them, rates by joint: empty holds them still, ``None`` leaves them to the machine.
    """

    joints: Sequence[Joint]
    pose: dict[str, float] = field(init=False)
    planned: dict[str, float] = field(init=False)
    is_moving: bool = False
    hand: Mapping[str, float] | None = None

    def __post_init__(self) -> None:
        self.pose = {joint.name: AHEAD.get(joint.name, 0.0) for joint in self.joints}
        self.planned = dict(self.pose)

    def look(self, **goals: float) -> None:
        """Plan to turn there; what this head has not is left out, limits hold."""
        for joint in self.joints:
            if joint.name in goals:
                low = joint.lower if joint.soft_lower is None else joint.soft_lower
                high = joint.upper if joint.soft_upper is None else joint.soft_upper
                self.planned[joint.name] = min(max(goals[joint.name], low), high)

    def step(self, dt_s: float) -> None:
        """Move on: x_t = x_(t-1) + v * dt."""
        self.is_moving = False
        if self.hand is not None:
            self._by_hand(self.hand, dt_s)
            return
        for joint in self.joints:
            at, goal = self.pose[joint.name], self.planned[joint.name]
            if at != goal:
                most = joint.max_rate * dt_s
                self.pose[joint.name] = goal if abs(goal - at) <= most else at + math.copysign(most, goal - at)
                self.is_moving = True

    def _by_hand(self, rates: Mapping[str, float], dt_s: float) -> None:
        for joint in self.joints:
            at = self.pose[joint.name]
            self.pose[joint.name] = moved_by_hand(joint, at, rates.get(joint.name, 0.0), dt_s)
            self.is_moving = self.is_moving or self.pose[joint.name] != at
        self.planned = dict(self.pose)
