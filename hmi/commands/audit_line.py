"""What a person did, as a line of the audit."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hmi.security.session_info import SessionInfo
from hmi.store.audit_chain import AuditEntry


def audit_line(
    session: SessionInfo,
    kind: str,
    outcome: str,
    text: str,
    *,
    ref: str = "",
    robot_id: str | None = None,
    data: Mapping[str, Any] | None = None,
) -> AuditEntry:
    """Return the line; see ``AuditLine`` for what its parts say."""
    return AuditEntry(session.farm_id, session.user_name, session.device_name, kind, outcome, robot_id, ref, text, data)
