"""The tables, as SQLAlchemy 2 models; migrations in ``hmi/store/migrations`` are made from them.

Every row belongs to a farm. Times are UTC text in ISO 8601 with milliseconds (``UtcText``), so that SQLite
and PostgreSQL sort and store them alike.
"""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Any

from sqlalchemy import JSON, BigInteger, Boolean, Float, ForeignKey, Index, Integer, String, Text, TypeDecorator
from sqlalchemy.engine import Dialect
from sqlalchemy.orm import DeclarativeBase, Mapped, mapped_column


class UtcText(TypeDecorator[datetime]):
    """An aware UTC datetime kept as sortable text."""

    impl = String(32)
    cache_ok = True

    def process_bind_param(self, value: datetime | None, dialect: Dialect) -> str | None:
        """Refuse naive times; write ISO 8601 with milliseconds."""
        if value is None:
            return None
        if value.tzinfo is None:
            raise ValueError("a naive time was about to be stored")
        return value.astimezone(UTC).isoformat(timespec="milliseconds")

    def process_result_value(self, value: Any | None, dialect: Dialect) -> datetime | None:
        """Read back what was written."""
        return None if value is None else datetime.fromisoformat(value)


_SERIAL = BigInteger().with_variant(Integer, "sqlite")  # 1,000 robots at 1 Hz pass 2^31 samples in 25 days


class Base(DeclarativeBase):
    """Root of all tables."""


class FarmRow(Base):
    """A farm, the tenant every other row belongs to."""

    __tablename__ = "farm"
    id: Mapped[str] = mapped_column(String(64), primary_key=True)
    name: Mapped[str] = mapped_column(String(80))
    created_at: Mapped[datetime] = mapped_column(UtcText)


class UserRow(Base):
    """A person. ``password_hash`` and ``pin_hash`` are argon2id strings."""

    __tablename__ = "user"
    id: Mapped[str] = mapped_column(String(64), primary_key=True)
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"), index=True)
    name: Mapped[str] = mapped_column(String(80))
    role: Mapped[str] = mapped_column(String(16))
    password_hash: Mapped[str] = mapped_column(Text)
    pin_hash: Mapped[str | None] = mapped_column(Text, default=None)
    is_active: Mapped[bool] = mapped_column(Boolean, default=True)
    preferences: Mapped[dict[str, Any]] = mapped_column(JSON, default=dict)
    created_at: Mapped[datetime] = mapped_column(UtcText)


class SessionRow(Base):
    """A signed-in browser; ``id`` is the SHA-256 of the cookie, so that the table leaks no cookie."""

    __tablename__ = "session"
    id: Mapped[str] = mapped_column(String(64), primary_key=True)
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"), index=True)
    user_id: Mapped[str] = mapped_column(ForeignKey("user.id"), index=True)
    device_id: Mapped[str | None] = mapped_column(String(64), default=None)
    csrf: Mapped[str] = mapped_column(String(64))
    created_at: Mapped[datetime] = mapped_column(UtcText)
    expires_at: Mapped[datetime] = mapped_column(UtcText)
    ended_at: Mapped[datetime | None] = mapped_column(UtcText, default=None)


class DeviceRow(Base):
    """An enrolled tablet, whose stop token works without sign-in."""

    __tablename__ = "device"
    id: Mapped[str] = mapped_column(String(64), primary_key=True)
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"), index=True)
    name: Mapped[str] = mapped_column(String(80))
    enrolled_by: Mapped[str] = mapped_column(String(64))
    enrolled_at: Mapped[datetime] = mapped_column(UtcText)
    revoked_at: Mapped[datetime | None] = mapped_column(UtcText, default=None)


