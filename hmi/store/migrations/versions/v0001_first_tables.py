"""Make the first tables, and let the audit only grow."""

from __future__ import annotations

from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None
branch_labels = None
depends_on = None

_SERIAL = sa.BigInteger().with_variant(sa.Integer(), "sqlite")
_TABLES = (
    "sample", "event", "audit", "mission_log", "mission", "feature", "robot", "session", "device", "user", "counter",
    "farm",
)  # fmt: skip


def upgrade() -> None:
    """Apply this step."""
    _farm()
    _people()
    _robots()
    _land_and_missions()
    _audit()
    _records()
    _guard_audit()


def downgrade() -> None:
    """Take this step back; everything recorded is lost."""
    if op.get_bind().dialect.name == "postgresql":
        op.execute("DROP TRIGGER audit_only_grows ON audit")
        op.execute("DROP FUNCTION audit_only_grows()")
    for table in _TABLES:
        op.drop_table(table)


def _id() -> sa.Column[str]:
    return sa.Column("id", sa.String(64), primary_key=True)


def _text(name: str, width: int, *, nullable: bool = False, index: bool = False) -> sa.Column[str]:
    return sa.Column(name, sa.String(width), nullable=nullable, index=index)


def _time(name: str, *, nullable: bool = False, index: bool = False) -> sa.Column[str]:
    return _text(name, 32, nullable=nullable, index=index)


def _farm_id(*, index: bool = True) -> sa.Column[str]:
    return sa.Column("farm_id", sa.String(64), sa.ForeignKey("farm.id"), nullable=False, index=index)


def _not_null(name: str, kind: sa.types.TypeEngine[Any]) -> sa.Column[Any]:
    return sa.Column(name, kind, nullable=False)


def _farm() -> None:
    op.create_table("farm", _id(), _text("name", 80), _time("created_at"))
    op.create_table(
        "counter",
        sa.Column("farm_id", sa.String(64), sa.ForeignKey("farm.id"), primary_key=True),
        sa.Column("name", sa.String(64), primary_key=True),
        _not_null("value", sa.Integer()),
    )


def _people() -> None:
    op.create_table(
        "user",
        _id(),
        _farm_id(),
        _text("name", 80),
        _text("role", 16),
        _not_null("password_hash", sa.Text()),
        sa.Column("pin_hash", sa.Text()),
        _not_null("is_active", sa.Boolean()),
        _not_null("preferences", sa.JSON()),
        _time("created_at"),
    )
    op.create_table(
        "device",
        _id(),
        _farm_id(),
        _text("name", 80),
        _text("enrolled_by", 64),
        _time("enrolled_at"),
        _time("revoked_at", nullable=True),
    )
    op.create_table(
        "session",
        _id(),
        _farm_id(),
        sa.Column("user_id", sa.String(64), sa.ForeignKey("user.id"), nullable=False, index=True),
        _text("device_id", 64, nullable=True),
        _text("csrf", 64),
        _time("created_at"),
        _time("expires_at"),
        _time("ended_at", nullable=True),
    )


def _robots() -> None:
    op.create_table(
        "robot",
        _id(),
        _farm_id(),
        _text("name", 80),
        _text("family", 16),
        _text("http_url", 300, nullable=True),
        _text("http_token", 200, nullable=True),
        _text("contact_name", 80, nullable=True),
        _text("contact_phone", 40, nullable=True),
        _not_null("ack_limit_s", sa.Float()),
        _not_null("standstill_limit_s", sa.Float()),
        _not_null("decel_mps2", sa.Float()),
        _not_null("keep_out_m", sa.Float()),
        _not_null("is_unattended_allowed", sa.Boolean()),
        _text("added_by", 64),
        _time("added_at"),
        _time("removed_at", nullable=True),
    )


