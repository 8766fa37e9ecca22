"""All rules that watch one robot."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from hmi.domain.alarm.catalogue import AlarmType
from hmi.ingest.supervision.battery import Battery
from hmi.ingest.supervision.computer import Computer
from hmi.ingest.supervision.faults import Faults
from hmi.ingest.supervision.fence import Fence, Ground
from hmi.ingest.supervision.link import Link
from hmi.ingest.supervision.motion import Motion, OldStop
from hmi.ingest.supervision.nodes import Nodes
from hmi.ingest.supervision.pace import Pace
from hmi.ingest.supervision.progress import Progress
from hmi.ingest.supervision.track import Track
from hmi.ingest.supervision.view import Rule

GroundOf = Callable[[], Ground | None]


def rules_of(types: Mapping[str, AlarmType], ground_of: GroundOf) -> Sequence[Rule]:
    """Return fresh rules for one robot; those with a limit go by what ``types`` says in the moment."""
    progress = Progress(lambda: types["stalled"])
    return (
        Link(),
        Motion(),
        OldStop(),
        Faults({code for code, one in types.items() if one.is_robot_code}),
        Track(lambda: types["off-track"]),
        progress,
        Pace(lambda: progress.is_stalled),
        Battery(),
        Nodes(lambda: types["node-slow"], lambda: types["node-clock"]),
        Computer(lambda: types["clock-wrong"]),
        Fence(ground_of),
    )
