"""The missions the demo's robots are busy with: who works where, and their documents, planned once and shipped.

``python -m hmi.demo.work_planning`` plans them anew after a change of farm, machines or planner.
"""

from __future__ import annotations

import gzip
import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from hmi.domain.mission_document import mission_sha256
from hmi.domain.mission_plan import PlannedMission

FILE = Path(__file__).parent / "fields" / "work.json.gz"


@dataclass(frozen=True, slots=True)
class Task:
    """One robot's work: a band of a field, across the rows, and how much of it was done at the first start.

    Args:
        band: from and to, as shares of the field's width across its rows.
        width_m: of the tool.
        done: share of the path behind it; ``None`` leaves it at home with the mission loaded.
    """

    robot_id: str
    field_id: str
    band: tuple[float, float]
    width_m: float
    done: float | None

    @property
    def mission_id(self) -> str:
        """Id of its mission."""
        return f"{self.field_id}-{self.robot_id}"


TASKS = (
    Task("weeder-03", "zuidkamp", (0.0, 0.34), 1.5, 0.41),
    Task("weeder-04", "zuidkamp", (0.36, 0.68), 1.5, 0.18),
    Task("weeder-05", "oostveld", (0.0, 0.24), 1.5, 0.07),
    Task("weeder-06", "oostveld", (0.26, 0.49), 1.5, 0.63),
    Task("weeder-07", "oostveld", (0.51, 0.74), 1.5, 0.35),
    Task("weeder-08", "oostveld", (0.76, 1.0), 1.5, 0.52),
    Task("weeder-09", "lange-akker", (0.0, 0.48), 1.5, 0.29),
    Task("weeder-10", "lange-akker", (0.52, 1.0), 1.5, 0.56),
    Task("weeder-11", "molenhoek", (0.0, 0.5), 1.5, 0.24),
    Task("weeder-12", "molenhoek", (0.52, 1.0), 1.5, 0.47),
    Task("weeder-13", "westhoek", (0.6, 1.0), 1.5, 0.0),
    Task("planter-01", "elzenbos", (0.0, 0.3), 4.0, 0.22),
    Task("planter-02", "elzenbos", (0.33, 0.64), 4.0, 0.36),
    Task("planter-03", "elzenbos", (0.67, 1.0), 4.0, 0.11),
    Task("uav-01", "dijkveld", (0.0, 1.0), 20.0, 0.3),
    Task("uav-02", "westhoek", (0.0, 1.0), 20.0, 0.55),
    Task("uav-03", "wilgenhoek", (0.0, 1.0), 10.0, 0.1),
)
"""What is under way. Who is not named here stands at home."""


def task_of(robot_id: str) -> Task | None:
    """Return what a robot is busy with."""
    return next((one for one in TASKS if one.robot_id == robot_id), None)


@cache
def planned_work() -> dict[str, PlannedMission]:
    """Return the planned missions by their id, as shipped."""
    rows = json.loads(gzip.decompress(FILE.read_bytes()))
    return {
        row["document"]["mission_id"]: PlannedMission(
            row["document"], mission_sha256(row["document"]), row["statistics"]
        )
        for row in rows
    }
