"""Add the queue of missions per robot."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"
branch_labels = None
depends_on = None

TABLES = ("queue_freeze", "queue_arming", "queue_blackout", "queue_revision", "queue_entry")


def upgrade() -> None:
    """Apply this step."""
    _entries()
    op.create_table(
        "queue_revision",
        sa.Column("farm_id", sa.String(64), sa.ForeignKey("farm.id"), primary_key=True),
        sa.Column("robot_id", sa.String(64), primary_key=True),
        sa.Column("number", sa.Integer(), nullable=False),
    )
    op.create_table(
        "queue_blackout",
        sa.Column("id", sa.String(64), primary_key=True),
        sa.Column("farm_id", sa.String(64), sa.ForeignKey("farm.id"), nullable=False, index=True),
        sa.Column("name", sa.String(80), nullable=False),
        sa.Column("days", sa.JSON(), nullable=False),
        sa.Column("from_min", sa.Integer(), nullable=False),
        sa.Column("to_min", sa.Integer(), nullable=False),
        sa.Column("robots", sa.JSON(), nullable=False),
    )
    op.create_table(
        "queue_arming",
        sa.Column("id", sa.Integer(), primary_key=True, autoincrement=True),
        sa.Column("farm_id", sa.String(64), sa.ForeignKey("farm.id"), nullable=False, index=True),
        sa.Column("arming_id", sa.String(64), nullable=False),
        sa.Column("robot_id", sa.String(64), nullable=False),
        sa.Column("revision", sa.Integer(), nullable=False),
        sa.Column("by", sa.String(80), nullable=False),
        sa.Column("armed_at", sa.String(32), nullable=False),
        sa.Column("until", sa.String(32), nullable=False),
        sa.Column("ended_at", sa.String(32), nullable=True),
        sa.Column("ended_why", sa.String(400), nullable=False),
    )
    op.create_table(
        "queue_freeze",
        sa.Column("farm_id", sa.String(64), sa.ForeignKey("farm.id"), primary_key=True),
        sa.Column("is_frozen", sa.Boolean(), nullable=False),
        sa.Column("by", sa.String(80), nullable=False),
        sa.Column("at", sa.String(32), nullable=False),
        sa.Column("stop_ids", sa.JSON(), nullable=False),
        sa.Column("released_by", sa.String(80), nullable=False),
        sa.Column("released_at", sa.String(32), nullable=True),
        sa.Column("reason", sa.String(200), nullable=False),
    )


def _entries() -> None:
    op.create_table(
        "queue_entry",
        sa.Column("id", sa.String(64), primary_key=True),
        sa.Column("farm_id", sa.String(64), sa.ForeignKey("farm.id"), nullable=False, index=True),
        sa.Column("robot_id", sa.String(64), nullable=False),
        sa.Column("mission_id", sa.String(64), nullable=False, index=True),
        sa.Column("position", sa.Integer(), nullable=False),
        sa.Column("is_unattended", sa.Boolean(), nullable=False),
        sa.Column("earliest", sa.String(32), nullable=True),
        sa.Column("window_s", sa.Integer(), nullable=False),
        sa.Column("repeat", sa.JSON(), nullable=True),
        sa.Column("conditions", sa.JSON(), nullable=False),
        sa.Column("place", sa.JSON(), nullable=True),
        sa.Column("state", sa.String(16), nullable=False, index=True),
        sa.Column("why", sa.String(400), nullable=False),
        sa.Column("added_by", sa.String(80), nullable=False),
        sa.Column("added_at", sa.String(32), nullable=False),
        sa.Column("started_at", sa.String(32), nullable=True),
        sa.Column("ended_at", sa.String(32), nullable=True),
    )


def downgrade() -> None:
    """Take this step back; queues and their record are lost, missions stay."""
    for table in TABLES:
        op.drop_table(table)
