"""What the robots of the demo are busy with, as the simulator takes it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import msgspec

from backend_clients.edge.messages_down import Mission
from backend_clients.simulator.config import Job
from hmi.demo.work import planned_work, task_of


def jobs_of(rows: Iterable[Mapping[str, Any]]) -> dict[str, Job]:
    """Return the jobs of those rows of the fleet file that shall be at work."""
    found = {}
    for row in rows:
        task = task_of(row["id"]) if row.get("task") else None
        if task is not None and task.done is not None:
            document = planned_work()[task.mission_id].document
            found[task.robot_id] = Job(msgspec.convert(document, Mission), task.done)
    return found


OPENING = {
    "weeder-03": "rtk-float",
    "weeder-11": "weed-unsure",
    "planter-02": "crane-limit",
    "uav-03": "reserve-near",
}
"""What happens first, so that a new visitor sees a farm with some trouble."""
