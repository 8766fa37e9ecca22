"""``I see it standing still``: what a person saw goes into the audit and nowhere else."""

from __future__ import annotations

from hmi.commands.gate import Gate
from hmi.commands.ports import AuditSink
from hmi.domain.role import Permission
from hmi.security.session_info import SessionInfo
from hmi.store.audit_chain import AuditEntry


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
        self._audit.append(
            AuditEntry(
                farm_id=actor.farm_id,
                actor=actor.user_name,
                device=actor.device_name,
                kind="seen",
                outcome="seen",
                robot_id=robot.id,
                ref=stop_id,
                text=f"{actor.user_name} saw {robot.name} standing still.",
            )
        )
