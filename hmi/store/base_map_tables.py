"""The table of base maps; their tiles are files in the data folder."""

from __future__ import annotations

from datetime import datetime

from sqlalchemy import BigInteger, Float, ForeignKey, Integer, String, UniqueConstraint
from sqlalchemy.orm import Mapped, mapped_column

from hmi.store.tables import Base, UtcText


class BaseMapRow(Base):
    """One base map of a farm; ``sha256`` names its file."""

    __tablename__ = "base_map"
    __table_args__ = (UniqueConstraint("farm_id", "sha256", name="base_map_once"),)
    id: Mapped[str] = mapped_column(String(64), primary_key=True)
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"), index=True)
    name: Mapped[str] = mapped_column(String(80))
    kind: Mapped[str] = mapped_column(String(16))
    west_deg: Mapped[float] = mapped_column(Float)
    south_deg: Mapped[float] = mapped_column(Float)
    east_deg: Mapped[float] = mapped_column(Float)
    north_deg: Mapped[float] = mapped_column(Float)
    min_zoom: Mapped[int] = mapped_column(Integer)
    max_zoom: Mapped[int] = mapped_column(Integer)
    tile_px: Mapped[int] = mapped_column(Integer)
    schema: Mapped[str] = mapped_column(String(16), default="")
    media_type: Mapped[str] = mapped_column(String(64))
    credit: Mapped[str] = mapped_column(String(200), default="")
    size_bytes: Mapped[int] = mapped_column(BigInteger)
    sha256: Mapped[str] = mapped_column(String(64))
    by: Mapped[str] = mapped_column(String(80))
    added_at: Mapped[datetime] = mapped_column(UtcText)
