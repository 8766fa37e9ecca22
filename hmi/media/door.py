"""How console and media process find and trust each other on this machine.

The media process listens on loopback only. Other programs of the machine do not know the secret, so they read nothing.
"""

from __future__ import annotations

import hmac
import os
import secrets
import tempfile
from dataclasses import dataclass
from pathlib import Path

import msgspec

SECRET_HEADER = "x-headland-media"  # noqa: S105 - a name
VIEWER_HEADER = "x-headland-viewer"
RIGHTS_HEADER = "x-headland-rights"
NOTE, SECRET = "media.json", "media-secret"


@dataclass(frozen=True, slots=True)
class Note:
    """Where a running media process listens: its control port and viser's."""

    pid: int
    control_port: int
    viser_port: int


def write_note(data: Path, note: Note) -> None:
    """Tell the console where this process listens."""
    folder = data / "run"
    folder.mkdir(parents=True, exist_ok=True)
    descriptor, name = tempfile.mkstemp(dir=folder, prefix=NOTE)
    with os.fdopen(descriptor, "wb") as file:
        file.write(msgspec.json.encode(note))
    os.replace(name, folder / NOTE)


def read_note(data: Path) -> Note | None:
    """Return where the media process listens, ``None`` before its first start."""
    try:
        return msgspec.json.decode((data / "run" / NOTE).read_bytes(), type=Note)
    except (OSError, msgspec.MsgspecError):
        return None


def shared_secret(data: Path) -> str:
    """Return the secret of console and media process; whoever starts first makes it, readable by its owner only."""
    path = data / "run" / SECRET
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        with os.fdopen(descriptor, "w", encoding="ascii") as file:
            file.write(secrets.token_urlsafe(48))
    except FileExistsError:
        pass
    return path.read_text(encoding="ascii").strip()


def is_secret(given: str | None, secret: str) -> bool:
    """Say whether a request carries the secret."""
    return given is not None and bool(secret) and hmac.compare_digest(given.encode(), secret.encode())
