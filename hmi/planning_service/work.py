"""What the service's worker process does: one plan at a time, and word of how far it is."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from multiprocessing import parent_process
from pathlib import Path

from backend_clients.planner.messages import PlanPath, Segment, Wish
from hmi.planning.side_process import limit_memory
from hmi.planning_service.form import wish_of

MEMORY = 4 * 2**30  # address space, of which geometry libraries take one before any work
NOTE_BYTES = 96
NOTE_S = 0.1


def planned(form: bytes, note: str) -> bytes:
    """Return the path of a wish, both as JSON.

    Args:
        note: file that says how far it is, see ``read_note``.

    Raises:
        PlanRefused: it cannot be planned; says why.
    """
    if parent_process() is not None:
        limit_memory(MEMORY)
    from hmi.planning.coverage import plan_coverage
    from hmi.planning.given_path import segments_of
    from hmi.planning.mission import job_of

    wish, machine = wish_of(Wish.model_validate_json(form))
    with _Note(Path(note)) as tell:
        plan = plan_coverage(job_of(wish, machine), tell)
    segments = [Segment.model_validate(one) for one in segments_of(plan.legs)]
    return PlanPath(segments=segments, notes=list(plan.notes)).model_dump_json().encode()


class _Note:
    """Writes share and words into a file, ten times a second at most; each is one write of one size."""

    def __init__(self, path: Path) -> None:
        self._path, self._next_s, self._most = path, 0.0, 0.0

    def __enter__(self) -> Callable[[float, str], None]:
        self._file = os.open(self._path, os.O_WRONLY)
        return self._tell

    def __exit__(self, *_error: object) -> None:
        os.close(self._file)

    def _tell(self, share: float, words: str) -> None:
        now_s = time.monotonic()
        if now_s < self._next_s:
            return
        self._next_s, self._most = now_s + NOTE_S, max(self._most, share)
        text = f"{self._most:.3f} {words}".encode()[:NOTE_BYTES]
        os.lseek(self._file, 0, os.SEEK_SET)
        os.write(self._file, text.ljust(NOTE_BYTES))


def read_note(path: Path) -> tuple[float, str]:
    """Return share and words of a plan under way; nothing yet is 0 and ``Starting``."""
    try:
        share, _, words = path.read_text("utf-8", "replace").strip().partition(" ")
        return min(1.0, max(0.0, float(share))), words
    except (OSError, ValueError):
        return 0.0, "Starting"
