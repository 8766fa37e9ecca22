"""``I see it standing still``: what a person saw goes into the audit and nowhere else."""

from __future__ import annotations

from hmi.commands.audit_line import audit_line
from hmi.commands.gate import Gate
from hmi.commands.ports import AuditSink
from hmi.domain.role import Permission
from hmi.security.session_info import SessionInfo


class SeenService:
    """Records observations; never shown as a confirmation, since a person sees a robot, not its brake."""

    def __init__(self, gate: Gate, audit: AuditSink) -> None:
        self._gate, self._audit = gate, audit

    def note(self, actor: SessionInfo, robot_id: str, stop_id: str) -> None:
        """Record that this person saw the robot stand still.

        Raises:
            OrderRefused: no right, or no such robot.
        """
        robot = self._gate.right(actor, Permission.WATCH, robot_id)
        text = f"{actor.user_name} saw {robot.name} standing still."
        self._audit.append(audit_line(actor, "seen", "seen", text, ref=stop_id, robot_id=robot.id))
