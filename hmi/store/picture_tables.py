"""The tables of kept pictures and of where cameras' pictures come from; the pictures are files in the data folder."""

from __future__ import annotations

from datetime import datetime

from sqlalchemy import BigInteger, Boolean, Float, ForeignKey, Index, Integer, String, Text
from sqlalchemy.orm import Mapped, mapped_column

from hmi.store.tables import Base, UtcText


class PictureRow(Base):
    """One picture or clip of a farm; its file is named after ``id``."""

    __tablename__ = "picture"
    __table_args__ = (
        Index("picture_newest", "farm_id", "captured_at", "id"),
        Index("picture_of_robot", "farm_id", "robot_id", "captured_at"),
    )
    id: Mapped[str] = mapped_column(String(64), primary_key=True)
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"))
    kind: Mapped[str] = mapped_column(String(16))
    robot_id: Mapped[str] = mapped_column(String(64))
    camera: Mapped[str] = mapped_column(String(64))
    captured_at: Mapped[datetime] = mapped_column(UtcText)
    added_at: Mapped[datetime] = mapped_column(UtcText)
    age_s: Mapped[float | None] = mapped_column(Float, default=None)
    duration_s: Mapped[float | None] = mapped_column(Float, default=None)
    lat_deg: Mapped[float | None] = mapped_column(Float, default=None)
    lon_deg: Mapped[float | None] = mapped_column(Float, default=None)
    theta_rad: Mapped[float | None] = mapped_column(Float, default=None)
    position_age_s: Mapped[float | None] = mapped_column(Float, default=None)
    mission_id: Mapped[str] = mapped_column(String(64), default="")
    mission_name: Mapped[str] = mapped_column(String(80), default="")
    row_number: Mapped[int | None] = mapped_column(Integer, default=None)
    cause: Mapped[str] = mapped_column(Text, default="")
    text: Mapped[str] = mapped_column(Text, default="")
    note: Mapped[str] = mapped_column(String(200), default="")
    by: Mapped[str] = mapped_column(String(80), default="")
    device: Mapped[str] = mapped_column(String(80), default="")
    media_type: Mapped[str] = mapped_column(String(32))
    width_px: Mapped[int] = mapped_column(Integer)
    height_px: Mapped[int] = mapped_column(Integer)
    size_bytes: Mapped[int] = mapped_column(BigInteger)
    sha256: Mapped[str] = mapped_column(String(64))
    is_kept: Mapped[bool] = mapped_column(Boolean, default=False)


class CameraSourceRow(Base):
    """Where the pictures of one camera come from, if not from its robot.

    ``sealed`` is the password, encrypted with the installation's secret; ``token_sha256`` that of an upload's token.
    """

    __tablename__ = "camera_source"
    farm_id: Mapped[str] = mapped_column(ForeignKey("farm.id"), primary_key=True)
    robot_id: Mapped[str] = mapped_column(String(64), primary_key=True)
    camera: Mapped[str] = mapped_column(String(64), primary_key=True)
    kind: Mapped[str] = mapped_column(String(16))
    label: Mapped[str] = mapped_column(String(80), default="")
    url: Mapped[str] = mapped_column(String(300), default="")
    user_name: Mapped[str] = mapped_column(String(80), default="")
    sealed: Mapped[str] = mapped_column(Text, default="")
    token_sha256: Mapped[str] = mapped_column(String(64), default="")
    period_s: Mapped[float] = mapped_column(Float, default=5.0)
    keep_every_s: Mapped[float] = mapped_column(Float, default=900.0)
    width_px: Mapped[int] = mapped_column(Integer, default=0)
    height_px: Mapped[int] = mapped_column(Integer, default=0)
    changed_by: Mapped[str] = mapped_column(String(80))
    changed_at: Mapped[datetime] = mapped_column(UtcText)
