"""The files the console leaves for the gateway: robots, and tablets that may not press any more."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Annotated

import msgspec
from msgspec import Meta, Struct

from hmi.domain.ids import ID_PATTERN
from hmi.domain.stop import ACK_LIMIT_S, STANDSTILL_LIMIT_S, StopTarget

LOOK_S = 0.5  # how often the files' modification times are looked at
_log = logging.getLogger("headland.stop")


class RobotEntry(Struct, frozen=True):
    """One robot of ``robots.json``; fields this version does not know are ignored."""

    id: Annotated[str, Meta(pattern=ID_PATTERN + r"(?!\n)")]
    name: str = ""
    http_url: str | None = None
    token: str | None = None
    decel_mps2: float | None = None
    ack_limit_s: float | None = None
    standstill_limit_s: float | None = None
    keep_out_m: float | None = None
    contact_name: str | None = None
    contact_phone: str | None = None

    def target(self) -> StopTarget:
        """Return the robot with its limits inside the rules."""
        return StopTarget(
            self.id,
            self.name or self.id,
            self.decel_mps2,
            self.ack_limit_s or ACK_LIMIT_S,
            self.standstill_limit_s or STANDSTILL_LIMIT_S,
        )

    def card(self) -> dict[str, object]:
        """Return what a browser needs for its banner and its own limits; never address or token."""
        target = self.target()
        return {
            "name": target.name,
            "keep_out_m": self.keep_out_m,
            "contact_name": self.contact_name,
            "contact_phone": self.contact_phone,
            "ack_limit_ms": round(target.ack_limit_s * 1000),
            "standstill_limit_ms": round(target.standstill_limit_s * 1000),
        }


_robots = msgspec.json.Decoder(list[RobotEntry])
_devices = msgspec.json.Decoder(list[str])


class _Watched:
    """A file that is read again when its modification time or size changes."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._seen: tuple[int, int] | None = None

    def changed(self) -> bool:
        """Say whether the file is different from last time, and remember it as it is now."""
        try:
            stat = self.path.stat()
            now: tuple[int, int] | None = (stat.st_mtime_ns, stat.st_size)
        except OSError:
            now = None
        was, self._seen = self._seen, now
        return now != was

    def look_again(self) -> None:
        """Take the file for changed at the next look: this time it could not be read."""
        self._seen = None


class Registry:
    """Robots and revoked tablets, as the console last wrote them.

    A file that cannot be read changes nothing: the gateway goes on with what it knows.

    Args:
        folder: ``HEADLAND_DATA/stop``.
    """

    def __init__(self, folder: Path) -> None:
        self._robots_file = _Watched(folder / "robots.json")
        self._revoked_file = _Watched(folder / "revoked.json")
        self._robots: dict[str, RobotEntry] = {}
        self._revoked: frozenset[str] = frozenset()
        self.is_known = False

    @property
    def robots(self) -> dict[str, RobotEntry]:
        """Robots by id, in the console's order."""
        return self._robots

    def refresh(self) -> bool:
        """Read what changed; return whether the robots did."""
        if self._revoked_file.changed():
            self._read_revoked()
        return self._robots_file.changed() and self._read_robots()

    def is_revoked(self, device_id: str) -> bool:
        """Say whether this tablet may not press any more."""
        return device_id in self._revoked

    def target(self, robot_id: str) -> StopTarget:
        """Return a robot for STOP; one that is not registered gets the default limits."""
        entry = self._robots.get(robot_id)
        if entry is not None:
            return entry.target()
        return StopTarget.unregistered(robot_id) if self.is_known else StopTarget(robot_id, robot_id)

    def _read_robots(self) -> bool:
        try:
            entries = _robots.decode(self._robots_file.path.read_bytes())
        except (OSError, msgspec.DecodeError) as error:
            _log.warning("robots.json cannot be read, going on with %d robots: %s", len(self._robots), error)
            if isinstance(error, OSError):  # too many files are open, say; what it says wrong stays wrong
                self._robots_file.look_again()
            return False
        robots = {entry.id: entry for entry in entries}
        changed, self._robots, self.is_known = robots != self._robots or not self.is_known, robots, True
        return changed

    def _read_revoked(self) -> None:
        try:
            self._revoked = frozenset(_devices.decode(self._revoked_file.path.read_bytes()))
        except FileNotFoundError:
            self._revoked = frozenset()  # a missing file revokes nobody
        except (OSError, msgspec.DecodeError) as error:
            _log.warning("revoked.json cannot be read, going on with %d tablets: %s", len(self._revoked), error)
            if isinstance(error, OSError):
                self._revoked_file.look_again()
