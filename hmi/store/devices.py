"""Enrolled tablets: they carry a STOP token and let people sign in by PIN."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime

from sqlalchemy import select

from hmi.clock import Clock
from hmi.domain.ids import new_id
from hmi.store.database import Database
from hmi.store.errors import NotFound
from hmi.store.stop_list import StopList
from hmi.store.tables import DeviceRow


@dataclass(frozen=True, slots=True)
class Device:
    """One tablet or computer."""

    id: str
    farm_id: str
    name: str
    enrolled_by: str
    enrolled_at: datetime
    revoked_at: datetime | None


class Devices:
    """Blocking except ``is_revoked``; call through ``Database.run``."""

    def __init__(self, database: Database, clock: Clock, stop_list: StopList) -> None:
        self._database = database
        self._clock = clock
        self._stop_list = stop_list
        self._revoked: frozenset[str] = frozenset()

    def load(self) -> None:
        """Read which devices were taken out; at start, or after another console changed it."""
        with self._database.read() as session:
            self._revoked = frozenset(session.scalars(select(DeviceRow.id).where(DeviceRow.revoked_at.is_not(None))))

    def is_revoked(self, device_id: str) -> bool:
        """Say, from memory, whether a device was taken out."""
        return device_id in self._revoked

    def get(self, device_id: str) -> Device | None:
        """Return one device, revoked or not."""
        with self._database.read() as session:
            row = session.get(DeviceRow, device_id)
            return None if row is None else _device(row)

    def all(self, farm_id: str) -> list[Device]:
        """Return the devices of a farm by name, revoked ones too."""
        query = select(DeviceRow).filter_by(farm_id=farm_id).order_by(DeviceRow.name, DeviceRow.id)
        with self._database.read() as session:
            return [_device(row) for row in session.scalars(query)]

    def enrol(self, farm_id: str, name: str, by: str) -> Device:
        """Add a device under a fresh id."""
        row = DeviceRow(id=new_id(), farm_id=farm_id, name=name, enrolled_by=by, enrolled_at=self._clock.utc())
        with self._database.write() as session:
            session.add(row)
            session.flush()
            return _device(row)

    def revoke(self, farm_id: str, device_id: str) -> Device:
        """Take a lost tablet out: its STOP token and its PINs no longer work.

        Raises:
            NotFound: this farm has no such device.
            StopListNotWritten: revoked here, but the STOP gateway does not know yet.
        """
        with self._database.write() as session:
            row = session.get(DeviceRow, device_id)
            if row is None or row.farm_id != farm_id:
                raise NotFound(f"there is no device {device_id!r}")
            row.revoked_at = row.revoked_at or self._clock.utc()
            device = _device(row)
        self._revoked |= {device_id}
        self._stop_list.export()
        return device


def _device(row: DeviceRow) -> Device:
    return Device(row.id, row.farm_id, row.name, row.enrolled_by, row.enrolled_at, row.revoked_at)
