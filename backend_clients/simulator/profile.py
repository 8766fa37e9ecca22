"""What tells one family of machines from another; everything else about them is the same."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from backend_clients.edge import messages_up as up
from backend_clients.edge.machine import GaugeInfo, Joint
from backend_clients.simulator.kinematics import Motion

Family = Literal["weeder", "planter", "uav"]
Work = Literal["weed", "plant", "survey"]


@dataclass(frozen=True, slots=True)
class Energy:
    """What fills and empties the store: a battery, or a tank for the planter. Joules, watts."""

    capacity_j: float
    idle_w: float
    tool_w: float
    drive_w_per_mps: float
    charge_w: float
    hover_w: float = 0.0


@dataclass(frozen=True, slots=True)
class Node:
    """One software node: rate of its loop, load of its computer, and what must be started before it."""

    name: str
    rate_hz: float
    cpu_pct: float
    label: str = ""
    subsystem: str = ""
    starts_after: tuple[str, ...] = ()
    host: str = "main"


@dataclass(frozen=True, slots=True)
class Words:
    """What people call its parts, for states and reasons."""

    tool: str
    cover: str
    forward: str = "Forward"
    row: str = "Treat row"
    tool_on: str = "Tool on"
    tool_off: str = "Tool off"


@dataclass(frozen=True, slots=True)
class Profile:
    """One family: body, limits, tool, software and words. SI.

    Args:
        work: what the tool does on a row.
        protective_field_m: ground in front of it that must be free; 0 sees nobody.
        needs_rtk: waits where the fix is not RTK fixed.
        home_below: goes home by itself below this charge, if it may; 0 never.
        home_speed_mps, lead_speed_mps: on its way home, and to the path of its mission.
        rate_per_min: of the tool at work, shown as it is.
        work_function, drive_function, hand_function: without which it neither works, nor drives alone, nor by hand.
        tray: seedlings on a full tray.
    """

    family: Family
    model: str
    software: str
    dimensions: up.Dimensions
    motion: Motion
    energy: Energy
    tool: up.Tool
    work: Work
    stop_effect: str
    words: Words
    nodes: tuple[Node, ...]
    functions: tuple[up.Function, ...]
    cameras: tuple[up.Camera, ...]
    work_function: str
    joints: tuple[Joint, ...] = ()
    gauges: tuple[GaugeInfo, ...] = ()
    drive_function: str = "follow-path"
    hand_function: str = "manual-drive"
    tool_node: str = ""
    protective_field_m: float = 4.0
    needs_rtk: bool = True
    home_below: float = 0.0
    home_speed_mps: float = 1.0
    lead_speed_mps: float = 0.8
    rate_per_min: float | None = None
    tray: int = 0
    hot_c: float | None = None
    keep_out_m: float = 15.0
