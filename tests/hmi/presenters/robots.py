"""Robots in every state an operator can meet them in."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from hmi.domain.robot import (
    Battery,
    Factsheet,
    Family,
    Gnss,
    Hold,
    LinkHealth,
    Mode,
    Order,
    OrderStatus,
    Pose,
    Press,
    Robot,
    RobotState,
    SafetyState,
    Stamp,
    Telemetry,
    ToolState,
)

T = Stamp(1000.0, 1000.01)

SHEET = Factsheet(
    family=Family.WEEDER,
    name="Weeder",
    model="LW-2",
    software="1.0",
    datum_lat_deg=52.0,
    datum_lon_deg=5.0,
    length_m=2.6,
    width_m=1.8,
    height_m=1.5,
    base_to_front_m=1.4,
    track_m=1.5,
    max_speed_mps=1.67,
    max_accel_mps2=0.6,
    decel_mps2=1.2,
    max_yaw_rate_radps=0.8,
    turning_radius_m=0.0,
    can_reverse=True,
    can_pivot=True,
    tool_kind="laser",
    tool_label="Laser",
    tool_width_m=1.5,
    drive_deadman_s=0.5,
    operator_lost_pause_s=3.5,
    link_lost_pause_s=10.0,
    start_horn_s=3.0,
    keep_out_m=15.0,
    stop_effect="laser off, tracks brake",
)
LINK = LinkHealth(
    is_online=True,
    heard_s=1000.0,
    challenge="challenge",
    challenge_s=1000.0,
    boot="boot-aaaa",
    rtt_s=0.086,
    rtt_max_s=0.140,
    is_broker_up=True,
    rtt_at_s=999.5,
)
POSE = Pose(52.0, 5.0, 1.0, 2.0, 0.0, 0.42, 0.0, T)
FAST = Telemetry(
    pose=POSE,
    gnss=Gnss("fixed", 0.014, 27, 0.8),
    battery=Battery(0.68, 18600.0, is_charging=False),
    tool=ToolState("on", is_interlock_ok=True, rate_per_min=212.0, temperature_c=41.0),
    cross_track_m=0.009,
    obstacle_m=None,
)
ORDER = Order(
    mission_id="m-0412",
    revision=1,
    sha256="a" * 64,
    status=OrderStatus.RUNNING,
    row=37,
    rows=84,
    segment=73,
    segment_s_m=12.5,
    area_m2=12200.0,
    area_done_m2=5300.0,
    distance_m=4000.0,
    remaining_s=12360.0,
    is_supervised=True,
)
SAFE = SafetyState(
    hardware_stop=False,
    latched=False,
    standstill=False,
    speed_mps=0.42,
    tool_off=False,
    presses=(),
    stopping_distance_m=0.31,
    stamp=T,
)
STATE = RobotState(
    mode=Mode.AUTO,
    path=("Mission", "Treat row", "Laser firing"),
    path_since_s=962.0,
    lease_token=7,
    set_speed_mps=0.45,
    order=ORDER,
    faults=(),
    hold=None,
    stamp=T,
)
PRESS = Press("stop-0001", "Martha Keller", "Tablet 3", 990.0, is_reset=False)

RUNNING = Robot("weeder-01", True, "Weeder 01", "farm", LINK, SHEET, FAST, STATE, SAFE)


def ordered(status: OrderStatus, **values: Any) -> Order:
    """Return the mission in another state."""
    return replace(ORDER, status=status, **values)


def with_state(robot: Robot, **values: Any) -> Robot:
    """Return the robot with another operating state."""
    assert robot.state is not None
    return replace(robot, state=replace(robot.state, **values))


def with_safety(robot: Robot, **values: Any) -> Robot:
    """Return the robot with another safety state."""
    assert robot.safety is not None
    return replace(robot, safety=replace(robot.safety, **values))


def with_fast(robot: Robot, **values: Any) -> Robot:
    """Return the robot with other fast values."""
    assert robot.telemetry is not None
    return replace(robot, telemetry=replace(robot.telemetry, **values))


def at_speed(robot: Robot, speed_mps: float) -> Robot:
    """Return the robot at another speed."""
    return with_fast(robot, pose=replace(POSE, speed_mps=speed_mps))


HOLD_PAUSED = Hold("paused", "Paused by an operator.", "Resume the mission.", "operator")
HOLD_MOVED = Hold("moved_while_paused", "It was moved 3.1 m since the pause.", "Drive it back.", "operator")

IDLE = with_safety(with_state(RUNNING, mode=Mode.IDLE, order=None, path=("Idle",)), standstill=True)
LOADED = with_state(IDLE, order=ordered(OrderStatus.LOADED))
DONE = with_state(IDLE, order=ordered(OrderStatus.DONE))
PAUSED = with_state(
    with_safety(RUNNING, standstill=True), mode=Mode.PAUSED, order=ordered(OrderStatus.PAUSED), hold=HOLD_PAUSED
)
MOVED = with_state(PAUSED, hold=HOLD_MOVED)
GOING_HOME = with_state(RUNNING, order=ordered(OrderStatus.PAUSED), path=("Return home",))
MANUAL = with_state(
    RUNNING, mode=Mode.MANUAL, order=ordered(OrderStatus.PAUSED), path=("Paused", "Manual"), set_speed_mps=0.2
)
BRAKING = with_safety(with_state(RUNNING, mode=Mode.STOPPED), latched=True, presses=(PRESS,))
LATCHED = with_safety(BRAKING, standstill=True, tool_off=True, speed_mps=0.0)
BUTTON = with_safety(LATCHED, hardware_stop=True)
FAULTY = with_state(RUNNING, mode=Mode.FAULT)
SILENT = replace(RUNNING, link=replace(LINK, is_online=False))
BROKERLESS = replace(SILENT, link=replace(LINK, is_online=False, is_broker_up=False))
STRANGER = replace(RUNNING, is_registered=False)
NEVER_HEARD = Robot(
    "weeder-02",
    True,
    "Weeder 02",
    "farm",
    LinkHealth(False, None, None, None, None, None, None, True),
)
EVERY = {
    "running": RUNNING,
    "idle": IDLE,
    "loaded": LOADED,
    "done": DONE,
    "paused": PAUSED,
    "moved": MOVED,
    "going home": GOING_HOME,
    "manual": MANUAL,
    "braking": BRAKING,
    "latched": LATCHED,
    "button": BUTTON,
    "faulty": FAULTY,
    "silent": SILENT,
    "brokerless": BROKERLESS,
    "stranger": STRANGER,
    "never heard": NEVER_HEARD,
}
