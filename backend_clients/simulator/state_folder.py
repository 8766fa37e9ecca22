"""What a robot keeps on disk: latch, lease, mission, progress; small files replaced as a whole."""

from __future__ import annotations

import logging
import os
from pathlib import Path
from typing import TypeVar

import msgspec
from msgspec import Struct

from backend_clients.edge.messages_down import Mission
from backend_clients.simulator.latch import LatchMemory

SAFETY = "safety.json"
T = TypeVar("T")
log = logging.getLogger(__name__)


class SavedSafety(Struct, kw_only=True):
    """Latch and lease fence."""

    latch: LatchMemory
    lease_token: int = 0
    revoked_token: int = 0


class SavedProgress(Struct, kw_only=True):
    """Where the machine stands and how far the mission is; poses are ENU metres and radians."""

    x_m: float
    y_m: float
    theta_rad: float
    soc: float
    status: str = "none"
    sha256: str = ""
    s_m: float = 0.0
    row: int = 0
    treated_m: float = 0.0
    driven_m: float = 0.0
    row_treated_m: float = 0.0
    row_weeds: float = 0.0
    is_supervised: bool = True
    pause_code: str = ""
    pause_pose: tuple[float, float] | None = None


class StateFolder:
    """Reads and writes one robot's folder; with ``path`` None it only remembers.

    Files are replaced atomically. A file that cannot be read counts as missing, except that a broken
    safety file latches: see ``load_safety``. A full disk stops no robot: what it does not take is remembered, read
    from there, and written as soon as there is room.
    """

    def __init__(self, path: Path | None) -> None:
        self._path = path
        self._kept: dict[str, bytes] = {}
        self._is_refused = False
        if path is not None:
            path.mkdir(parents=True, exist_ok=True)

    def load_safety(self) -> SavedSafety | None:
        """Return latch and lease; raises ``ValueError`` when the file is there but broken."""
        raw = self._read(SAFETY)
        if raw is None:
            return None
        try:
            return msgspec.json.decode(raw, type=SavedSafety)
        except msgspec.DecodeError as error:
            raise ValueError(f"safety.json: {error}") from error

    def save_safety(self, saved: SavedSafety) -> None:
        """Keep latch and lease."""
        self._write(SAFETY, msgspec.json.encode(saved))

    def load_mission(self) -> Mission | None:
        """Return the mission on the robot."""
        return self._load("mission.json", Mission)

    def save_mission(self, mission: Mission) -> None:
        """Keep the mission."""
        self._write("mission.json", msgspec.json.encode(mission))

    def load_progress(self) -> SavedProgress | None:
        """Return the newest progress."""
        return self._load("progress.json", SavedProgress)

    def save_progress(self, progress: SavedProgress) -> None:
        """Keep the progress."""
        self._write("progress.json", msgspec.json.encode(progress))

    def _load(self, name: str, kind: type[T]) -> T | None:
        raw = self._read(name)
        if raw is None:
            return None
        try:
            return msgspec.json.decode(raw, type=kind)
        except msgspec.DecodeError:
            return None

    def _read(self, name: str) -> bytes | None:
        if self._path is None or name in self._kept:
            return self._kept.get(name)
        try:
            return (self._path / name).read_bytes()
        except FileNotFoundError:
            return None

    def _write(self, name: str, data: bytes) -> None:
        self._kept[name] = data
        if self._path is None:
            return
        refused: OSError | None = None
        for waiting, content in list(self._kept.items()):
            try:
                self._replace(waiting, content)
            except OSError as error:
                refused = error
            else:
                del self._kept[waiting]
        if refused is not None and not self._is_refused:
            log.warning("%s takes nothing, what is new is remembered: %s", self._path, refused)
        self._is_refused = refused is not None

    def _replace(self, name: str, data: bytes) -> None:
        assert self._path is not None
        fresh = self._path / f".{name}.new"
        try:
            fresh.write_bytes(data)
            os.replace(fresh, self._path / name)
        except OSError:
            fresh.unlink(missing_ok=True)
            if name != SAFETY:
                raise
            with (self._path / name).open("r+b") as file:  # in its place, which needs no room; half of it latches
                file.write(data)
                file.truncate()
