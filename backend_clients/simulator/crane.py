"""The planter's crane: five joints that move at their own speeds, and the way back from a tip to joints.

Frame: the machine's, x forward and y left of its reference point, z above the ground. Slew 0 points backwards, where
the machine plants. The planting head hangs plumb from the stick's end; the tip is its lower end.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from backend_clients.edge.machine import Joint, Point3
from backend_clients.simulator.joint_travel import REACHED, is_beyond, moved_by_hand
from backend_clients.simulator.kinematics import wrap_rad

PILLAR_X_M, PILLAR_Z_M = -1.8, 2.4  # where the boom turns
BOOM_M, STICK_M, HEAD_M = 3.6, 2.6, 1.5
TELESCOPE_M = 3.6
STRETCH = 0.88  # of its length when the telescope is chosen: neither straight nor folded

JOINTS = (
    Joint(name="slew", label="Slew", lower=-3.0, upper=3.0, soft_lower=-2.85, soft_upper=2.85, max_rate=0.42),
    Joint(name="boom", label="Boom", lower=-0.5, upper=1.35, soft_lower=-0.4, soft_upper=1.26, max_rate=0.22),
    Joint(name="stick", label="Stick", lower=-2.7, upper=-0.15, soft_lower=-2.57, soft_upper=-0.28, max_rate=0.3),
    Joint(
        name="telescope",
        label="Telescope",
        unit="m",
        lower=0.0,
        upper=TELESCOPE_M,
        soft_lower=0.0,
        soft_upper=3.42,
        max_rate=0.5,
    ),
    Joint(name="rotator", label="Head", lower=-3.1, upper=3.1, soft_lower=-2.95, soft_upper=2.95, max_rate=0.9),
)
BY_NAME = {joint.name: joint for joint in JOINTS}
TRANSPORT = {"slew": 0.0, "boom": 1.1, "stick": -2.35, "telescope": 0.0, "rotator": 0.0}
"""Folded over the rear of the machine: it may drive."""
Pose = dict[str, float]


class OutOfReach(ValueError):
    """The tip cannot go there."""


def tip_of(pose: Mapping[str, float]) -> Point3:
    """Return where the tip is for the joints of ``pose``."""
    boom, stick = pose["boom"], pose["boom"] + pose["stick"]
    length_m = STICK_M + pose["telescope"]
    reach_m = BOOM_M * math.cos(boom) + length_m * math.cos(stick)
    z_m = PILLAR_Z_M + BOOM_M * math.sin(boom) + length_m * math.sin(stick) - HEAD_M
    return PILLAR_X_M - reach_m * math.cos(pose["slew"]), -reach_m * math.sin(pose["slew"]), z_m


def pose_for(tip: Point3, heading_rad: float = 0.0) -> Pose:
    """Return the joints that put the tip there, the head turned to ``heading_rad`` of the machine.

    Raises:
        OutOfReach: some joint would be beyond its soft limit.
    """
    x_m, y_m, z_m = tip[0] - PILLAR_X_M, tip[1], tip[2] + HEAD_M - PILLAR_Z_M
    slew, reach_m = math.atan2(-y_m, -x_m), math.hypot(x_m, y_m)
    far_m = math.hypot(reach_m, z_m)
    telescope_m = min(max(far_m / STRETCH - BOOM_M - STICK_M, 0.0), TELESCOPE_M)
    stick_m = STICK_M + telescope_m
    cosine = (far_m * far_m - BOOM_M * BOOM_M - stick_m * stick_m) / (2 * BOOM_M * stick_m)
    if not -1 < cosine < 1:
        raise OutOfReach(f"{far_m:.1f} m from the pillar")
    bend = math.acos(cosine)
    boom = math.atan2(z_m, reach_m) + math.atan2(stick_m * math.sin(bend), BOOM_M + stick_m * math.cos(bend))
    pose = {
        "slew": slew,
        "boom": boom,
        "stick": -bend,
        "telescope": telescope_m,
        "rotator": wrap_rad(heading_rad - slew),
    }
    for joint in JOINTS:
        if is_beyond(joint, pose[joint.name]):
            raise OutOfReach(f"{joint.label} would be at {pose[joint.name]:.2f} {joint.unit}")
    return pose


@dataclass(slots=True)
class Crane:
    """Joints as they are and where they shall go; they move by ``step`` and ``jog`` only.

    ``speed`` is times the usual speed of every joint.
    """

    speed: float = 1.0
    pose: Pose = field(default_factory=lambda: dict(TRANSPORT))
    planned: Pose = field(default_factory=lambda: dict(TRANSPORT))
    path: list[Pose] = field(default_factory=list)
    is_moving: bool = False

    @property
    def tip(self) -> Point3:
        """Where the tip is, in the machine's frame."""
        return tip_of(self.pose)

    @property
    def is_there(self) -> bool:
        """Whether every joint is where it was sent."""
        return not self.path and all(abs(self.pose[one] - at) < REACHED for one, at in self.planned.items())

    def send(self, *poses: Pose) -> None:
        """Plan to move through ``poses``; moves nothing yet."""
        self.path = list(poses[1:])
        self.planned = dict(poses[0])

    def time_left_s(self, share: float = 1.0) -> float:
        """Return how long it takes to the next pose it was sent through, at ``share`` of its speed."""
        speed = self.speed * share
        return max(abs(self.pose[one] - at) / (BY_NAME[one].max_rate * speed) for one, at in self.planned.items())

    def step(self, dt_s: float, share: float = 1.0) -> None:
        """Move on towards what is planned, every joint at ``share`` of its speed: x_t = x_(t-1) + v * dt."""
        self.is_moving = False
        if self.is_there:
            return
        for name, goal in self.planned.items():
            at = self.pose[name]
            most = BY_NAME[name].max_rate * self.speed * share * dt_s
            self.pose[name] = goal if abs(goal - at) <= most + REACHED else at + math.copysign(most, goal - at)
        self.is_moving = True
        if self.path and all(abs(self.pose[one] - at) < REACHED for one, at in self.planned.items()):
            self.planned = dict(self.path.pop(0))

    def jog(self, rates: Mapping[str, float], dt_s: float) -> None:
        """Move by hand: a soft limit slows what goes further out, a limit stops it; what was planned is forgotten."""
        for name, rate in rates.items():
            at = self.pose[name]
            self.pose[name] = moved_by_hand(BY_NAME[name], at, rate, dt_s)
            self.is_moving = self.is_moving or self.pose[name] != at
        self.planned, self.path = dict(self.pose), []

    def push(self, name: str, share: float) -> None:
        """Let a joint be at ``share`` of its travel, as after a mistake: what was planned is forgotten."""
        joint = BY_NAME[name]
        self.pose[name] = joint.lower + share * (joint.upper - joint.lower)
        self.planned, self.path = dict(self.pose), []

    def pull_back(self) -> None:
        """Bring what is beyond a soft limit back to it."""
        for name in self.beyond():
            joint = BY_NAME[name]
            assert joint.soft_lower is not None
            assert joint.soft_upper is not None
            self.pose[name] = min(max(self.pose[name], joint.soft_lower), joint.soft_upper)
        self.planned, self.path = dict(self.pose), []

    def halt(self) -> None:
        """Stand where it is; what was planned is kept to be seen."""
        self.is_moving = False

    def beyond(self) -> list[str]:
        """Return the joints outside their soft limits."""
        return [joint.name for joint in JOINTS if is_beyond(joint, self.pose[joint.name])]
