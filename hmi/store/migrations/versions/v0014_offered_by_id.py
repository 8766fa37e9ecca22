"""Add to an offered hand-over who offered it, so that they can withdraw it though they are not responsible."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0014"
down_revision = "0013"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Apply this step; what was offered before can be withdrawn by who is responsible, as before."""
    op.add_column("duty", sa.Column("offered_by_id", sa.String(64), nullable=False, server_default=""))


def downgrade() -> None:
    """Take this step back; offers stay."""
    with op.batch_alter_table("duty") as table:
        table.drop_column("offered_by_id")
