"""The demo's field stations in an empty installation: taken in, with limits and with a season behind them."""

from __future__ import annotations

import os
from collections.abc import Iterable
from datetime import UTC, date, datetime, time, timedelta
from itertools import groupby

from msgspec import UNSET

from backend_clients.simulator.field.season import Reading
from backend_clients.simulator.field.station import StationConfig
from hmi.demo.stations import SEED, STATIONS, season
from hmi.domain.sensors.limit import SensorLimit
from hmi.domain.sensors.observation import SensorKind
from hmi.domain.sensors.quantity import Channel
from hmi.domain.sensors.series import Point
from hmi.domain.sensors.station import FieldStation
from hmi.store.database import Database
from hmi.store.sensor_history import DAY_S, TEN_MINUTES_S, SensorHistory
from hmi.store.sensor_stations import SensorStations

BY = "Headland demo"
DAYS = 120
MORE_WINDOWS = 3  # of 48 h each ten minutes before the last one: a chart of seven days has no holes
READ_A_DAY = 24
NOTE = "Comes with the demo."


def seed_stations(stations: SensorStations, now: datetime) -> list[FieldStation]:
    """Take the demo's stations in, if the farm has none and no limits; return them, none if nothing was done. Blocks.

    Whoever takes one out again keeps it so.
    """
    if stations.all() or stations.limits():
        return []
    made = [_station(one, now) for one in STATIONS]
    stations.put(made)
    limits = (
        SensorLimit(Channel("wind_speed"), high=5.0, is_treatment=True, note=NOTE, by=BY, at=now),
        SensorLimit(Channel("rain_rate"), high=0.5, is_treatment=True, note=NOTE, by=BY, at=now),
        SensorLimit(Channel("soil_moisture", 10), high=0.38, note=NOTE, by=BY, at=now),
    )
    stations.set_limits(limits)
    return made


def record_past(database_url: str, farm_id: str, now: datetime) -> None:
    """Write the past in a process of its own; blocks."""
    os.nice(10)  # the console and the operator come first
    database = Database(database_url)
    try:
        write_past(SensorHistory(database, farm_id), now)
    finally:
        database.close()


def write_past(history: SensorHistory, now: datetime) -> None:
    """Write what the stations measured before; some seconds of computing, blocks."""
    found = season(SEED, now, DAYS)
    first = _write_recent(history, found.recent, now)
    for _ in range(MORE_WINDOWS):
        first = _write_recent(history, season(SEED, first, 1).recent, first)
    days = (one for one in found.days if _begin(one.day) + timedelta(days=1) <= first)
    for (station, quantity, depth_m), group in groupby(days, key=lambda one: one[:3]):
        points = [Point(_begin(one.day), one.mean, one.low, one.high, READ_A_DAY) for one in group]
        history.put(station, Channel.of(quantity, depth_m), DAY_S, points)


def _write_recent(history: SensorHistory, readings: Iterable[Reading], now: datetime) -> datetime:
    """Write what was read each ten minutes; return when that began."""
    rows = sorted(readings, key=lambda one: (one.station, one.quantity, one.depth_m or 0.0, one.utc))
    for (station, quantity, depth_m), group in groupby(rows, key=lambda one: one[:3]):
        points = [Point(one.utc, one.value, one.value, one.value) for one in group]
        history.put(station, Channel.of(quantity, depth_m), TEN_MINUTES_S, points)
    return min((one.utc for one in rows), default=now)


def _begin(day: date) -> datetime:
    return datetime.combine(day, time(), UTC)


def _station(config: StationConfig, now: datetime) -> FieldStation:
    about = config.about(config.period_s)
    units = {
        Channel.of(one.quantity, None if one.depth_m is UNSET else one.depth_m): one.unit for one in about.quantities
    }
    return FieldStation(
        id=about.station, name=about.name, kind=SensorKind(about.kind), lat_deg=about.lat_deg, lon_deg=about.lon_deg,
        period_s=about.period_s, units=units, model=about.model, parcel=config.parcel, is_accepted=True,
        accepted_by=BY, accepted_at=now,
    )  # fmt: skip
