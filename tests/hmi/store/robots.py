"""Robots for tests of the records."""

from __future__ import annotations

from hmi.domain.robot import (
    Battery,
    Gnss,
    LinkHealth,
    Mode,
    Order,
    OrderStatus,
    Pose,
    Robot,
    RobotState,
    Stamp,
    Telemetry,
)
from tests.hmi.store.conftest import FARM


def robot(
    at_s: float, *, robot_id: str = "weeder-01", speed_mps: float = 0.4, mode: Mode = Mode.AUTO, farm_id: str = FARM,
    cross_track_m: float | None = 0.01, path: tuple[str, ...] = ("Mission", "Treat row"), lat_deg: float = 52.5,
) -> Robot:  # fmt: skip
    """Return a robot as it was at ``at_s`` on the console's monotonic clock."""
    stamp = Stamp(at_s, at_s)
    pose = Pose(lat_deg, 5.7, 0.0, 0.0, 0.1, speed_mps, 0.0, stamp)
    telemetry = Telemetry(pose, Gnss("fixed", 0.015, 20, 1.0), Battery(0.8, None, False), None, cross_track_m, None)
    order = Order("mission-1", 1, "0" * 64, OrderStatus.RUNNING, 3, 62, 5, 1.0, 1000.0, 250.0, 10.0, None, True)
    state = RobotState(mode, path, at_s, 1, 0.4, order, (), None, stamp)
    link = LinkHealth(True, at_s, "c", at_s, "b", 0.05, 0.08, True)
    return Robot(robot_id, True, "Weeder 01", farm_id, link, telemetry=telemetry, state=state)
