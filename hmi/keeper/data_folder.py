"""The data folder: made, writable, and the small files that processes leave for each other in it."""

from __future__ import annotations

import errno
import json
import os
import secrets
import tempfile
from pathlib import Path
from typing import Any

from hmi.keeper.errors import StartError

BLOCK_BYTES = 4096  # file systems give room in blocks of this size


def require_writable(data: Path) -> Path:
    """Make the folder and its parts; return it resolved, or raise ``StartError``."""
    try:
        for part in ("run", "logs", "stop"):
            (data / part).mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=data / "run"):
            pass
    except OSError as error:
        raise StartError(
            f"The data folder {data} cannot be written ({error.strerror}): "
            "choose another with HEADLAND_DATA or correct its rights."
        ) from error
    return data.resolve()


def write_json(path: Path, value: Any) -> None:
    """Replace ``path`` by JSON in one step, so that readers never see half of it; raises ``OSError``."""
    descriptor, name = tempfile.mkstemp(dir=path.parent, prefix=path.name)
    try:
        with os.fdopen(descriptor, "w", encoding="utf-8") as file:
            json.dump(value, file)
        os.replace(name, path)
    except OSError:
        Path(name).unlink(missing_ok=True)
        raise


def overwrite_json(path: Path, value: Any) -> None:
    """Write JSON over what is in ``path``, which takes no room of a disk that is full; raises ``OSError``.

    A reader may see half of it, once.
    """
    content = json.dumps(value).encode()
    with path.open("r+b", buffering=0) as file:
        room = -(-os.fstat(file.fileno()).st_size // BLOCK_BYTES) * BLOCK_BYTES
        if len(content) > room:  # half of it would stay
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        file.write(content)
        file.truncate()


def read_json(path: Path) -> Any | None:
    """Return the JSON in ``path``, or ``None`` if there is none that can be read."""
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None


def keep_secret(path: Path) -> str:
    """Return the secret in ``path``, making it, readable by its owner only, the first time."""
    if not path.exists():
        descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        with os.fdopen(descriptor, "w", encoding="utf-8") as file:
            file.write(secrets.token_urlsafe(48))
    return path.read_text(encoding="utf-8").strip()
