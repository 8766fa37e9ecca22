"""The tree planter: 10 t on wheels with a forwarder crane, after published data."""

from __future__ import annotations

from backend_clients.edge import messages_up as up
from backend_clients.edge.machine import GaugeInfo
from backend_clients.simulator.crane import JOINTS
from backend_clients.simulator.kinematics import WHEELED
from backend_clients.simulator.profile import Energy, Node, Profile, Words

KWH = 3.6e6

PLANTER = Profile(
    family="planter",
    model="Tree planter with crane, 10 t (simulated)",
    software="simulated planter 1",
    dimensions=up.Dimensions(length_m=6.4, width_m=2.6, height_m=3.2, base_to_front_m=4.0, track_m=WHEELED.track_m),
    motion=WHEELED,
    # a 129 kW diesel; the store is its tank
    energy=Energy(600 * KWH, idle_w=6_000.0, tool_w=18_000.0, drive_w_per_mps=30_000.0, charge_w=2_000_000.0),
    tool=up.Tool(kind="planter", label="Crane", width_m=4.0),
    work="plant",
    stop_effect="Drive and crane stop, hydraulics hold",
    words=Words(tool="Crane", cover="Crane guard", row="Plant row", tool_on="Planting", tool_off="Crane away"),
    nodes=(
        Node("gnss", 20.0, 2.0, "RTK receiver", "Localise"),
        Node("drive", 50.0, 3.0, "Base controller", "Drive"),
        Node("stereo", 5.0, 38.0, "Stereo camera", "Perception", host="vision"),
        Node("person-guard", 10.0, 34.0, "Person guard", "Guard", ("stereo",), host="vision"),
        Node("plant-planner", 2.0, 9.0, "Tree planner", "Planter", ("stereo", "gnss"), host="vision"),
        Node("crane", 50.0, 7.0, "Crane controller", "Crane"),
        Node("planter", 20.0, 3.0, "Planting head", "Planter", ("crane",)),
        Node("tray-feeder", 10.0, 1.0, "Tray feeder", "Planter"),
        Node("supervisor", 10.0, 4.0, "Mission supervisor", "Supervisor", ("drive", "crane", "planter")),
    ),
    functions=(
        up.Function(name="localise", label="Locate itself", depends_on=["gnss"]),
        up.Function(name="follow-path", label="Follow a path", depends_on=["localise", "drive", "supervisor"]),
        up.Function(name="see-people", label="Guard people", depends_on=["person-guard"]),
        up.Function(name="plan-trees", label="Find planting points", depends_on=["stereo", "plant-planner"]),
        up.Function(name="move-crane", label="Move the crane", depends_on=["crane"], better_with=["see-people"]),
        up.Function(name="feed", label="Feed seedlings", depends_on=["tray-feeder"]),
        up.Function(
            name="plant",
            label="Plant trees",
            depends_on=["follow-path", "see-people", "plan-trees", "move-crane", "feed", "planter"],
        ),
        up.Function(name="manual-drive", label="Drive by hand", depends_on=["drive"], better_with=["see-people"]),
        up.Function(name="manual-crane", label="Move the crane by hand", depends_on=["move-crane"]),
    ),
    cameras=(
        up.Camera(
            id="rear",
            label="Work area behind",
            width_px=1280,
            height_px=720,
            fps=15.0,
            view="rear",
            fov_deg=82.0,
            has_lamp=True,
            has_trigger=True,
        ),
        up.Camera(
            id="head",
            label="Planting head",
            width_px=1280,
            height_px=720,
            fps=15.0,
            view="head",
            fov_deg=62.0,
            has_lamp=True,
            has_trigger=True,
        ),
    ),
    joints=JOINTS,
    gauges=(
        GaugeInfo(
            key="pressure",
            label="Pressure",
            unit="bar",
            lower=0.0,
            upper=250.0,
            ok_upper=210.0,
            limit_text="relief 210 bar",
        ),
        GaugeInfo(key="oil", label="Oil", unit="°C", lower=0.0, upper=100.0, ok_upper=75.0, limit_text="limit 75 °C"),
        GaugeInfo(key="tilt", label="Tilt", unit="°", lower=0.0, upper=20.0, ok_upper=12.0, limit_text="stops at 12°"),
        GaugeInfo(key="head-soil", label="Head to soil", unit="m", lower=0.0, upper=4.0, limit_text="target 0.00 m"),
    ),
    work_function="plant",
    tool_node="crane",
    protective_field_m=6.0,
    home_speed_mps=1.2,
    tray=67,
    keep_out_m=20.0,
)
