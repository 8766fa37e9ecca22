"""The machine a mission was planned for, kept with its figures: whether another one can drive the same path."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from hmi.domain.family import Family
from hmi.domain.robot import Factsheet

MACHINE = "machine"  # among a mission's figures
SAME_M = 0.01  # outlines are told in centimetres
SAME_MPS = 0.005
PIVOTING_RADIUS_M = 1.0  # arcs planned for a machine that could also turn on the spot


@dataclass(frozen=True, slots=True)
class PlannedMachine:
    """What a path asks of a machine. SI; as in ``Factsheet`` if nothing else is said.

    Args:
        robot_id: the robot it was planned for.
        family: ``None`` if the robot had not said what it is: the usual weeder was taken.
        turning_radius_m: of the tightest arcs.
        turns_on_spot, reverse_mps, top_mps: what the path needs, the last two in m/s.
        battery_wh: ``None`` if it was assumed.
        tool_width_m: that one pass works; ``None`` if the tool was not known, or nobody asked.
    """

    robot_id: str
    family: str | None
    length_m: float
    width_m: float
    base_to_front_m: float
    turning_radius_m: float
    turns_on_spot: bool
    reverse_mps: float
    top_mps: float
    battery_wh: float | None = None
    tool_width_m: float | None = None

    @classmethod
    def of(cls, robot_id: str, sheet: Factsheet) -> PlannedMachine:
        """Return what a path may ask of a robot that did all it can: for plans that say nothing of their machine."""
        return cls(
            robot_id,
            sheet.family.value,
            sheet.length_m,
            sheet.width_m,
            sheet.base_to_front_m,
            max(sheet.turning_radius_m, PIVOTING_RADIUS_M if sheet.can_pivot else 0.0),
            sheet.can_pivot,
            sheet.path_reverse_mps or 0.0,
            sheet.max_speed_mps,
            sheet.battery_wh,
        )

    def as_json(self) -> dict[str, Any]:
        """Return what is stored."""
        return asdict(self)

    @classmethod
    def from_json(cls, raw: Mapping[str, Any] | None) -> PlannedMachine | None:
        """Return what was stored, ``None`` if nothing was."""
        return None if not raw else cls(**{name: raw[name] for name in cls.__slots__ if name in raw})

    def ahead_of(self, sheet: Factsheet) -> str:
        """Return in what it was planned for more than this machine can, as in "which is smaller"; empty if it fits.

        What was not known when it was planned is not compared.
        """
        if self.family is not None and self.family != sheet.family.value:
            return "is another kind of machine"
        rear_m, rear_now_m = self.length_m - self.base_to_front_m, sheet.length_m - sheet.base_to_front_m
        outlines = ((sheet.width_m, self.width_m), (sheet.base_to_front_m, self.base_to_front_m), (rear_now_m, rear_m))
        if any(now > planned + SAME_M for now, planned in outlines):
            return "is smaller"
        if self.turns_on_spot and not sheet.can_pivot:
            return "turns on the spot"
        if sheet.turning_radius_m > self.turning_radius_m + SAME_M:
            return "turns tighter"
        if self.reverse_mps > (sheet.path_reverse_mps or 0.0) + SAME_MPS:
            return "drives backwards in turns"
        if self.tool_width_m is not None and 0 < sheet.tool_width_m < self.tool_width_m - SAME_M:
            return "works wider"
        return "drives faster" if self.top_mps > sheet.max_speed_mps + SAME_MPS else ""


def worked_width_m(width_m: float, sheet: Factsheet | None) -> float | None:
    """Return how wide one pass works, rows ``width_m`` apart.

    ``None`` if the tool is not known, and for a planter, whose crane sets plants and works no width.
    """
    if sheet is None or sheet.tool_width_m <= 0 or sheet.family is Family.PLANTER:
        return None
    return min(width_m, sheet.tool_width_m)


def battery_share_on(statistics: Mapping[str, Any], sheet: Factsheet | None) -> float | None:
    """Return the share of its full battery that a mission takes on a machine, ``None`` if that is not known."""
    share = statistics.get("battery_share")
    if not isinstance(share, int | float):
        return None
    planned = PlannedMachine.from_json(statistics.get(MACHINE))
    if planned is None or planned.family is None or sheet is None:
        return float(share)
    if planned.family != sheet.family.value:
        return None
    if planned.battery_wh == sheet.battery_wh:
        return float(share)
    return None if not sheet.battery_wh else float(statistics["energy_j"]) / (3600 * sheet.battery_wh)
