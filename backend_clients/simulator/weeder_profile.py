"""The laser weeder: a tracked robot after published data (docs/simulator.md names what is assumed)."""

from __future__ import annotations

from backend_clients.edge import messages_up as up
from backend_clients.edge.machine import GaugeInfo, Joint
from backend_clients.simulator.kinematics import TRACKED
from backend_clients.simulator.profile import Energy, Node, Profile, Words

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
        Node("gnss", 20.0, 2.0, "RTK receiver", "Localise"),
        Node("perception", 15.0, 41.0, "Cameras and crop", "Perception", host="vision"),
        Node("guidance", 20.0, 6.0, "Guidance", "Drive", ("gnss",)),
        Node("drive", 50.0, 3.0, "Track drive", "Drive"),
        Node("laser", 30.0, 12.0, "Laser head", "Laser", ("perception",), host="vision"),
        Node("supervisor", 10.0, 2.0, "Supervisor", "Supervisor", ("drive", "guidance")),
    ),
    functions=(
        up.Function(name="localise", label="Locate itself", depends_on=["gnss"]),
        up.Function(
            name="follow-path", label="Follow a path", depends_on=["localise", "guidance", "drive", "supervisor"]
        ),
        up.Function(name="see-people", label="See people in its way", depends_on=["perception"]),
        up.Function(name="see-crop", label="Tell crop and weeds apart", depends_on=["perception"]),
        up.Function(
            name="treat", label="Weed with the laser", depends_on=["follow-path", "see-people", "see-crop", "laser"]
        ),
        up.Function(name="manual-drive", label="Drive by hand", depends_on=["drive"], better_with=["see-people"]),
    ),
    cameras=(
        up.Camera(
            id="front",
            label="Front",
            width_px=2048,
            height_px=1536,
            fps=15.0,
            view="front",
            fov_deg=74.0,
            ptz=up.CameraPtz(pan="pan", tilt="tilt", zoom=(1.0, 4.0)),
            has_lamp=True,
            has_trigger=True,
        ),
        up.Camera(
            id="rear",
            label="Tracks behind",
            width_px=2048,
            height_px=1536,
            fps=15.0,
            view="rear",
            fov_deg=74.0,
            has_lamp=True,
            has_trigger=True,
        ),
        up.Camera(
            id="side",
            label="Side, infrared",
            width_px=1280,
            height_px=960,
            kind="infrared",
            fps=15.0,
            view="front",
            fov_deg=74.0,
        ),
        up.Camera(
            id="tool",
            label="Laser tool",
            width_px=1280,
            height_px=960,
            fps=15.0,
            view="tool",
            fov_deg=72.0,
            has_lamp=True,
        ),
        up.Camera(
            id="tof",
            label="Distance, pan-tilt head",
            width_px=352,
            height_px=264,
            kind="depth",
            fps=10.0,
            view="distance",
            fov_deg=62.0,
            ptz=up.CameraPtz(pan="pan", tilt="tilt"),
        ),
    ),
    joints=(
        Joint(name="pan", label="Camera pan", lower=-1.57, upper=1.57, soft_lower=-1.5, soft_upper=1.5, max_rate=1.0),
        Joint(name="tilt", label="Camera tilt", lower=-0.9, upper=0.5, soft_lower=-0.85, soft_upper=0.45, max_rate=1.0),
    ),
    gauges=(
        GaugeInfo(
            key="laser-temp",
            label="Laser",
            unit="°C",
            lower=0.0,
            upper=90.0,
            ok_upper=70.0,
            limit_text="off at 70 °C",
        ),
        GaugeInfo(
            key="motor-temp",
            label="Motors",
            unit="°C",
            lower=0.0,
            upper=120.0,
            ok_upper=95.0,
            limit_text="slower at 95 °C",
        ),
    ),
    work_function="treat",
    tool_node="laser",
    rate_per_min=110.0,
    hot_c=58.0,
)
