"""What a simulated robot says it is: factsheet, software nodes and model."""

from __future__ import annotations

from typing import Any

from backend_clients.edge import messages_up as up
from backend_clients.edge.machine import NodeInfo
from backend_clients.simulator.config import RobotConfig
from backend_clients.simulator.supervisor import tree_of


def factsheet_fields(config: RobotConfig) -> dict[str, Any]:
    """Return the factsheet of one robot without its header."""
    profile = config.profile
    return {
        "family": profile.family,
        "name": config.name,
        "model": profile.model,
        "software": profile.software,
        "datum": up.Datum(lat_deg=config.datum_lat_deg, lon_deg=config.datum_lon_deg),
        "dimensions": profile.dimensions,
        "limits": profile.motion.limits(),
        "tool": profile.tool,
        "battery": up.BatteryPack(capacity_wh=profile.energy.capacity_j / 3600, charge_w=profile.energy.charge_w),
        "cameras": list(profile.cameras),
        "joints": [] if config.is_lean else list(profile.joints),
        "gauges": [] if config.is_lean else list(profile.gauges),
        "nodes": [
            NodeInfo(
                name=node.name,
                label=node.label,
                subsystem=node.subsystem,
                rate_hz=node.rate_hz,
                starts_after=list(node.starts_after),
            )
            for node in profile.nodes
        ],
        "functions": list(profile.functions),
        "chart": None if config.is_lean else tree_of(profile.family).chart,
        "behaviour": up.Behaviour(
            stop_effect=profile.stop_effect,
            keep_out_m=profile.keep_out_m,
            link_lost_pause_s=config.link_lost_pause_s,
        ),
        "skips_by_name": True,
    }


def urdf(config: RobotConfig) -> str:
    """Return a plain URDF of the machine: body, what carries it, tool, camera head."""
    size, profile = config.profile.dimensions, config.profile
    side = size.track_m / 2

    def link(name: str, box: tuple[float, float, float]) -> str:
        text = " ".join(f"{value:g}" for value in box)
        return f'<link name="{name}"><visual><geometry><box size="{text}"/></geometry></visual></link>'

    def fixed(child: str, x: float, y: float, z: float) -> str:
        return (
            f'<joint name="{child}_mount" type="fixed"><parent link="base"/><child link="{child}"/>'
            f'<origin xyz="{x:g} {y:g} {z:g}"/></joint>'
        )

    tool, carrier = profile.tool.kind, {"weeder": "track", "planter": "wheels", "uav": "rotors"}[profile.family]
    tool_width_m = min(profile.tool.width_m, size.width_m)
    parts = [
        link("base", (size.length_m, size.width_m * 0.6, size.height_m * 0.5)),
        link(f"{carrier}_left", (size.length_m, 0.3, 0.5)),
        fixed(f"{carrier}_left", 0, side, -0.25),
        link(f"{carrier}_right", (size.length_m, 0.3, 0.5)),
        fixed(f"{carrier}_right", 0, -side, -0.25),
        link(tool, (0.6, tool_width_m, 0.4)),
        fixed(tool, -0.8, 0, -0.3),
        link("camera_head", (0.2, 0.3, 0.2)),
        fixed("camera_head", size.base_to_front_m - 0.2, 0, size.height_m * 0.5),
    ]
    return f'<?xml version="1.0"?>\n<robot name="{config.id}">{"".join(parts)}</robot>\n'
