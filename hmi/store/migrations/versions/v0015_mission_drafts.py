"""Add to a mission what a person chose so far, as long as it is a draft."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0015"
down_revision = "0014"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Apply this step; no mission of before is a draft."""
    op.add_column("mission", sa.Column("wish", sa.JSON(none_as_null=True), nullable=True))


def downgrade() -> None:
    """Take this step back; drafts have no path and cannot stay."""
    op.execute("DELETE FROM mission_log WHERE mission_id IN (SELECT id FROM mission WHERE status = 'draft')")
    op.execute("DELETE FROM mission WHERE status = 'draft'")
    with op.batch_alter_table("mission") as table:
        table.drop_column("wish")
