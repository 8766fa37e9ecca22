"""The crane moved alone by an order: retracted, or its tip sent to a place; the machine stands meanwhile."""

from __future__ import annotations

from typing import TYPE_CHECKING

from backend_clients.edge.machine import Point3
from backend_clients.simulator.crane import TRANSPORT, Crane, Pose, pose_for
from backend_clients.simulator.planting_site import CARRY_M, to_machine

if TYPE_CHECKING:
    from backend_clients.simulator.kinematics import Base

SHARE = 0.5  # of its speed: somebody looks at it


class CraneTask:
    """One movement; ``step`` goes on with it.

    Args:
        name: what it is called in events.
        poses: the way, pose by pose.
    """

    def __init__(self, name: str, crane: Crane, poses: list[Pose]) -> None:
        self.name = name
        self._crane = crane
        crane.send(*poses)

    def step(self, dt_s: float) -> None:
        """Move on."""
        self._crane.step(dt_s, SHARE)

    @property
    def is_done(self) -> bool:
        """Whether the crane is there."""
        return self._crane.is_there


def retract(crane: Crane) -> CraneTask:
    """Return the way back to the transport position."""
    return CraneTask("Crane retracted", crane, [dict(TRANSPORT)])


def send_tip(crane: Crane, base: Base, place: Point3) -> CraneTask:
    """Return the way of the tip to a place of the ENU frame, its height above the ground there: up, across, down.

    Raises:
        OutOfReach: a joint would be beyond its soft limit.
    """
    x_m, y_m = to_machine(base, (place[0], place[1]))
    z_m = max(place[2], 0.0)
    goal = pose_for((x_m, y_m, z_m))
    over = pose_for((x_m, y_m, max(z_m, CARRY_M)))
    return CraneTask("Crane sent to a place", crane, [over, goal])
