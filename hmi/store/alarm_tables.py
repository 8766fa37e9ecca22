"""The tables of alarms: those that are not normal, the journal of every step, and settings such as notifications."""

from __future__ import annotations

from datetime import datetime
from typing import Any

from sqlalchemy import JSON, Boolean, ForeignKey, Index, Integer, String
from sqlalchemy.orm import Mapped, mapped_column

from hmi.store.tables import Base, UtcText

ID_CHARS = 180  # code, source and detail with dots between


class AlarmRow(Base):
    """An alarm that is not normal or put aside, so that a restart forgets neither answers nor shelves."""

    __tablename__ = "alarm"
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"), primary_key=True)
    id: Mapped[str] = mapped_column(String(ID_CHARS), primary_key=True)
    code: Mapped[str] = mapped_column(String(64))
    source: Mapped[str] = mapped_column(String(64))
    detail: Mapped[str] = mapped_column(String(48), default="")
    phase: Mapped[str] = mapped_column(String(16))
    text: Mapped[str] = mapped_column(String(400), default="")
    advice: Mapped[str] = mapped_column(String(400), default="")
    priority: Mapped[int | None] = mapped_column(Integer, default=None)
    raised_at: Mapped[datetime | None] = mapped_column(UtcText, default=None)
    returned_at: Mapped[datetime | None] = mapped_column(UtcText, default=None)
    seen_by: Mapped[str] = mapped_column(String(80), default="")
    seen_at: Mapped[datetime | None] = mapped_column(UtcText, default=None)
    shelf: Mapped[dict[str, Any] | None] = mapped_column(JSON, default=None)
    out_of_service: Mapped[dict[str, Any] | None] = mapped_column(JSON, default=None)
    occurrences: Mapped[int] = mapped_column(Integer, default=0)
    escalated_at: Mapped[datetime | None] = mapped_column(UtcText, default=None)
    unanswered_at: Mapped[datetime | None] = mapped_column(UtcText, default=None)


class AlarmJournalRow(Base):
    """One step in the life of an alarm; only ever added to. ``by`` is empty for the console itself."""

    __tablename__ = "alarm_journal"
    id: Mapped[int] = mapped_column(Integer, primary_key=True, autoincrement=True)
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"))
    at: Mapped[datetime] = mapped_column(UtcText)
    alarm_id: Mapped[str] = mapped_column(String(ID_CHARS))
    code: Mapped[str] = mapped_column(String(64))
    source: Mapped[str] = mapped_column(String(64))
    name: Mapped[str] = mapped_column(String(80))
    title: Mapped[str] = mapped_column(String(80))
    what: Mapped[str] = mapped_column(String(16))
    priority: Mapped[int] = mapped_column(Integer)
    is_shown: Mapped[bool] = mapped_column(Boolean)
    by: Mapped[str] = mapped_column(String(80), default="")
    device: Mapped[str] = mapped_column(String(80), default="")
    text: Mapped[str] = mapped_column(String(400), default="")
    waited_s: Mapped[int | None] = mapped_column(Integer, default=None)
    __table_args__ = (
        Index("alarm_journal_by_time", "farm_id", "at"),
        Index("alarm_journal_by_alarm", "farm_id", "alarm_id", "at"),
    )


class AlarmSettingRow(Base):
    """A setting of alarms by name: after how long nobody's answer escalates, who is notified and how."""

    __tablename__ = "alarm_setting"
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"), primary_key=True)
    name: Mapped[str] = mapped_column(String(32), primary_key=True)
    value: Mapped[dict[str, Any]] = mapped_column(JSON)
    changed_by: Mapped[str] = mapped_column(String(80))
    changed_at: Mapped[datetime] = mapped_column(UtcText)