class RobotRow(Base):
    """The registry: only robots in here can be operated; address and token come from here alone."""

    __tablename__ = "robot"
    id: Mapped[str] = mapped_column(String(64), primary_key=True)
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"), index=True)
    name: Mapped[str] = mapped_column(String(80))
    family: Mapped[str] = mapped_column(String(16))
    http_url: Mapped[str | None] = mapped_column(String(300), default=None)
    http_token: Mapped[str | None] = mapped_column(String(200), default=None)
    contact_name: Mapped[str | None] = mapped_column(String(80), default=None)
    contact_phone: Mapped[str | None] = mapped_column(String(40), default=None)
    ack_limit_s: Mapped[float] = mapped_column(Float, default=1.0)
    standstill_limit_s: Mapped[float] = mapped_column(Float, default=3.0)
    decel_mps2: Mapped[float] = mapped_column(Float, default=1.0)
    keep_out_m: Mapped[float] = mapped_column(Float, default=15.0)
    is_unattended_allowed: Mapped[bool] = mapped_column(Boolean, default=False)
    added_by: Mapped[str] = mapped_column(String(64))
    added_at: Mapped[datetime] = mapped_column(UtcText)
    removed_at: Mapped[datetime | None] = mapped_column(UtcText, default=None)


class FeatureRow(Base):
    """A published map feature: parcel, road, building, home, obstacle; GeoJSON geometry, lon/lat.

    Its id is the farm's own: a map that is imported on another farm keeps the ids of its file.
    """

    __tablename__ = "feature"
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"), primary_key=True)
    id: Mapped[str] = mapped_column(String(64), primary_key=True)
    kind: Mapped[str] = mapped_column(String(24))
    name: Mapped[str] = mapped_column(String(80))
    properties: Mapped[dict[str, Any]] = mapped_column(JSON, default=dict)
    geometry: Mapped[dict[str, Any]] = mapped_column(JSON)
    map_version: Mapped[int] = mapped_column(Integer, default=1)
    created_at: Mapped[datetime] = mapped_column(UtcText)


class MissionRow(Base):
    """A stored mission: the wire document the robot gets, its hash, and where it is in its life."""

    __tablename__ = "mission"
    id: Mapped[str] = mapped_column(String(64), primary_key=True)
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"), index=True)
    revision: Mapped[int] = mapped_column(Integer, default=1)
    name: Mapped[str] = mapped_column(String(80))
    field_id: Mapped[str | None] = mapped_column(String(64), default=None)
    field_name: Mapped[str] = mapped_column(String(80))
    robot_id: Mapped[str | None] = mapped_column(String(64), index=True, default=None)
    status: Mapped[str] = mapped_column(String(16), default="draft")
    is_supervised: Mapped[bool] = mapped_column(Boolean, default=True)
    document: Mapped[dict[str, Any]] = mapped_column(JSON)
    sha256: Mapped[str] = mapped_column(String(64))
    statistics: Mapped[dict[str, Any]] = mapped_column(JSON, default=dict)
    map_version: Mapped[int | None] = mapped_column(Integer, default=None)
    progress: Mapped[dict[str, Any] | None] = mapped_column(JSON, default=None)
    pending_sha256: Mapped[str] = mapped_column(String(64), default="", server_default="")
    wish: Mapped[dict[str, Any] | None] = mapped_column(JSON(none_as_null=True), default=None)
    created_by: Mapped[str] = mapped_column(String(64))
    created_at: Mapped[datetime] = mapped_column(UtcText)
    updated_at: Mapped[datetime] = mapped_column(UtcText)


class MissionLogRow(Base):
    """Who changed a mission's status, when and why."""

    __tablename__ = "mission_log"
    id: Mapped[int] = mapped_column(Integer, primary_key=True, autoincrement=True)
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"), index=True)
    mission_id: Mapped[str] = mapped_column(ForeignKey("mission.id"), index=True)
    at: Mapped[datetime] = mapped_column(UtcText)
    status: Mapped[str] = mapped_column(String(16))
    by: Mapped[str] = mapped_column(String(64))
    why: Mapped[str] = mapped_column(Text, default="")
    data: Mapped[dict[str, Any]] = mapped_column(JSON, default=dict)


class AuditRow(Base):
    """Append-only record of commands, stops, sign-ins and changes; each row hashes the one before it."""

    __tablename__ = "audit"
    seq: Mapped[int] = mapped_column(_SERIAL, primary_key=True, autoincrement=True)
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"))
    at: Mapped[datetime] = mapped_column(UtcText, index=True)
    actor: Mapped[str] = mapped_column(String(80))
    device: Mapped[str] = mapped_column(String(80), default="")
    kind: Mapped[str] = mapped_column(String(32), index=True)
    robot_id: Mapped[str | None] = mapped_column(String(64), index=True, default=None)
    ref: Mapped[str] = mapped_column(String(64), default="")
    outcome: Mapped[str] = mapped_column(String(32))
    text: Mapped[str] = mapped_column(Text, default="")
    data: Mapped[dict[str, Any]] = mapped_column(JSON, default=dict)
    previous_hash: Mapped[str] = mapped_column(String(64))
    hash: Mapped[str] = mapped_column(String(64))
    __table_args__ = (Index("audit_by_farm", "farm_id", "seq"),)


class EventRow(Base):
    """An event of a robot, kept once by robot and id: no robot can hide another's event by using its id."""

    __tablename__ = "event"
    robot_id: Mapped[str] = mapped_column(String(64), primary_key=True)
    id: Mapped[str] = mapped_column(String(64), primary_key=True)
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"))
    mission_id: Mapped[str | None] = mapped_column(String(64), default=None)
    at: Mapped[datetime] = mapped_column(UtcText)
    kind: Mapped[str] = mapped_column(String(24))
    name: Mapped[str] = mapped_column(String(80))
    text: Mapped[str] = mapped_column(Text, default="")
    data: Mapped[dict[str, Any]] = mapped_column(JSON, default=dict)
    __table_args__ = (Index("event_by_robot", "robot_id", "at"), Index("event_by_farm", "farm_id", "at"))


class SampleRow(Base):
    """Down-sampled telemetry: one row a robot and period (1 s fresh, 10 s after a day, 60 s after a month)."""

    __tablename__ = "sample"
    id: Mapped[int] = mapped_column(_SERIAL, primary_key=True, autoincrement=True)
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"))
    robot_id: Mapped[str] = mapped_column(String(64))
    mission_id: Mapped[str | None] = mapped_column(String(64), default=None)
    at: Mapped[datetime] = mapped_column(UtcText)
    period_s: Mapped[int] = mapped_column(Integer, default=1)
    lat_deg: Mapped[float | None] = mapped_column(Float, default=None)
    lon_deg: Mapped[float | None] = mapped_column(Float, default=None)
    theta_rad: Mapped[float | None] = mapped_column(Float, default=None)
    speed_mps: Mapped[float | None] = mapped_column(Float, default=None)
    soc: Mapped[float | None] = mapped_column(Float, default=None)
    cross_track_m: Mapped[float | None] = mapped_column(Float, default=None)
    gnss_accuracy_m: Mapped[float | None] = mapped_column(Float, default=None)
    rtt_s: Mapped[float | None] = mapped_column(Float, default=None)
    tool: Mapped[str | None] = mapped_column(String(16), default=None)
    mode: Mapped[str | None] = mapped_column(String(16), default=None)
    row: Mapped[int | None] = mapped_column(Integer, default=None)
    area_done_m2: Mapped[float | None] = mapped_column(Float, default=None)
    joints: Mapped[dict[str, float] | None] = mapped_column(JSON(none_as_null=True), default=None)
    __table_args__ = (Index("sample_by_robot", "robot_id", "at"), Index("sample_by_period", "period_s", "at"))


class CounterRow(Base):
    """A number that only grows, e.g. the lease epoch: fencing tokens stay ordered across restarts."""

    __tablename__ = "counter"
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"), primary_key=True)
    name: Mapped[str] = mapped_column(String(64), primary_key=True)
    value: Mapped[int] = mapped_column(Integer, default=0)
