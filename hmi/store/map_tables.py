"""The tables of the map builder: published versions, the draft, and its transactions."""

from __future__ import annotations

from datetime import datetime
from typing import Any

from sqlalchemy import JSON, Boolean, ForeignKey, Integer, String, UniqueConstraint
from sqlalchemy.orm import Mapped, mapped_column

from hmi.store.tables import Base, UtcText


class MapVersionRow(Base):
    """A map as it was published, whole; never changed afterwards."""

    __tablename__ = "map_version"
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"), primary_key=True)
    number: Mapped[int] = mapped_column(Integer, primary_key=True)
    by: Mapped[str] = mapped_column(String(80))
    note: Mapped[str] = mapped_column(String(200), default="")
    published_at: Mapped[datetime] = mapped_column(UtcText)
    features: Mapped[dict[str, Any]] = mapped_column(JSON)


class MapDraftRow(Base):
    """The one draft of a farm, with who edits it and until when."""

    __tablename__ = "map_draft"
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"), primary_key=True)
    base_version: Mapped[int] = mapped_column(Integer)
    features: Mapped[dict[str, Any]] = mapped_column(JSON)
    editor_id: Mapped[str] = mapped_column(String(64))
    editor_name: Mapped[str] = mapped_column(String(80))
    locked_until: Mapped[datetime] = mapped_column(UtcText)
    saved_at: Mapped[datetime] = mapped_column(UtcText)


class MapChangeRow(Base):
    """One transaction on the draft; gone with it."""

    __tablename__ = "map_change"
    __table_args__ = (UniqueConstraint("farm_id", "ref", name="map_change_ref"),)
    id: Mapped[int] = mapped_column(Integer, primary_key=True, autoincrement=True)
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"), index=True)
    ref: Mapped[str] = mapped_column(String(64))
    label: Mapped[str] = mapped_column(String(200))
    by: Mapped[str] = mapped_column(String(80))
    at: Mapped[datetime] = mapped_column(UtcText)
    changes: Mapped[list[dict[str, Any]]] = mapped_column(JSON)
    is_undone: Mapped[bool] = mapped_column(Boolean, default=False)
