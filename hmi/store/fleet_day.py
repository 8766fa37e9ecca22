"""Today's sums of the fleet in a small file, so that they outlive a restart. Blocking."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

MAX_BYTES = 10_000


def read_day(path: Path) -> dict[str, Any]:
    """Return what was written, empty if nothing was or it cannot be read."""
    try:
        with path.open("rb") as file:
            kept = json.loads(file.read(MAX_BYTES))
    except (OSError, ValueError):
        return {}
    return kept if isinstance(kept, dict) else {}


def write_day(path: Path, kept: Mapping[str, Any]) -> None:
    """Replace the file as a whole; raises ``OSError``."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=path.name)
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            json.dump(kept, file)
        Path(name).replace(path)
    except OSError:
        Path(name).unlink(missing_ok=True)
        raise
