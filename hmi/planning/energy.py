"""What a machine of each family takes: to drive, to be awake, to work. SI, at the battery or at the engine's shaft.

No robot says these figures; they are published ones, or assumed where none are. The plan says which it counted with.
"""

from __future__ import annotations

from dataclasses import dataclass

from hmi.domain.family import Family

_KWH = 3.6e6


@dataclass(frozen=True, slots=True)
class Energy:
    """Use of one family; ``store_j`` where a robot does not say what it holds, ``basis`` a sentence for people."""

    store_j: float
    drive_j_per_m: float
    idle_w: float
    tool_w: float
    basis: str
    is_tank: bool = False


WEEDER = Energy(
    12 * _KWH,
    drive_j_per_m=1_600.0,
    idle_w=180.0,
    tool_w=1_500.0,
    basis="Assumed for a tracked laser weeder: 1.6 kJ a metre, 0.2 kW awake, 1.5 kW more for the laser.",
)
PLANTER = Energy(
    # a tank of 180 l, a litre of diesel giving 3.3 kWh at the shaft
    600 * _KWH,
    # 10 t over forest floor: rolling resistance 0.2, and a third of the engine's work lost in the hydrostatic drive
    drive_j_per_m=30_000.0,
    # 5 % and 14 % of the 129 kW that the engine has
    idle_w=6_000.0,
    tool_w=18_000.0,
    basis="Assumed for a 10 t planter with 129 kW diesel: 30 kJ a metre, 6 kW idling, 18 kW more for the crane.",
    is_tank=True,
)
UAV = Energy(
    0.27 * _KWH,
    drive_j_per_m=8.0,
    idle_w=712.0,
    tool_w=25.0,
    basis="Assumed for a small quadrotor: 0.7 kW to stay in the air, hardly more to fly, 25 W for the camera.",
)
_OF = {Family.WEEDER: WEEDER, Family.PLANTER: PLANTER, Family.UAV: UAV}


def energy_of(family: Family) -> Energy:
    """Return the figures of a family; a machine of another kind is counted as a weeder and says so."""
    if family in _OF:
        return _OF[family]
    return Energy(
        WEEDER.store_j,
        WEEDER.drive_j_per_m,
        WEEDER.idle_w,
        WEEDER.tool_w,
        "Not known for this kind of robot: counted as a laser weeder. Do not rely on it.",
    )
