"""Resetting a STOP: the robot stands, everybody who pressed agrees, and nothing moves from it."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace

from hmi.commands.gate import Gate
from hmi.commands.lease_service import LeaseService
from hmi.commands.ledger import CommandResult, OrderLedger, Ticket
from hmi.commands.ports import FleetReader, Pressers
from hmi.commands.refusal import (
    HARDWARE_STOP,
    NEW_PRESS,
    NOT_STANDING,
    NOTHING_TO_RESET,
    OTHER_PRESS,
    REASON_MISSING,
    OrderRefused,
)
from hmi.commands.service import TTL_MS
from hmi.domain.command import ResetOrder
from hmi.domain.robot import Press, Robot
from hmi.domain.role import Permission
from hmi.domain.stop import STANDING_MPS
from hmi.security.session_info import SessionInfo

MAX_REASON = 200  # what the edge contract carries


@dataclass(frozen=True, slots=True)
class ResetRequest:
    """What a screen asks to be reset, and why."""

    robot_id: str
    reset_id: str
    stop_ids: tuple[str, ...]
    reason: str
    tick_id: str


async def nobody_known(_robot_id: str) -> Pressers:
    """Know of nobody who pressed: then a supervisor resets."""
    return {}


class ResetService:
    """Sends stop resets; the way and the answers are those of commands.

    Args:
        pressers: who pressed what is open at a robot, by account: the robot knows names alone, which may be shared.
    """

    def __init__(
        self,
        gate: Gate,
        leases: LeaseService,
        ledger: OrderLedger,
        fleet: FleetReader,
        pressers: Callable[[str], Awaitable[Pressers]] = nobody_known,
    ) -> None:
        self._gate, self._leases, self._ledger, self._fleet = gate, leases, ledger, fleet
        self._pressers = pressers

    async def reset(self, actor: SessionInfo, request: ResetRequest) -> CommandResult:
        """Ask the robot to clear presses; an accepted result says who else must reset before it is free."""
        ticket = Ticket(
            kind="stop-reset",
            ref=request.reset_id,
            robot_id=request.robot_id,
            what="reset",
            actor=actor,
            content=(*sorted(request.stop_ids), request.reason),
        )
        try:
            self._gate.right(actor, Permission.RESET, request.robot_id)
        except OrderRefused as refused:
            return self._ledger.refuse(ticket, refused)
        pressers = await self._pressers(request.robot_id)
        result = await self._ledger.place(ticket, lambda: self._order(actor, request, pressers))
        left = self._left_after(request)
        return replace(result, text=also_pressed(left)) if result.is_accepted and left else result

    def _order(self, actor: SessionInfo, request: ResetRequest, pressers: Pressers) -> ResetOrder:
        robot = self._gate.right(actor, Permission.RESET, request.robot_id)
        seen_s = self._gate.decided_now(request.tick_id)
        reason = request.reason.strip()[:MAX_REASON]
        if not reason:
            raise OrderRefused(REASON_MISSING, "Say why it was stopped: one tap on a reason.")
        challenge = self._gate.challenge(robot)
        wanted = self._wanted(robot, request, seen_s)
        others = [press for press in wanted if not _is_own(pressers.get(press.stop_id, frozenset()), actor)]
        if others and not self._gate.may(actor, Permission.RESET_FOR_OTHERS, robot):
            raise OrderRefused(OTHER_PRESS, _whose(others, actor))
        lease = self._leases.control(actor, robot)
        return ResetOrder(
            robot_id=robot.id,
            reset_id=request.reset_id,
            stop_ids=tuple(press.stop_id for press in wanted),
            by=actor.user_name,
            reason=reason,
            lease_token=lease.token,
            lease_seq=self._leases.next_seq(lease),
            ttl_ms=TTL_MS,
            challenge=challenge,
        )

    def _wanted(self, robot: Robot, request: ResetRequest, seen_s: float) -> list[Press]:
        safety = self._gate.safety(robot)
        if safety.hardware_stop:
            raise OrderRefused(HARDWARE_STOP, "Hardware button is pressed on the machine. Release it there first.")
        if not safety.standstill:
            raise OrderRefused(NOT_STANDING, f"{robot.name} has not confirmed standstill. Look before you reset.")
        if not safety.tool_off or safety.speed_mps > STANDING_MPS:  # it contradicts itself: the worse word counts
            text = f"{robot.name} says that it stands, and that its tool is on or that it moves. Look before you reset."
            raise OrderRefused(NOT_STANDING, text)
        wanted = [p for p in safety.presses if not p.is_reset and p.stop_id in request.stop_ids]
        if not wanted:
            raise OrderRefused(NOTHING_TO_RESET, "This stop is not latched on the robot any more.")
        if any(press.pressed_s > seen_s for press in wanted):
            raise OrderRefused(NEW_PRESS, "STOP was pressed again. Look at it, then reset again.")
        return wanted

    def _left_after(self, request: ResetRequest) -> list[Press]:
        robot = self._fleet.robot(request.robot_id)
        presses = robot.safety.presses if robot is not None and robot.safety is not None else ()
        return [p for p in presses if not p.is_reset and p.stop_id not in request.stop_ids]


def also_pressed(presses: Sequence[Press]) -> str:
    """Say who else pressed STOP, e.g. ``Anna Ostermeier also pressed STOP. They must reset theirs.``"""
    names = list(dict.fromkeys(p.by or p.device or "Somebody" for p in presses))
    listed = names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
    return f"{listed} also pressed STOP. They must reset theirs."


def _whose(others: Sequence[Press], actor: SessionInfo) -> str:
    if any(press.by == actor.user_name for press in others):
        return "A STOP with your name is not known as yours: another account, or before a restart. Ask a supervisor."
    return also_pressed(others)


def _is_own(users: AbstractSet[str], actor: SessionInfo) -> bool:
    # A press on a tablet nobody was signed in at belongs to no account: nobody could ever come and reset it as theirs,
    # so whoever looks after the robot does. Only the signed token says so, never a name. What nobody knows is no one's.
    return users in ({""}, {actor.user_id})