def _land_and_missions() -> None:
    op.create_table(
        "feature",
        _id(),
        _farm_id(),
        _text("kind", 24),
        _text("name", 80),
        _not_null("properties", sa.JSON()),
        _not_null("geometry", sa.JSON()),
        _not_null("map_version", sa.Integer()),
        _time("created_at"),
    )
    op.create_table(
        "mission",
        _id(),
        _farm_id(),
        _not_null("revision", sa.Integer()),
        _text("name", 80),
        _text("field_id", 64, nullable=True),
        _text("field_name", 80),
        _text("robot_id", 64, nullable=True, index=True),
        _text("status", 16),
        _not_null("is_supervised", sa.Boolean()),
        _not_null("document", sa.JSON()),
        _text("sha256", 64),
        _not_null("statistics", sa.JSON()),
        _text("created_by", 64),
        _time("created_at"),
        _time("updated_at"),
    )
    op.create_table(
        "mission_log",
        sa.Column("id", sa.Integer(), primary_key=True, autoincrement=True),
        _farm_id(),
        sa.Column("mission_id", sa.String(64), sa.ForeignKey("mission.id"), nullable=False, index=True),
        _time("at"),
        _text("status", 16),
        _text("by", 64),
        _not_null("why", sa.Text()),
        _not_null("data", sa.JSON()),
    )


def _audit() -> None:
    op.create_table(
        "audit",
        sa.Column("seq", _SERIAL, primary_key=True, autoincrement=True),
        _farm_id(index=False),
        _time("at", index=True),
        _text("actor", 80),
        _text("device", 80),
        _text("kind", 32, index=True),
        _text("robot_id", 64, nullable=True, index=True),
        _text("ref", 64),
        _text("outcome", 32),
        _not_null("text", sa.Text()),
        _not_null("data", sa.JSON()),
        _text("previous_hash", 64),
        _text("hash", 64),
    )
    op.create_index("audit_by_farm", "audit", ["farm_id", "seq"])


def _records() -> None:
    op.create_table(
        "event",
        sa.Column("robot_id", sa.String(64), primary_key=True),
        _id(),
        _farm_id(index=False),
        _text("mission_id", 64, nullable=True),
        _time("at"),
        _text("kind", 24),
        _text("name", 80),
        _not_null("text", sa.Text()),
        _not_null("data", sa.JSON()),
    )
    op.create_index("event_by_robot", "event", ["robot_id", "at"])
    op.create_index("event_by_farm", "event", ["farm_id", "at"])
    numbers = ("lat_deg", "lon_deg", "theta_rad", "speed_mps", "soc", "cross_track_m", "gnss_accuracy_m", "rtt_s")
    op.create_table(
        "sample",
        sa.Column("id", _SERIAL, primary_key=True, autoincrement=True),
        _farm_id(index=False),
        _text("robot_id", 64),
        _text("mission_id", 64, nullable=True),
        _time("at"),
        _not_null("period_s", sa.Integer()),
        *(sa.Column(name, sa.Float()) for name in numbers),
        _text("tool", 16, nullable=True),
        _text("mode", 16, nullable=True),
        sa.Column("row", sa.Integer()),
        sa.Column("area_done_m2", sa.Float()),
    )
    op.create_index("sample_by_robot", "sample", ["robot_id", "at"])
    op.create_index("sample_by_period", "sample", ["period_s", "at"])


def _guard_audit() -> None:
    """Refuse changes in the database itself: the chain shows tampering, this stops mistakes."""
    if op.get_bind().dialect.name == "sqlite":
        for verb in ("UPDATE", "DELETE"):
            op.execute(
                f"CREATE TRIGGER audit_no_{verb.lower()} BEFORE {verb} ON audit "
                "BEGIN SELECT RAISE(ABORT, 'the audit is append-only'); END"
            )
    else:
        op.execute(
            "CREATE FUNCTION audit_only_grows() RETURNS trigger LANGUAGE plpgsql AS "
            "$$ BEGIN RAISE EXCEPTION 'the audit is append-only' "
            "USING ERRCODE = 'integrity_constraint_violation'; END $$"
        )
        op.execute(
            "CREATE TRIGGER audit_only_grows BEFORE UPDATE OR DELETE OR TRUNCATE ON audit "
            "FOR EACH STATEMENT EXECUTE FUNCTION audit_only_grows()"
        )
