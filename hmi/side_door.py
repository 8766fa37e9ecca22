"""How the console and a process beside it find and trust each other on this machine.

Such a process listens on loopback only. Other programs of the machine do not know its secret, so they read nothing.
"""

from __future__ import annotations

import hmac
import os
import secrets
import tempfile
from pathlib import Path
from typing import Any, TypeVar

import msgspec

T = TypeVar("T")


def write_note(data: Path, name: str, note: Any) -> None:
    """Tell the console where the process called ``name`` listens."""
    folder = data / "run"
    folder.mkdir(parents=True, exist_ok=True)
    descriptor, path = tempfile.mkstemp(dir=folder, prefix=f"{name}.json")
    with os.fdopen(descriptor, "wb") as file:
        file.write(msgspec.json.encode(note))
    os.replace(path, folder / f"{name}.json")


def read_note(data: Path, name: str, kind: type[T]) -> T | None:
    """Return where the process called ``name`` listens, ``None`` before its first start."""
    try:
        return msgspec.json.decode((data / "run" / f"{name}.json").read_bytes(), type=kind)
    except (OSError, msgspec.MsgspecError):
        return None


def shared_secret(data: Path, name: str) -> str:
    """Return the secret of console and process; whoever starts first makes it, readable by its owner only."""
    path = data / "run" / f"{name}-secret"
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
