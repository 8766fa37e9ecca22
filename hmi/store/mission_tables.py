"""The tables beside a mission: its revisions, and what people ticked before a start."""

from __future__ import annotations

from datetime import datetime
from typing import Any

from sqlalchemy import JSON, ForeignKey, Integer, String, Text
from sqlalchemy.orm import Mapped, mapped_column

from hmi.store.tables import Base, UtcText


class MissionRevisionRow(Base):
    """One document of a mission. ``state``: whole (as planned), pending (sent, not read back), taken or dropped."""

    __tablename__ = "mission_revision"
    mission_id: Mapped[str] = mapped_column(ForeignKey("mission.id"), primary_key=True)
    revision: Mapped[int] = mapped_column(Integer, primary_key=True)
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"))
    sha256: Mapped[str] = mapped_column(String(64))
    state: Mapped[str] = mapped_column(String(16))
    by: Mapped[str] = mapped_column(String(80))
    why: Mapped[str] = mapped_column(Text, default="")
    at: Mapped[datetime] = mapped_column(UtcText)
    document: Mapped[dict[str, Any]] = mapped_column(JSON)
    statistics: Mapped[dict[str, Any]] = mapped_column(JSON, default=dict)


class ChecklistRow(Base):
    """What one person ticked before starting one robot, and until when it counts."""

    __tablename__ = "checklist"
    id: Mapped[str] = mapped_column(String(64), primary_key=True)
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"), index=True)
    robot_id: Mapped[str] = mapped_column(String(64), index=True)
    family: Mapped[str] = mapped_column(String(16))
    user_id: Mapped[str] = mapped_column(String(64))
    user_name: Mapped[str] = mapped_column(String(80))
    device: Mapped[str] = mapped_column(String(80), default="")
    ticked: Mapped[list[str]] = mapped_column(JSON)
    at: Mapped[datetime] = mapped_column(UtcText)
    valid_until: Mapped[datetime] = mapped_column(UtcText)
