"""Add groups of robots, saved views, who is responsible for which robot, the shift book, and wall screens."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0008"
down_revision = "0007"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Apply this step."""
    op.create_table(
        "fleet_group",
        sa.Column("id", sa.String(64), primary_key=True),
        sa.Column("farm_id", sa.String(64), sa.ForeignKey("farm.id"), nullable=False),
        sa.Column("name", sa.String(80), nullable=False),
        sa.Column("robots", sa.JSON(), nullable=False),
        sa.Column("changed_by", sa.String(80), nullable=False),
        sa.Column("changed_at", sa.String(32), nullable=False),
        sa.UniqueConstraint("farm_id", "name", name="fleet_group_name"),
    )
    op.create_table(
        "fleet_view",
        sa.Column("id", sa.String(64), primary_key=True),
        sa.Column("farm_id", sa.String(64), sa.ForeignKey("farm.id"), nullable=False),
        sa.Column("user_id", sa.String(64), nullable=False, index=True),
        sa.Column("name", sa.String(80), nullable=False),
        sa.Column("filter", sa.JSON(), nullable=False),
        sa.Column("created_at", sa.String(32), nullable=False),
        sa.UniqueConstraint("farm_id", "user_id", "name", name="fleet_view_name"),
    )
    _duty()
    op.create_table(
        "wall",
        sa.Column("id", sa.String(64), primary_key=True),
        sa.Column("farm_id", sa.String(64), sa.ForeignKey("farm.id"), nullable=False, index=True),
        sa.Column("name", sa.String(80), nullable=False),
        sa.Column("csrf", sa.String(64), nullable=False),
        sa.Column("made_by", sa.String(80), nullable=False),
        sa.Column("made_at", sa.String(32), nullable=False),
        sa.Column("revoked_at", sa.String(32), nullable=True),
    )


def _duty() -> None:
    op.create_table(
        "duty",
        sa.Column("farm_id", sa.String(64), sa.ForeignKey("farm.id"), primary_key=True),
        sa.Column("robot_id", sa.String(64), primary_key=True),
        sa.Column("user_id", sa.String(64), nullable=False),
        sa.Column("user_name", sa.String(80), nullable=False),
        sa.Column("since", sa.String(32), nullable=True),
        sa.Column("note", sa.String(500), nullable=False),
        sa.Column("offered_to", sa.String(64), nullable=False),
        sa.Column("offered_name", sa.String(80), nullable=False),
        sa.Column("offered_by", sa.String(80), nullable=False),
        sa.Column("offered_at", sa.String(32), nullable=True),
        sa.Column("offered_note", sa.String(500), nullable=False),
    )
    op.create_table(
        "hand_over",
        sa.Column("id", sa.Integer(), primary_key=True, autoincrement=True),
        sa.Column("farm_id", sa.String(64), sa.ForeignKey("farm.id"), nullable=False, index=True),
        sa.Column("at", sa.String(32), nullable=False),
        sa.Column("what", sa.String(16), nullable=False),
        sa.Column("by", sa.String(80), nullable=False),
        sa.Column("to_name", sa.String(80), nullable=False),
        sa.Column("robots", sa.JSON(), nullable=False),
        sa.Column("note", sa.String(500), nullable=False),
    )


def downgrade() -> None:
    """Take this step back; groups, views, duties and wall screens are lost."""
    for table in ("wall", "hand_over", "duty", "fleet_view", "fleet_group"):
        op.drop_table(table)
