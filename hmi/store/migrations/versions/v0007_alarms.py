"""Add alarms that are not normal, their journal, and their settings."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0007"
down_revision = "0006"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Apply this step."""
    op.create_table(
        "alarm",
        sa.Column("farm_id", sa.String(64), sa.ForeignKey("farm.id"), primary_key=True),
        sa.Column("id", sa.String(180), primary_key=True),
        sa.Column("code", sa.String(64), nullable=False),
        sa.Column("source", sa.String(64), nullable=False),
        sa.Column("detail", sa.String(48), nullable=False),
        sa.Column("phase", sa.String(16), nullable=False),
        sa.Column("text", sa.String(400), nullable=False),
        sa.Column("advice", sa.String(400), nullable=False),
        sa.Column("priority", sa.Integer(), nullable=True),
        sa.Column("raised_at", sa.String(32), nullable=True),
        sa.Column("returned_at", sa.String(32), nullable=True),
        sa.Column("seen_by", sa.String(80), nullable=False),
        sa.Column("seen_at", sa.String(32), nullable=True),
        sa.Column("shelf", sa.JSON(), nullable=True),
        sa.Column("out_of_service", sa.JSON(), nullable=True),
        sa.Column("occurrences", sa.Integer(), nullable=False),
        sa.Column("escalated_at", sa.String(32), nullable=True),
    )
    op.create_table(
        "alarm_journal",
        sa.Column("id", sa.Integer(), primary_key=True, autoincrement=True),
        sa.Column("farm_id", sa.String(64), sa.ForeignKey("farm.id"), nullable=False),
        sa.Column("at", sa.String(32), nullable=False),
        sa.Column("alarm_id", sa.String(180), nullable=False),
        sa.Column("code", sa.String(64), nullable=False),
        sa.Column("source", sa.String(64), nullable=False),
        sa.Column("name", sa.String(80), nullable=False),
        sa.Column("title", sa.String(80), nullable=False),
        sa.Column("what", sa.String(16), nullable=False),
        sa.Column("priority", sa.Integer(), nullable=False),
        sa.Column("is_shown", sa.Boolean(), nullable=False),
        sa.Column("by", sa.String(80), nullable=False),
        sa.Column("device", sa.String(80), nullable=False),
        sa.Column("text", sa.String(400), nullable=False),
        sa.Column("waited_s", sa.Integer(), nullable=True),
    )
    op.create_index("alarm_journal_by_time", "alarm_journal", ["farm_id", "at"])
    op.create_index("alarm_journal_by_alarm", "alarm_journal", ["farm_id", "alarm_id", "at"])
    op.create_table(
        "alarm_setting",
        sa.Column("farm_id", sa.String(64), sa.ForeignKey("farm.id"), primary_key=True),
        sa.Column("name", sa.String(32), primary_key=True),
        sa.Column("value", sa.JSON(), nullable=False),
        sa.Column("changed_by", sa.String(80), nullable=False),
        sa.Column("changed_at", sa.String(32), nullable=False),
    )


def downgrade() -> None:
    """Take this step back; answers to alarms, their journal and the settings are lost."""
    op.drop_table("alarm_setting")
    op.drop_table("alarm_journal")
    op.drop_table("alarm")
