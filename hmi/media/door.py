"""How console and media process find each other; see ``hmi.side_door``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from hmi import side_door

SECRET_HEADER = "x-headland-media"  # noqa: S105 - a name
VIEWER_HEADER = "x-headland-viewer"
RIGHTS_HEADER = "x-headland-rights"
CAPTURED_HEADER = "x-headland-captured-s"
NAME = "media"


@dataclass(frozen=True, slots=True)
class Note:
    """Where a running media process listens: its control port and viser's."""

    pid: int
    control_port: int
    viser_port: int


def write_note(data: Path, note: Note) -> None:
    """Tell the console where this process listens."""
    side_door.write_note(data, NAME, note)


def read_note(data: Path) -> Note | None:
    """Return where the media process listens, ``None`` before its first start."""
    return side_door.read_note(data, NAME, Note)


def shared_secret(data: Path) -> str:
    """Return the secret of console and media process."""
    return side_door.shared_secret(data, NAME)
