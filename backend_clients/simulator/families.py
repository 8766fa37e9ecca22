"""The three families: a laser weeder, a tree planter with a crane, and a UAV.

Sources: published data of a laser-weeding robot, of a planting machine, and of an emergency service with UAVs
(docs/simulator.md names what is assumed).
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

from backend_clients.edge import messages_up as up
from backend_clients.edge.machine import Joint
from backend_clients.simulator.kinematics import FLYING, TRACKED, WHEELED
from backend_clients.simulator.profile import Energy, Family, Node, Profile, Words

KWH = 3.6e6

WEEDER = Profile(
    family="weeder",
    model="Laser weeder, tracked (simulated)",
    software="simulated weeder 1",
    dimensions=up.Dimensions(length_m=2.6, width_m=1.7, height_m=1.6, base_to_front_m=1.3, track_m=TRACKED.track_m),
    motion=TRACKED,
    energy=Energy(12 * KWH, idle_w=180.0, tool_w=1500.0, drive_w_per_mps=1600.0, charge_w=3000.0),
    tool=up.Tool(kind="laser", label="Laser", width_m=1.5),
    work="weed",
    stop_effect="Laser off, tracks brake",
    words=Words(tool="Laser", cover="Laser cover", tool_on="Laser firing", tool_off="Laser off"),
    nodes=(
        Node("gnss", 20.0, 2.0),
        Node("perception", 15.0, 41.0),
        Node("guidance", 20.0, 6.0),
        Node("drive", 50.0, 3.0),
        Node("laser", 30.0, 12.0),
        Node("supervisor", 10.0, 2.0),
    ),
    functions=(
        up.Function(name="localise", label="Know where it is", depends_on=["gnss"]),
        up.Function(name="follow-path", label="Follow a path", depends_on=["localise", "guidance", "drive"]),
        up.Function(name="see-people", label="See people in its way", depends_on=["perception"]),
        up.Function(name="treat", label="Weed with the laser", depends_on=["follow-path", "see-people", "laser"]),
        up.Function(name="manual-drive", label="Drive by hand", depends_on=["drive"]),
    ),
    cameras=(
        up.Camera(id="front", label="Front", width_px=2048, height_px=1536),
        up.Camera(id="rear", label="Tracks behind", width_px=2048, height_px=1536),
        up.Camera(id="tof", label="Distance, pan-tilt head", width_px=352, height_px=264),
    ),
    joints=(
        Joint(name="pan", lower=-1.57, upper=1.57, max_rate=1.0),
        Joint(name="tilt", lower=-0.9, upper=0.5, max_rate=1.0),
    ),
    tool_node="laser",
    rate_per_min=110.0,
    hot_c=58.0,
)

PLANTER = Profile(
    family="planter",
    model="Tree planter with crane, 10 t (simulated)",
    software="simulated planter 1",
    dimensions=up.Dimensions(length_m=6.4, width_m=2.6, height_m=3.2, base_to_front_m=4.0, track_m=WHEELED.track_m),
    motion=WHEELED,
    # a 129 kW diesel; the store is its tank
    energy=Energy(600 * KWH, idle_w=6_000.0, tool_w=18_000.0, drive_w_per_mps=30_000.0, charge_w=2_000_000.0),
    tool=up.Tool(kind="planter", label="Crane", width_m=2.0),
    work="plant",
    stop_effect="Drive and crane stop, hydraulics hold",
    words=Words(tool="Crane", cover="Crane guard", row="Plant row", tool_on="Planting", tool_off="Crane away"),
    nodes=(
        Node("gnss", 20.0, 2.0),
        Node("stereo", 5.0, 38.0),
        Node("plant-planner", 2.0, 9.0),
        Node("drive", 50.0, 3.0),
        Node("crane", 50.0, 7.0),
        Node("planter", 20.0, 3.0),
        Node("supervisor", 10.0, 2.0),
    ),
    functions=(
        up.Function(name="localise", label="Know where it is", depends_on=["gnss"]),
        up.Function(name="follow-path", label="Follow a path", depends_on=["localise", "drive"]),
        up.Function(name="see-people", label="See people in its way", depends_on=["stereo"]),
        up.Function(name="plan-trees", label="Find planting points", depends_on=["stereo", "plant-planner"]),
        up.Function(
            name="plant",
            label="Plant trees",
            depends_on=["follow-path", "see-people", "plan-trees", "crane", "planter"],
        ),
        up.Function(name="manual-drive", label="Drive by hand", depends_on=["drive"]),
    ),
    cameras=(up.Camera(id="rear", label="Work area behind", width_px=1280, height_px=720),),
    joints=(
        Joint(name="slew", lower=-1.9, upper=1.9, max_rate=0.5),
        Joint(name="lift", lower=-0.4, upper=1.3, max_rate=0.3),
        Joint(name="elbow", lower=-2.6, upper=0.2, max_rate=0.4),
        Joint(name="extension", lower=0.0, upper=4.0, max_rate=0.6),
    ),
    tool_node="crane",
    protective_field_m=6.0,
    home_speed_mps=1.2,
    dwell_s=20.0,
    tray=67,
    spacing_m=2.0,
    keep_out_m=20.0,
)

UAV = Profile(
    family="uav",
    model="Quadrotor with camera (simulated)",
    software="simulated UAV 1",
    dimensions=up.Dimensions(length_m=0.9, width_m=0.9, height_m=0.4, base_to_front_m=0.45, track_m=FLYING.track_m),
    motion=FLYING,
    # about 20 min in the air; a fresh pack is on within a quarter of an hour
    energy=Energy(0.27 * KWH, idle_w=12.0, tool_w=25.0, drive_w_per_mps=8.0, charge_w=1000.0, hover_w=700.0),
    tool=up.Tool(kind="camera", label="Camera", width_m=20.0),
    work="survey",
    stop_effect="Brakes and hovers",
    words=Words(tool="Camera", cover="Payload", row="Search line", tool_on="Searching", tool_off="Camera off"),
    nodes=(
        Node("gnss", 10.0, 2.0),
        Node("autopilot", 50.0, 11.0),
        Node("camera", 15.0, 24.0),
        Node("companion", 10.0, 9.0),
    ),
    functions=(
        up.Function(name="localise", label="Know where it is", depends_on=["gnss"]),
        up.Function(name="follow-path", label="Fly a path", depends_on=["localise", "autopilot"]),
        up.Function(name="search", label="Search with the camera", depends_on=["follow-path", "camera", "companion"]),
        up.Function(name="manual-drive", label="Fly by hand", depends_on=["autopilot"]),
    ),
    cameras=(up.Camera(id="gimbal", label="Gimbal", width_px=1920, height_px=1080),),
    joints=(Joint(name="tilt", lower=-1.57, upper=0.3, max_rate=1.0),),
    tool_node="camera",
    protective_field_m=0.0,
    needs_rtk=False,
    home_below=0.25,
    home_speed_mps=7.0,
    lead_speed_mps=6.0,
)

FAMILIES: dict[Family, Profile] = {one.family: one for one in (WEEDER, PLANTER, UAV)}


@cache
def lean(family: Family) -> Profile:
    """Return a family that is put on its path instead of being steered along it."""
    profile = FAMILIES[family]
    return replace(profile, motion=replace(profile.motion, is_on_rails=True))
