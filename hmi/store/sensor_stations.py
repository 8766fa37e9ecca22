"""Accepted stations, their calibrations and the farm's limits. Blocking; call through ``Database.run``."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from sqlalchemy import delete, select

from hmi.domain.ids import new_id
from hmi.domain.sensors.calibration import Calibration
from hmi.domain.sensors.limit import SensorLimit
from hmi.domain.sensors.observation import SensorKind
from hmi.domain.sensors.quantity import Channel
from hmi.domain.sensors.station import FieldStation
from hmi.store.database import Database
from hmi.store.sensor_tables import NO_DEPTH, SensorCalibrationRow, SensorLimitRow, SensorStationRow

_PLAIN = ("name", "lat_deg", "lon_deg", "period_s", "model", "parcel", "accepted_by", "accepted_at", "battery",
          "heard_at", "pictures_day", "pictures")  # fmt: skip
_SAID = ("period_s", "model", "battery", "heard_at", "pictures_day", "pictures")


class SensorStations:
    """What people said of the stations of one farm.

    Args:
        farm_id: whose they are.
    """

    def __init__(self, database: Database, farm_id: str) -> None:
        self._database, self._farm_id = database, farm_id

    def all(self) -> list[FieldStation]:
        """Return every accepted station."""
        query = select(SensorStationRow).filter_by(farm_id=self._farm_id)
        with self._database.read() as session:
            return [_station(row) for row in session.scalars(query)]

    def put(self, stations: Iterable[FieldStation]) -> None:
        """Keep stations, in place of what is known of them."""
        with self._database.write() as session:
            for one in stations:
                parts = {name: getattr(one, name) for name in _PLAIN}
                row = SensorStationRow(
                    farm_id=self._farm_id, id=one.id, kind=one.kind.value, units=_unit_rows(one), **parts
                )
                session.merge(row)

    def note(self, stations: Iterable[FieldStation]) -> None:
        """Keep what stations themselves said; one that was taken out meanwhile stays out."""
        with self._database.write() as session:
            for one in stations:
                row = session.get(SensorStationRow, (self._farm_id, one.id))
                if row is None:
                    continue
                for name in _SAID:
                    setattr(row, name, getattr(one, name))
                row.units = _unit_rows(one)

    def remove(self, station_id: str) -> bool:
        """Forget a station and its calibrations; what it measured stays. Return whether there was one."""
        with self._database.write() as session:
            row = session.get(SensorStationRow, (self._farm_id, station_id))
            if row is None:
                return False
            session.delete(row)
            table = SensorCalibrationRow
            session.execute(delete(table).where(table.farm_id == self._farm_id, table.station_id == station_id))
            return True

    def calibrations(self) -> list[Calibration]:
        """Return every calibration there was, oldest first."""
        table = SensorCalibrationRow
        query = select(table).filter_by(farm_id=self._farm_id).order_by(table.at, table.id)
        with self._database.read() as session:
            return [_calibration(row) for row in session.scalars(query)]

    def add_calibration(self, one: Calibration) -> None:
        """Keep one more."""
        with self._database.write() as session:
            session.add(
                SensorCalibrationRow(
                    id=new_id(), farm_id=self._farm_id, station_id=one.station_id, offset=one.offset, gain=one.gain,
                    note=one.note, by=one.by, at=one.at, **_channel_columns(one.channel),
                )
            )  # fmt: skip

    def limits(self) -> list[SensorLimit]:
        """Return the farm's limits."""
        query = select(SensorLimitRow).filter_by(farm_id=self._farm_id)
        with self._database.read() as session:
            return [_limit(row) for row in session.scalars(query)]

    def set_limits(self, limits: Sequence[SensorLimit]) -> None:
        """Keep these and no others."""
        table = SensorLimitRow
        with self._database.write() as session:
            session.execute(delete(table).where(table.farm_id == self._farm_id))
            for one in limits:
                session.add(
                    table(
                        farm_id=self._farm_id, low=one.low, high=one.high, is_treatment=one.is_treatment,
                        note=one.note, by=one.by, at=one.at, **_channel_columns(one.channel),
                    )
                )  # fmt: skip


def _channel_columns(channel: Channel) -> dict[str, Any]:
    return {"quantity": channel.quantity, "depth_cm": NO_DEPTH if channel.depth_cm is None else channel.depth_cm}


def channel_of(quantity: str, depth_cm: int) -> Channel:
    """Return the channel that columns name."""
    return Channel(quantity, None if depth_cm == NO_DEPTH else depth_cm)


def _unit_rows(one: FieldStation) -> list[list[Any]]:
    return [[channel.quantity, channel.depth_cm, unit] for channel, unit in one.units.items()]


def _station(row: SensorStationRow) -> FieldStation:
    units = {Channel(quantity, depth_cm): unit for quantity, depth_cm, unit in row.units}
    parts = {name: getattr(row, name) for name in _PLAIN}
    return FieldStation(id=row.id, kind=SensorKind(row.kind), units=units, is_accepted=True, **parts)


def _calibration(row: SensorCalibrationRow) -> Calibration:
    channel = channel_of(row.quantity, row.depth_cm)
    return Calibration(row.station_id, channel, row.offset, row.gain, row.note, row.by, row.at)


def _limit(row: SensorLimitRow) -> SensorLimit:
    channel = channel_of(row.quantity, row.depth_cm)
    return SensorLimit(channel, row.low, row.high, row.is_treatment, row.note, row.by, row.at)
