"""What the service's worker process does: one plan at a time, and word of how far it is."""

from __future__ import annotations

from multiprocessing import parent_process
from pathlib import Path

from backend_clients.planner.messages import PlanPath, Segment, Wish
from hmi.planning.progress_note import ProgressNote
from hmi.planning.side_process import limit_memory
from hmi.planning_service.form import wish_of

MEMORY = 4 * 2**30  # address space, of which geometry libraries take one before any work


def planned(form: bytes, note: str) -> bytes:
    """Return the path of a wish, both as JSON.

    Args:
        note: file that says how far it is, see ``ProgressNote``.

    Raises:
        PlanRefused: it cannot be planned; says why.
    """
    if parent_process() is not None:
        limit_memory(MEMORY)
    from hmi.planning.coverage import plan_coverage
    from hmi.planning.given_path import segments_of
    from hmi.planning.mission import job_of

    wish, machine = wish_of(Wish.model_validate_json(form))
    with ProgressNote(Path(note)) as tell:
        plan = plan_coverage(job_of(wish, machine), tell)
    segments = [Segment.model_validate(one) for one in segments_of(plan.legs)]
    return PlanPath(segments=segments, notes=list(plan.notes)).model_dump_json().encode()
