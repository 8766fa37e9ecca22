"""Add field sensors: stations, what they measured, calibrations, limits."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0011"
down_revision = "0010"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Apply this step."""
    op.create_table(
        "sensor_station",
        sa.Column("farm_id", sa.String(64), sa.ForeignKey("farm.id"), primary_key=True),
        sa.Column("id", sa.String(64), primary_key=True),
        sa.Column("name", sa.String(80), nullable=False),
        sa.Column("kind", sa.String(16), nullable=False),
        sa.Column("lat_deg", sa.Float(), nullable=False),
        sa.Column("lon_deg", sa.Float(), nullable=False),
        sa.Column("period_s", sa.Float(), nullable=False),
        sa.Column("units", sa.JSON(), nullable=False),
        sa.Column("model", sa.String(80), nullable=False),
        sa.Column("parcel", sa.String(80), nullable=False),
        sa.Column("accepted_by", sa.String(80), nullable=False),
        sa.Column("accepted_at", sa.String(32), nullable=False),
        sa.Column("battery", sa.Float(), nullable=True),
        sa.Column("heard_at", sa.String(32), nullable=True),
        sa.Column("pictures_day", sa.String(10), nullable=False),
        sa.Column("pictures", sa.Integer(), nullable=False),
    )
    _readings()
    _settings()


def _readings() -> None:
    op.create_table(
        "sensor_reading",
        sa.Column("farm_id", sa.String(64), sa.ForeignKey("farm.id"), primary_key=True),
        sa.Column("station_id", sa.String(64), primary_key=True),
        sa.Column("quantity", sa.String(64), primary_key=True),
        sa.Column("depth_cm", sa.Integer(), primary_key=True),
        sa.Column("step_s", sa.Integer(), primary_key=True),
        sa.Column("at", sa.String(32), primary_key=True),
        sa.Column("mean", sa.Float(), nullable=False),
        sa.Column("low", sa.Float(), nullable=False),
        sa.Column("high", sa.Float(), nullable=False),
        sa.Column("count", sa.Integer(), nullable=False),
    )
    op.create_index("sensor_reading_step", "sensor_reading", ["step_s", "at"])


def _settings() -> None:
    op.create_table(
        "sensor_calibration",
        sa.Column("id", sa.String(64), primary_key=True),
        sa.Column("farm_id", sa.String(64), sa.ForeignKey("farm.id"), nullable=False),
        sa.Column("station_id", sa.String(64), nullable=False),
        sa.Column("quantity", sa.String(64), nullable=False),
        sa.Column("depth_cm", sa.Integer(), nullable=False),
        sa.Column("offset", sa.Float(), nullable=False),
        sa.Column("gain", sa.Float(), nullable=False),
        sa.Column("note", sa.String(200), nullable=False),
        sa.Column("by", sa.String(80), nullable=False),
        sa.Column("at", sa.String(32), nullable=False),
    )
    op.create_table(
        "sensor_limit",
        sa.Column("farm_id", sa.String(64), sa.ForeignKey("farm.id"), primary_key=True),
        sa.Column("quantity", sa.String(64), primary_key=True),
        sa.Column("depth_cm", sa.Integer(), primary_key=True),
        sa.Column("low", sa.Float(), nullable=True),
        sa.Column("high", sa.Float(), nullable=True),
        sa.Column("is_treatment", sa.Boolean(), nullable=False),
        sa.Column("note", sa.String(200), nullable=False),
        sa.Column("by", sa.String(80), nullable=False),
        sa.Column("at", sa.String(32), nullable=False),
    )


def downgrade() -> None:
    """Take this step back; what stations measured is lost."""
    for table in ("sensor_limit", "sensor_calibration", "sensor_reading", "sensor_station"):
        op.drop_table(table)
