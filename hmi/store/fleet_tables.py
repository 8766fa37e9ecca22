"""The tables of the fleet screen: groups of robots, saved views, who is responsible, hand-overs, wall screens."""

from __future__ import annotations

from datetime import datetime
from typing import Any

from sqlalchemy import JSON, ForeignKey, Integer, String, UniqueConstraint
from sqlalchemy.orm import Mapped, mapped_column

from hmi.store.tables import Base, UtcText


class FleetGroupRow(Base):
    """Robots under a name; the farm's, not a person's."""

    __tablename__ = "fleet_group"
    __table_args__ = (UniqueConstraint("farm_id", "name", name="fleet_group_name"),)
    id: Mapped[str] = mapped_column(String(64), primary_key=True)
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"))
    name: Mapped[str] = mapped_column(String(80))
    robots: Mapped[list[str]] = mapped_column(JSON)
    changed_by: Mapped[str] = mapped_column(String(80))
    changed_at: Mapped[datetime] = mapped_column(UtcText)


class FleetViewRow(Base):
    """How one person looks at the fleet, under a name."""

    __tablename__ = "fleet_view"
    __table_args__ = (UniqueConstraint("farm_id", "user_id", "name", name="fleet_view_name"),)
    id: Mapped[str] = mapped_column(String(64), primary_key=True)
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"))
    user_id: Mapped[str] = mapped_column(String(64), index=True)
    name: Mapped[str] = mapped_column(String(80))
    filter: Mapped[dict[str, Any]] = mapped_column(JSON)
    created_at: Mapped[datetime] = mapped_column(UtcText)


class DutyRow(Base):
    """Who is responsible for a robot, and to whom it is offered."""

    __tablename__ = "duty"
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"), primary_key=True)
    robot_id: Mapped[str] = mapped_column(String(64), primary_key=True)
    user_id: Mapped[str] = mapped_column(String(64), default="")
    user_name: Mapped[str] = mapped_column(String(80), default="")
    since: Mapped[datetime | None] = mapped_column(UtcText, default=None)
    note: Mapped[str] = mapped_column(String(500), default="")
    offered_to: Mapped[str] = mapped_column(String(64), default="")
    offered_name: Mapped[str] = mapped_column(String(80), default="")
    offered_by: Mapped[str] = mapped_column(String(80), default="")
    offered_by_id: Mapped[str] = mapped_column(String(64), default="")
    offered_at: Mapped[datetime | None] = mapped_column(UtcText, default=None)
    offered_note: Mapped[str] = mapped_column(String(500), default="")


class HandOverRow(Base):
    """What was handed over, offered, taken or declined: the shift book."""

    __tablename__ = "hand_over"
    id: Mapped[int] = mapped_column(Integer, primary_key=True, autoincrement=True)
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"), index=True)
    at: Mapped[datetime] = mapped_column(UtcText)
    what: Mapped[str] = mapped_column(String(16))
    by: Mapped[str] = mapped_column(String(80))
    to_name: Mapped[str] = mapped_column(String(80), default="")
    robots: Mapped[list[str]] = mapped_column(JSON)
    note: Mapped[str] = mapped_column(String(500), default="")


class WallRow(Base):
    """A wall screen: its key opens a session that only watches and does not end. ``id`` is the SHA-256 of the key."""

    __tablename__ = "wall"
    id: Mapped[str] = mapped_column(String(64), primary_key=True)
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"), index=True)
    name: Mapped[str] = mapped_column(String(80))
    csrf: Mapped[str] = mapped_column(String(64))
    made_by: Mapped[str] = mapped_column(String(80))
    made_at: Mapped[datetime] = mapped_column(UtcText)
    revoked_at: Mapped[datetime | None] = mapped_column(UtcText, default=None)
