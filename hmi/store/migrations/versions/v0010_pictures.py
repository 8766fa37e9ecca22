"""Add kept pictures and clips, and where the pictures of cameras come from."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0010"
down_revision = "0009"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Apply this step."""
    op.create_table(
        "picture",
        sa.Column("id", sa.String(64), primary_key=True),
        sa.Column("farm_id", sa.String(64), sa.ForeignKey("farm.id"), nullable=False),
        sa.Column("kind", sa.String(16), nullable=False),
        sa.Column("robot_id", sa.String(64), nullable=False),
        sa.Column("camera", sa.String(64), nullable=False),
        sa.Column("captured_at", sa.String(32), nullable=False),
        sa.Column("added_at", sa.String(32), nullable=False),
        sa.Column("age_s", sa.Float(), nullable=True),
        sa.Column("duration_s", sa.Float(), nullable=True),
        sa.Column("lat_deg", sa.Float(), nullable=True),
        sa.Column("lon_deg", sa.Float(), nullable=True),
        sa.Column("theta_rad", sa.Float(), nullable=True),
        sa.Column("position_age_s", sa.Float(), nullable=True),
        sa.Column("mission_id", sa.String(64), nullable=False),
        sa.Column("mission_name", sa.String(80), nullable=False),
        sa.Column("row_number", sa.Integer(), nullable=True),
        sa.Column("cause", sa.Text(), nullable=False),
        sa.Column("text", sa.Text(), nullable=False),
        sa.Column("note", sa.String(200), nullable=False),
        sa.Column("by", sa.String(80), nullable=False),
        sa.Column("device", sa.String(80), nullable=False),
        sa.Column("media_type", sa.String(32), nullable=False),
        sa.Column("width_px", sa.Integer(), nullable=False),
        sa.Column("height_px", sa.Integer(), nullable=False),
        sa.Column("size_bytes", sa.BigInteger(), nullable=False),
        sa.Column("sha256", sa.String(64), nullable=False),
        sa.Column("is_kept", sa.Boolean(), nullable=False),
    )
    op.create_index("picture_newest", "picture", ["farm_id", "captured_at", "id"])
    op.create_index("picture_of_robot", "picture", ["farm_id", "robot_id", "captured_at"])
    _sources()


def _sources() -> None:
    op.create_table(
        "camera_source",
        sa.Column("farm_id", sa.String(64), sa.ForeignKey("farm.id"), primary_key=True),
        sa.Column("robot_id", sa.String(64), primary_key=True),
        sa.Column("camera", sa.String(64), primary_key=True),
        sa.Column("kind", sa.String(16), nullable=False),
        sa.Column("label", sa.String(80), nullable=False),
        sa.Column("url", sa.String(300), nullable=False),
        sa.Column("user_name", sa.String(80), nullable=False),
        sa.Column("sealed", sa.Text(), nullable=False),
        sa.Column("token_sha256", sa.String(64), nullable=False),
        sa.Column("period_s", sa.Float(), nullable=False),
        sa.Column("keep_every_s", sa.Float(), nullable=False),
        sa.Column("width_px", sa.Integer(), nullable=False),
        sa.Column("height_px", sa.Integer(), nullable=False),
        sa.Column("changed_by", sa.String(80), nullable=False),
        sa.Column("changed_at", sa.String(32), nullable=False),
    )


def downgrade() -> None:
    """Take this step back; the files stay in the data folder."""
    op.drop_table("camera_source")
    op.drop_table("picture")
