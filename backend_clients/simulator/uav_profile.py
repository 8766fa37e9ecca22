"""The UAV: a quadrotor with a camera, after an emergency service with UAVs."""

from __future__ import annotations

from backend_clients.edge import messages_up as up
from backend_clients.edge.machine import GaugeInfo, Joint
from backend_clients.simulator.kinematics import FLYING
from backend_clients.simulator.profile import Energy, Node, Profile, Words

KWH = 3.6e6

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
        Node("gnss", 10.0, 2.0, "GNSS receiver", "Localise", host="autopilot"),
        Node("autopilot", 50.0, 11.0, "Autopilot", "Drive", host="autopilot"),
        Node("camera", 15.0, 24.0, "Gimbal camera", "Camera", host="companion"),
        Node("companion", 10.0, 9.0, "Mission computer", "Supervisor", ("autopilot",), host="companion"),
    ),
    functions=(
        up.Function(name="localise", label="Locate itself", depends_on=["gnss"]),
        up.Function(name="follow-path", label="Fly a path", depends_on=["localise", "autopilot", "companion"]),
        up.Function(name="take-pictures", label="Take pictures", depends_on=["camera"]),
        up.Function(name="search", label="Search with the camera", depends_on=["follow-path", "take-pictures"]),
        up.Function(name="manual-drive", label="Fly by hand", depends_on=["autopilot"], better_with=["take-pictures"]),
    ),
    cameras=(
        up.Camera(
            id="gimbal",
            label="Gimbal",
            width_px=1920,
            height_px=1080,
            fps=15.0,
            view="nadir",
            fov_deg=78.0,
            ptz=up.CameraPtz(tilt="tilt", zoom=(1.0, 6.0)),
            has_trigger=True,
        ),
    ),
    joints=(
        Joint(
            name="tilt", label="Gimbal tilt", lower=-1.57, upper=0.3, soft_lower=-1.55, soft_upper=0.25, max_rate=1.0
        ),
    ),
    gauges=(
        GaugeInfo(
            key="height", label="Height", unit="m", lower=0.0, upper=60.0, ok_upper=50.0, limit_text="limit 50 m"
        ),
        GaugeInfo(
            key="wind", label="Wind", unit="m/s", lower=0.0, upper=20.0, ok_upper=12.0, limit_text="limit 12 m/s"
        ),
        GaugeInfo(key="return-time", label="Way back", unit="min", lower=0.0, upper=15.0, limit_text="with landing"),
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
    work_function="search",
    tool_node="camera",
    protective_field_m=0.0,
    needs_rtk=False,
    home_below=0.25,
    home_speed_mps=7.0,
    lead_speed_mps=6.0,
)
