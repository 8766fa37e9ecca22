"""Add to missions the map they were planned on, how far they came, and their revisions; add pre-start checklists."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Apply this step."""
    op.add_column("mission", sa.Column("map_version", sa.Integer(), nullable=True))
    op.add_column("mission", sa.Column("progress", sa.JSON(), nullable=True))
    op.add_column("mission", sa.Column("pending_sha256", sa.String(64), nullable=False, server_default=""))
    op.create_table(
        "mission_revision",
        sa.Column("mission_id", sa.String(64), sa.ForeignKey("mission.id"), primary_key=True),
        sa.Column("revision", sa.Integer(), primary_key=True),
        sa.Column("farm_id", sa.String(64), sa.ForeignKey("farm.id"), nullable=False),
        sa.Column("sha256", sa.String(64), nullable=False),
        sa.Column("state", sa.String(16), nullable=False),
        sa.Column("by", sa.String(80), nullable=False),
        sa.Column("why", sa.Text(), nullable=False),
        sa.Column("at", sa.String(32), nullable=False),
        sa.Column("document", sa.JSON(), nullable=False),
        sa.Column("statistics", sa.JSON(), nullable=False),
    )
    op.create_table(
        "checklist",
        sa.Column("id", sa.String(64), primary_key=True),
        sa.Column("farm_id", sa.String(64), sa.ForeignKey("farm.id"), nullable=False, index=True),
        sa.Column("robot_id", sa.String(64), nullable=False, index=True),
        sa.Column("family", sa.String(16), nullable=False),
        sa.Column("user_id", sa.String(64), nullable=False),
        sa.Column("user_name", sa.String(80), nullable=False),
        sa.Column("device", sa.String(80), nullable=False),
        sa.Column("ticked", sa.JSON(), nullable=False),
        sa.Column("at", sa.String(32), nullable=False),
        sa.Column("valid_until", sa.String(32), nullable=False),
    )


def downgrade() -> None:
    """Take this step back; what is lost are interrupted missions' places, revisions and checklists."""
    op.drop_table("checklist")
    op.drop_table("mission_revision")
    with op.batch_alter_table("mission") as table:
        for column in ("map_version", "progress", "pending_sha256"):
            table.drop_column(column)
