"""Add to alarms since when they wait for an answer, so that coming and going does not put escalation off."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0012"
down_revision = "0011"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Apply this step; what waits for an answer now has done so since it was raised last."""
    op.add_column("alarm", sa.Column("unanswered_at", sa.String(32), nullable=True))
    op.execute("UPDATE alarm SET unanswered_at = raised_at WHERE phase IN ('unacknowledged', 'returned')")


def downgrade() -> None:
    """Take this step back; the times of waiting are counted from the last raising again."""
    with op.batch_alter_table("alarm") as table:
        table.drop_column("unanswered_at")
