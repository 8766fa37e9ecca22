"""One order to several robots: each goes through the same gate as a single one and answers for itself.

Nothing here decides anything about a robot: rights, lease, freshness and the latch are asked by the services that
serve single orders. A robot that refuses, or does not answer, takes nothing from the others.
"""

from __future__ import annotations

import asyncio
import hashlib
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Protocol

from hmi.commands.ledger import CommandResult
from hmi.commands.mission_send import MissionSent
from hmi.commands.ports import AuditSink
from hmi.commands.service import CommandRequest
from hmi.domain.command import LEASED_ACTIONS, Action, Outcome
from hmi.domain.ids import new_id
from hmi.domain.lease import Lease
from hmi.security.session_info import SessionInfo
from hmi.store.audit_chain import AuditEntry

GROUP_ACTIONS = frozenset({Action.PAUSE, Action.RETURN_HOME, Action.ABORT})
"""What may be asked of several at once. Start and resume may not: each needs eyes on its own machine."""
MOST_ROBOTS = 1000


class Commands(Protocol):
    """``CommandService``, as far as groups need it."""

    async def submit(self, actor: SessionInfo, request: CommandRequest) -> CommandResult:
        """Send one command."""
        ...


class MissionSending(Protocol):
    """``MissionSender``, as far as groups need it."""

    async def send(self, actor: SessionInfo, robot_id: str, mission_id: str) -> MissionSent:
        """Send one mission."""
        ...


@dataclass(frozen=True, slots=True)
class RobotResult:
    """What became of a group's order at one robot; ``lease`` is the one in force, after an order that needs control."""

    robot_id: str
    outcome: Outcome
    code: str
    text: str
    lease: Lease | None = None


class FleetActions:
    """Sends to several robots and gathers what each of them answered.

    Args:
        lease_of: the lease in force of a robot.
    """

    def __init__(
        self,
        commands: Commands,
        missions: MissionSending,
        lease_of: Callable[[str], Lease | None],
        audit: AuditSink,
    ) -> None:
        self._commands, self._missions, self._lease_of, self._audit = commands, missions, lease_of, audit

    async def act(
        self, actor: SessionInfo, action: Action, robots: Sequence[str], tick_id: str, group_id: str = ""
    ) -> list[RobotResult]:
        """Send one command to each robot, all at once; results in the order of ``robots``.

        Args:
            group_id: the same id again acts once; a retry of those that failed needs a new one.
        """
        ref = group_id or new_id()

        async def one(robot_id: str) -> RobotResult:
            request = CommandRequest(robot_id, action, _command_id(ref, robot_id), tick_id)
            result = await self._commands.submit(actor, request)
            lease = self._lease_of(robot_id) if action in LEASED_ACTIONS else None
            return RobotResult(robot_id, result.outcome, result.code, result.text, lease)

        # All at once: behind silent ones, each of which takes two seconds, the tick would be too old for the rest.
        results = list(await asyncio.gather(*(one(robot_id) for robot_id in dict.fromkeys(robots))))
        self._note(actor, action.value, ref, results)
        return results

    async def send(self, actor: SessionInfo, pairs: Iterable[tuple[str, str]]) -> list[RobotResult]:
        """Send stored missions, ``(robot, mission)`` each; one after the other, so that no mission goes to two."""
        results = []
        for robot_id, mission_id in pairs:
            sent = await self._missions.send(actor, robot_id, mission_id)
            results.append(RobotResult(robot_id, sent.outcome, sent.code, sent.text))
        self._note(actor, "mission", new_id(), results)
        return results

    def _note(self, actor: SessionInfo, what: str, ref: str, results: Sequence[RobotResult]) -> None:
        taken = sum(one.outcome is Outcome.ACCEPTED for one in results)
        left = {one.robot_id: one.code for one in results if one.outcome is not Outcome.ACCEPTED}
        outcome = "accepted" if not left else "rejected" if not taken else "partly"
        text = f"{what} to {len(results)} robots, {taken} took it."
        told = {key: left[key] for key in list(left)[:100]}
        self._audit.append(
            AuditEntry(actor.farm_id, actor.user_name, actor.device_name, "group", outcome, None, ref, text, told)
        )


def _command_id(ref: str, robot_id: str) -> str:
    """The ledger acts once for each id, so it must follow from group and robot alone."""
    return hashlib.sha256(f"{ref}/{robot_id}".encode()).hexdigest()[:32]
