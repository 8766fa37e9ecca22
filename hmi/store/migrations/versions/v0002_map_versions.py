"""Add published map versions, the draft and its transactions."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Apply this step."""
    op.create_table(
        "map_version",
        sa.Column("farm_id", sa.String(64), sa.ForeignKey("farm.id"), primary_key=True),
        sa.Column("number", sa.Integer(), primary_key=True),
        sa.Column("by", sa.String(80), nullable=False),
        sa.Column("note", sa.String(200), nullable=False),
        sa.Column("published_at", sa.String(32), nullable=False),
        sa.Column("features", sa.JSON(), nullable=False),
    )
    op.create_table(
        "map_draft",
        sa.Column("farm_id", sa.String(64), sa.ForeignKey("farm.id"), primary_key=True),
        sa.Column("base_version", sa.Integer(), nullable=False),
        sa.Column("features", sa.JSON(), nullable=False),
        sa.Column("editor_id", sa.String(64), nullable=False),
        sa.Column("editor_name", sa.String(80), nullable=False),
        sa.Column("locked_until", sa.String(32), nullable=False),
        sa.Column("saved_at", sa.String(32), nullable=False),
    )
    op.create_table(
        "map_change",
        sa.Column("id", sa.Integer(), primary_key=True, autoincrement=True),
        sa.Column("farm_id", sa.String(64), sa.ForeignKey("farm.id"), nullable=False, index=True),
        sa.Column("ref", sa.String(64), nullable=False),
        sa.Column("label", sa.String(200), nullable=False),
        sa.Column("by", sa.String(80), nullable=False),
        sa.Column("at", sa.String(32), nullable=False),
        sa.Column("changes", sa.JSON(), nullable=False),
        sa.Column("is_undone", sa.Boolean(), nullable=False),
        sa.UniqueConstraint("farm_id", "ref", name="map_change_ref"),
    )


def downgrade() -> None:
    """Take this step back; drafts and older versions are lost, the published map stays."""
    for table in ("map_change", "map_draft", "map_version"):
        op.drop_table(table)
