"""Joints of a camera head that follow what the machine does; each moves at its own speed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from backend_clients.edge.machine import Joint


@dataclass(slots=True)
class Limbs:
    """Measured and planned joints; ``step`` moves them."""

    joints: Sequence[Joint]
    pose: dict[str, float] = field(init=False)
    planned: dict[str, float] = field(init=False)
    is_moving: bool = False

    def __post_init__(self) -> None:
        self.pose = {joint.name: 0.0 for joint in self.joints}
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
        for joint in self.joints:
            at, goal = self.pose[joint.name], self.planned[joint.name]
            if at != goal:
                most = joint.max_rate * dt_s
                self.pose[joint.name] = goal if abs(goal - at) <= most else at + math.copysign(most, goal - at)
                self.is_moving = True
