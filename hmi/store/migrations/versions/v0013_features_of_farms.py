"""Let two farms of one database have a map feature of the same id, as a map that was exported and imported has."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0013"
down_revision = "0012"
branch_labels = None
depends_on = None

_KEY = "feature_pkey"  # as PostgreSQL calls it by itself
_BY_FARM = "ix_feature_farm_id"


def upgrade() -> None:
    """Apply this step; the new key finds the features of a farm, too."""
    op.drop_index(_BY_FARM, "feature")
    _key("farm_id", "id")


def downgrade() -> None:
    """Take this step back; that fails while two farms have a feature of the same id."""
    _key("id")
    op.create_index(_BY_FARM, "feature", ["farm_id"])


def _key(*columns: str) -> None:
    if op.get_bind().dialect.name == "postgresql":
        op.drop_constraint(_KEY, "feature", type_="primary")
        op.create_primary_key(_KEY, "feature", list(columns))
        return
    with op.batch_alter_table("feature", copy_from=_table(columns), recreate="always"):
        pass  # SQLite changes no key in place: the rows are copied into a table that has the new one


def _table(key: tuple[str, ...]) -> sa.Table:
    return sa.Table(
        "feature",
        sa.MetaData(),
        sa.Column("id", sa.String(64), nullable=False),
        sa.Column("farm_id", sa.String(64), sa.ForeignKey("farm.id"), nullable=False),
        sa.Column("kind", sa.String(24), nullable=False),
        sa.Column("name", sa.String(80), nullable=False),
        sa.Column("properties", sa.JSON(), nullable=False),
        sa.Column("geometry", sa.JSON(), nullable=False),
        sa.Column("map_version", sa.Integer(), nullable=False),
        sa.Column("created_at", sa.String(32), nullable=False),
        sa.PrimaryKeyConstraint(*key),
    )
