"""The table of planning templates."""

from __future__ import annotations

from datetime import datetime
from typing import Any

from sqlalchemy import JSON, ForeignKey, String, UniqueConstraint
from sqlalchemy.orm import Mapped, mapped_column

from hmi.store.tables import Base, UtcText


class PlanTemplateRow(Base):
    """Choices for planning a mission, kept under a name."""

    __tablename__ = "plan_template"
    __table_args__ = (UniqueConstraint("farm_id", "name", name="plan_template_name"),)
    id: Mapped[str] = mapped_column(String(64), primary_key=True)
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"))
    name: Mapped[str] = mapped_column(String(80))
    wish: Mapped[dict[str, Any]] = mapped_column(JSON)
    created_by: Mapped[str] = mapped_column(String(80))
    created_at: Mapped[datetime] = mapped_column(UtcText)
