"""How console and camera process find each other; see ``hmi.side_door``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from hmi import side_door

SECRET_HEADER = "x-headland-cameras"  # noqa: S105 - a name
VIEWER_HEADER = "x-headland-viewer"
WATCHER_HEADER = "x-headland-watcher"
CAPTURED_HEADER = "x-headland-captured"
SEQ_HEADER = "x-headland-seq"
DATED_HEADER = "x-headland-dated"
NAME = "cameras"


@dataclass(frozen=True, slots=True)
class Note:
    """Where a running camera process listens."""

    pid: int
    control_port: int


def write_note(data: Path, note: Note) -> None:
    """Tell the console where this process listens."""
    side_door.write_note(data, NAME, note)


def read_note(data: Path) -> Note | None:
    """Return where the camera process listens, ``None`` before its first start."""
    return side_door.read_note(data, NAME, Note)


def shared_secret(data: Path) -> str:
    """Return the secret of console and camera process."""
    return side_door.shared_secret(data, NAME)
