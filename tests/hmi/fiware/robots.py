"""A robot with everything told, for what goes to the cloud."""

from __future__ import annotations

from hmi.domain.robot import (
    Battery,
    Fault,
    Gnss,
    LinkHealth,
    Mode,
    Order,
    OrderStatus,
    Pose,
    Robot,
    RobotState,
    SafetyState,
    Stamp,
    Telemetry,
    ToolState,
)

LAT, LON = 40.312546, -3.480860


def a_robot(
    robot_id: str, *, family: str = "weeder", text: str = "Row lost", soc: float = 0.8, speed_mps: float = 0.5,
    mode: Mode = Mode.AUTO, at_s: float = 1000.0, is_online: bool = True,
) -> Robot:  # fmt: skip
    """Return a robot at work that told everything at ``at_s`` of the console's clock."""
    stamp = Stamp(at_s, at_s)
    pose = Pose(LAT, LON, 1.0, 2.0, 0.5, speed_mps, 0.0, stamp)
    order = Order("m1", 1, "ab" * 32, OrderStatus.RUNNING, 3, 12, 4, 1.5, 400.0, 120.0, 88.0, 900.0, True)
    path = ("mission", "search", "way") if family == "uav" else ("mission", "treat-field", "row")
    return Robot(
        id=robot_id,
        is_registered=True,
        name=f"The {robot_id}",
        farm_id="hof",
        link=LinkHealth(is_online, at_s, "c", at_s, "boot", 0.05, 0.08, True),
        telemetry=Telemetry(pose, Gnss("fixed", 0.014, 18, 0.8), Battery(soc, 3600.0, False),
                            ToolState("on", True, 3.0, 41.0), 0.01, None),
        state=RobotState(mode, path, at_s, 0, 0.5, order, (Fault("F1", "high", text, ""),), None, stamp),
        safety=SafetyState(False, False, False, speed_mps, False, (), 0.4, stamp),
    )  # fmt: skip
