"""What the STOP gateway must know, written to files so that it works without console and database.

``robots.json`` and ``revoked.json`` in ``HEADLAND_DATA/stop``, as laid down in docs/protocols/stop.md.
"""

from __future__ import annotations

import json
import os
import tempfile
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from sqlalchemy import select, union

from hmi.domain.keep_out import keep_out_m
from hmi.store.database import Database
from hmi.store.errors import StopListNotWritten
from hmi.store.fleet_tables import WallRow
from hmi.store.tables import DeviceRow, RobotRow, SessionRow, UserRow
from hmi.store.walls import device_of


class StopList:
    """Writes both files of one farm. Blocking, any thread."""

    def __init__(self, database: Database, farm_id: str, folder: Path) -> None:
        self._database = database
        self._farm_id = farm_id
        self._folder = folder
        self._own_keep_out: dict[str, float] | None = None  # not read yet
        self._one_at_a_time = threading.Lock()
        self.is_written = False

    def export(self) -> None:
        """Write what the database says now; readers see the old or the new file, never half of one.

        Raises:
            StopListNotWritten: the files are as before; ``is_written`` is False until a later call succeeds.
        """
        with self._one_at_a_time:
            self.is_written = False
            robots, revoked = self._robots(), self._revoked()
            try:
                self._folder.mkdir(parents=True, exist_ok=True)
                _replace(self._folder / "robots.json", robots)
                _replace(self._folder / "revoked.json", revoked)
            except OSError as error:
                raise StopListNotWritten(f"the list of the STOP gateway was not written: {error.strerror}") from error
            self.is_written = True

    def learn_keep_out(self, of_machines: Mapping[str, float]) -> None:
        """Take what machines say how far people must stay away, in metres by id; what it does not name stays.

        Raises:
            StopListNotWritten: as ``export``, which it calls where something changed.
        """
        with self._one_at_a_time:
            known = self._machines()
            if all(known.get(robot_id) == metres for robot_id, metres in of_machines.items()):
                return
            known.update(of_machines)
        self.export()

    def _machines(self) -> dict[str, float]:
        """What the machines said; that of before a restart is in the file, since a machine may be off now."""
        if self._own_keep_out is None:
            try:
                rows = json.loads((self._folder / "robots.json").read_text(encoding="utf-8"))
                self._own_keep_out = {row["id"]: row["own_keep_out_m"] for row in rows if row.get("own_keep_out_m")}
            except (OSError, ValueError, KeyError, TypeError, AttributeError):
                self._own_keep_out = {}
        return self._own_keep_out

    def _robots(self) -> list[dict[str, Any]]:
        machines = self._machines()
        query = select(RobotRow).filter_by(farm_id=self._farm_id, removed_at=None).order_by(RobotRow.id)
        with self._database.read() as session:
            return [_entry(row, machines.get(row.id)) for row in session.scalars(query)]

    def _revoked(self) -> list[str]:
        """Return revoked devices and wall screens, and the browsers of people who may no longer sign in."""
        devices = select(DeviceRow.id).where(DeviceRow.farm_id == self._farm_id, DeviceRow.revoked_at.is_not(None))
        enrolled = select(DeviceRow.id)
        browsers = (
            select(SessionRow.device_id)
            .join(UserRow, UserRow.id == SessionRow.user_id)
            .where(SessionRow.farm_id == self._farm_id, UserRow.is_active.is_(False))
            .where(SessionRow.device_id.is_not(None), SessionRow.device_id.not_in(enrolled))
        )
        walls = select(WallRow.id).where(WallRow.farm_id == self._farm_id, WallRow.revoked_at.is_not(None))
        with self._database.read() as session:
            screens = [device_of(wall_id) for wall_id in session.scalars(walls)]
            return sorted({*session.scalars(union(devices, browsers)), *screens})


def _entry(row: RobotRow, own_keep_out_m: float | None) -> dict[str, Any]:
    return {
        "id": row.id,
        "name": row.name,
        "http_url": row.http_url,
        "token": row.http_token,
        "decel_mps2": row.decel_mps2,
        "ack_limit_s": row.ack_limit_s,
        "standstill_limit_s": row.standstill_limit_s,
        "keep_out_m": keep_out_m(row.keep_out_m, own_keep_out_m),
        "own_keep_out_m": own_keep_out_m,
        "contact_name": row.contact_name,
        "contact_phone": row.contact_phone,
    }


def _replace(path: Path, value: Any) -> None:
    """Write beside and rename; ``mkstemp`` makes it readable by the owner only, for it holds robot tokens."""
    descriptor, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(descriptor, "w", encoding="utf-8") as file:
            json.dump(value, file)
            file.flush()
            os.fsync(file.fileno())
        os.replace(name, path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise
