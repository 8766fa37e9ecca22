"""The tables of the queue: entries, a revision per robot, blackout windows, armings, and the freeze after STOP ALL."""

from __future__ import annotations

from datetime import datetime
from typing import Any

from sqlalchemy import JSON, Boolean, ForeignKey, Integer, String
from sqlalchemy.orm import Mapped, mapped_column

from hmi.store.tables import Base, UtcText


class QueueEntryRow(Base):
    """A place in a robot's queue; ended ones stay as the record of what the queue did."""

    __tablename__ = "queue_entry"
    id: Mapped[str] = mapped_column(String(64), primary_key=True)
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"), index=True)
    robot_id: Mapped[str] = mapped_column(String(64))
    mission_id: Mapped[str] = mapped_column(String(64), index=True)
    position: Mapped[int] = mapped_column(Integer)
    is_unattended: Mapped[bool] = mapped_column(Boolean)
    earliest: Mapped[datetime | None] = mapped_column(UtcText, default=None)
    window_s: Mapped[int] = mapped_column(Integer)
    repeat: Mapped[dict[str, Any] | None] = mapped_column(JSON, default=None)
    conditions: Mapped[dict[str, Any]] = mapped_column(JSON)
    place: Mapped[list[float] | None] = mapped_column(JSON, default=None)
    state: Mapped[str] = mapped_column(String(16), index=True)
    why: Mapped[str] = mapped_column(String(400), default="")
    added_by: Mapped[str] = mapped_column(String(80))
    added_at: Mapped[datetime] = mapped_column(UtcText)
    started_at: Mapped[datetime | None] = mapped_column(UtcText, default=None)
    ended_at: Mapped[datetime | None] = mapped_column(UtcText, default=None)


class QueueRevisionRow(Base):
    """Counts what people changed of a robot's queue; an arming holds for one revision."""

    __tablename__ = "queue_revision"
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"), primary_key=True)
    robot_id: Mapped[str] = mapped_column(String(64), primary_key=True)
    number: Mapped[int] = mapped_column(Integer, default=0)


class QueueBlackoutRow(Base):
    """A window in which nothing starts by itself; minutes on the farm's clock."""

    __tablename__ = "queue_blackout"
    id: Mapped[str] = mapped_column(String(64), primary_key=True)
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"), index=True)
    name: Mapped[str] = mapped_column(String(80))
    days: Mapped[list[int]] = mapped_column(JSON)
    from_min: Mapped[int] = mapped_column(Integer)
    to_min: Mapped[int] = mapped_column(Integer)
    robots: Mapped[list[str]] = mapped_column(JSON)


class QueueArmingRow(Base):
    """Who armed which queue, until when, and what ended it. A record only: a console starts with nothing armed."""

    __tablename__ = "queue_arming"
    id: Mapped[int] = mapped_column(Integer, primary_key=True, autoincrement=True)
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"), index=True)
    arming_id: Mapped[str] = mapped_column(String(64))
    robot_id: Mapped[str] = mapped_column(String(64))
    revision: Mapped[int] = mapped_column(Integer)
    by: Mapped[str] = mapped_column(String(80))
    armed_at: Mapped[datetime] = mapped_column(UtcText)
    until: Mapped[datetime] = mapped_column(UtcText)
    ended_at: Mapped[datetime | None] = mapped_column(UtcText, default=None)
    ended_why: Mapped[str] = mapped_column(String(400), default="")


class QueueFreezeRow(Base):
    """The freeze after STOP ALL; ``stop_ids`` are presses that were seen, so that none freezes twice."""

    __tablename__ = "queue_freeze"
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"), primary_key=True)
    is_frozen: Mapped[bool] = mapped_column(Boolean)
    by: Mapped[str] = mapped_column(String(80))
    at: Mapped[datetime] = mapped_column(UtcText)
    stop_ids: Mapped[list[str]] = mapped_column(JSON)
    released_by: Mapped[str] = mapped_column(String(80), default="")
    released_at: Mapped[datetime | None] = mapped_column(UtcText, default=None)
    reason: Mapped[str] = mapped_column(String(200), default="")
