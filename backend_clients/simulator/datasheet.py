"""What the simulated laser weeder says it is: factsheet, software nodes, model and cameras."""

from __future__ import annotations

from typing import Any

from backend_clients.edge import messages_up as up
from backend_clients.simulator.config import WeederConfig
from backend_clients.simulator.kinematics import LIMITS, TRACK_M
from backend_clients.simulator.machine import (
    BASE_TO_FRONT_M,
    CAPACITY_J,
    CHARGE_W,
    HEIGHT_M,
    LENGTH_M,
    TOOL_WIDTH_M,
    WIDTH_M,
    Machine,
)

SOFTWARE = "simulated weeder 1"

CAMERAS = [
    up.Camera(id="front", label="Front", width_px=2048, height_px=1536),
    up.Camera(id="rear", label="Tracks behind", width_px=2048, height_px=1536),
    up.Camera(id="tof", label="Distance, pan-tilt head", width_px=352, height_px=264),
]
JOINTS = [
    up.Joint(name="pan", lower=-1.57, upper=1.57, max_rate=1.0),
    up.Joint(name="tilt", lower=-0.9, upper=0.5, max_rate=1.0),
]
FUNCTIONS = [
    up.Function(name="localise", label="Know where it is", depends_on=["gnss"]),
    up.Function(name="follow-path", label="Follow a path", depends_on=["localise", "guidance", "drive"]),
    up.Function(name="see-people", label="See people in its way", depends_on=["perception"]),
    up.Function(name="treat", label="Weed with the laser", depends_on=["follow-path", "see-people", "laser"]),
    up.Function(name="manual-drive", label="Drive by hand", depends_on=["drive"]),
]
_NODES: list[tuple[str, float, float]] = [
    ("gnss", 20.0, 2.0),
    ("perception", 15.0, 41.0),
    ("guidance", 20.0, 6.0),
    ("drive", 50.0, 3.0),
    ("laser", 30.0, 12.0),
    ("supervisor", 10.0, 2.0),
]


def factsheet_fields(config: WeederConfig) -> dict[str, Any]:
    """Return the factsheet of one robot without its header."""
    return {
        "family": "weeder",
        "name": config.name,
        "model": "Laser weeder, tracked (simulated)",
        "software": SOFTWARE,
        "datum": up.Datum(lat_deg=config.datum_lat_deg, lon_deg=config.datum_lon_deg),
        "dimensions": up.Dimensions(
            length_m=LENGTH_M, width_m=WIDTH_M, height_m=HEIGHT_M, base_to_front_m=BASE_TO_FRONT_M, track_m=TRACK_M
        ),
        "limits": LIMITS,
        "tool": up.Tool(kind="laser", label="Laser", width_m=TOOL_WIDTH_M),
        "battery": up.BatteryPack(capacity_wh=CAPACITY_J / 3600, charge_w=CHARGE_W),
        "cameras": CAMERAS,
        "joints": JOINTS,
        "functions": FUNCTIONS,
        "behaviour": up.Behaviour(stop_effect="Laser off, tracks brake"),
    }


def node_fields(machine: Machine) -> list[dict[str, Any]]:
    """Return name, state, rate and load of each software node."""
    troubled = {"laser": machine.is_cover_open, "gnss": False}
    fields = []
    for name, rate_hz, cpu_pct in _NODES:
        is_off = troubled.get(name, False)
        fields.append(
            {
                "name": name,
                "state": "stopped" if is_off else "started",
                "rate_hz": 0.0 if is_off else rate_hz,
                "cpu_pct": 0.0 if is_off else cpu_pct,
                "text": "Laser cover is open" if is_off else "",
            }
        )
    return fields


def urdf(config: WeederConfig) -> str:
    """Return a plain URDF of the machine: body, two tracks, laser box, camera head."""
    side = TRACK_M / 2

    def link(name: str, size: tuple[float, float, float]) -> str:
        box = " ".join(f"{value:g}" for value in size)
        return f'<link name="{name}"><visual><geometry><box size="{box}"/></geometry></visual></link>'

    def fixed(child: str, x: float, y: float, z: float) -> str:
        return (
            f'<joint name="{child}_mount" type="fixed"><parent link="base"/><child link="{child}"/>'
            f'<origin xyz="{x:g} {y:g} {z:g}"/></joint>'
        )

    parts = [
        link("base", (LENGTH_M, WIDTH_M * 0.6, HEIGHT_M * 0.5)),
        link("track_left", (LENGTH_M, 0.3, 0.5)),
        fixed("track_left", 0, side, -0.25),
        link("track_right", (LENGTH_M, 0.3, 0.5)),
        fixed("track_right", 0, -side, -0.25),
        link("laser", (0.6, TOOL_WIDTH_M, 0.4)),
        fixed("laser", -0.8, 0, -0.3),
        link("camera_head", (0.2, 0.3, 0.2)),
        fixed("camera_head", BASE_TO_FRONT_M - 0.2, 0, HEIGHT_M * 0.5),
    ]
    return f'<?xml version="1.0"?>\n<robot name="{config.id}">{"".join(parts)}</robot>\n'
