"""The tables of field sensors: stations, what they measured, how they are calibrated, limits."""

from __future__ import annotations

from datetime import datetime
from typing import Any

from sqlalchemy import JSON, Boolean, Float, ForeignKey, Index, Integer, String
from sqlalchemy.orm import Mapped, mapped_column

from hmi.store.tables import Base, UtcText

NO_DEPTH = -1
"""Depth of what has none: a key must not hold NULL."""


class SensorStationRow(Base):
    """A station that was accepted."""

    __tablename__ = "sensor_station"
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"), primary_key=True)
    id: Mapped[str] = mapped_column(String(64), primary_key=True)
    name: Mapped[str] = mapped_column(String(80))
    kind: Mapped[str] = mapped_column(String(16))
    lat_deg: Mapped[float] = mapped_column(Float)
    lon_deg: Mapped[float] = mapped_column(Float)
    period_s: Mapped[float] = mapped_column(Float)
    units: Mapped[list[Any]] = mapped_column(JSON, default=list)
    model: Mapped[str] = mapped_column(String(80), default="")
    parcel: Mapped[str] = mapped_column(String(80), default="")
    accepted_by: Mapped[str] = mapped_column(String(80))
    accepted_at: Mapped[datetime] = mapped_column(UtcText)
    battery: Mapped[float | None] = mapped_column(Float, default=None)
    heard_at: Mapped[datetime | None] = mapped_column(UtcText, default=None)
    pictures_day: Mapped[str] = mapped_column(String(10), default="")
    pictures: Mapped[int] = mapped_column(Integer, default=0)


class SensorReadingRow(Base):
    """Values of one channel from ``at`` on for ``step_s``; 0 is one value as it was measured."""

    __tablename__ = "sensor_reading"
    __table_args__ = (Index("sensor_reading_step", "step_s", "at"),)
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"), primary_key=True)
    station_id: Mapped[str] = mapped_column(String(64), primary_key=True)
    quantity: Mapped[str] = mapped_column(String(64), primary_key=True)
    depth_cm: Mapped[int] = mapped_column(Integer, primary_key=True)
    step_s: Mapped[int] = mapped_column(Integer, primary_key=True)
    at: Mapped[datetime] = mapped_column(UtcText, primary_key=True)
    mean: Mapped[float] = mapped_column(Float)
    low: Mapped[float] = mapped_column(Float)
    high: Mapped[float] = mapped_column(Float)
    count: Mapped[int] = mapped_column(Integer)


class SensorCalibrationRow(Base):
    """One calibration; the newest of a channel counts, the others say how it was before."""

    __tablename__ = "sensor_calibration"
    id: Mapped[str] = mapped_column(String(64), primary_key=True)
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"))
    station_id: Mapped[str] = mapped_column(String(64))
    quantity: Mapped[str] = mapped_column(String(64))
    depth_cm: Mapped[int] = mapped_column(Integer)
    offset: Mapped[float] = mapped_column(Float)
    gain: Mapped[float] = mapped_column(Float)
    note: Mapped[str] = mapped_column(String(200))
    by: Mapped[str] = mapped_column(String(80))
    at: Mapped[datetime] = mapped_column(UtcText)


class SensorLimitRow(Base):
    """One limit of the farm."""

    __tablename__ = "sensor_limit"
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"), primary_key=True)
    quantity: Mapped[str] = mapped_column(String(64), primary_key=True)
    depth_cm: Mapped[int] = mapped_column(Integer, primary_key=True)
    low: Mapped[float | None] = mapped_column(Float, default=None)
    high: Mapped[float | None] = mapped_column(Float, default=None)
    is_treatment: Mapped[bool] = mapped_column(Boolean, default=False)
    note: Mapped[str] = mapped_column(String(200), default="")
    by: Mapped[str] = mapped_column(String(80))
    at: Mapped[datetime] = mapped_column(UtcText)
