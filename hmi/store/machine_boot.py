"""What was measured since this machine was switched on: a wall clock does not tell how long it was off."""

from __future__ import annotations

import logging
import os
from collections.abc import Iterable
from datetime import datetime
from pathlib import Path

import msgspec

BOOT_ID = Path("/proc/sys/kernel/random/boot_id")  # another one each time the machine starts; Linux
log = logging.getLogger(__name__)


class _Note(msgspec.Struct):
    boot: str
    since: datetime


def measured_since(path: Path, kept: Iterable[datetime], now: datetime) -> datetime | None:
    """Return what was kept before the first console since the machine was switched on; ``None``: all may be.

    What is dated later was measured by this boot's clock, so its age is known.

    Args:
        path: of the file that keeps it over a restart of the console.
        kept: when what is kept was measured.
    """
    try:
        boot = BOOT_ID.read_text(encoding="ascii").strip()
    except (OSError, ValueError):
        boot = ""
    if not boot:
        return None
    try:
        note = msgspec.json.decode(path.read_bytes(), type=_Note)
    except (OSError, ValueError):
        note = None
    if note is not None and note.boot == boot:
        return note.since
    beside = path.with_suffix(".new")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        # nothing that is there now is later than this, wherever the clock stood when it was measured
        beside.write_bytes(msgspec.json.encode(_Note(boot, max((now, *kept)))))
        os.replace(beside, path)
    except OSError as error:
        log.warning("it cannot be kept when this machine was switched on: %s", error)
    return None
