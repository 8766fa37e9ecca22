"""Add to samples the joints as they were, so that a machine's posture can be replayed."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0009"
down_revision = "0008"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Apply this step."""
    op.add_column("sample", sa.Column("joints", sa.JSON(), nullable=True))


def downgrade() -> None:
    """Take this step back; what is lost are the recorded joints."""
    with op.batch_alter_table("sample") as table:
        table.drop_column("joints")
