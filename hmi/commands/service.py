"""Commands from a screen to a robot: every question asked, sent once, answered honestly.

The way is docs/architecture.md: authorise, lease, freshness, send, await, audit. A command whose tick is older
than 2 s is refused, whatever it is: nothing executes late after any outage. Only STOP is exempt, and lives apart.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from hmi.commands.gate import Gate
from hmi.commands.lease_service import LeaseService
from hmi.commands.ledger import CommandResult, OrderLedger, Ticket
from hmi.commands.ports import StartRules
from hmi.commands.refusal import (
    ACTION_PERMISSION,
    FUNCTION_OFF,
    INCOMPLETE,
    NO_LEASE,
    OTHER_TARGET,
    UNKNOWN_NODE,
    WRONG_MISSION,
    OrderRefused,
)
from hmi.domain.command import LEASED_ACTIONS, NODE_ACTIONS, PLACE_ACTIONS, Action, CommandOrder, Point3
from hmi.domain.function_use import obstacle
from hmi.domain.robot import Order, OrderStatus, Robot
from hmi.security.session_info import SessionInfo

TTL_MS = 2000  # the robot refuses the order when it is older by its own clock
_MOVING = LEASED_ACTIONS - {Action.DRIVE_CLOSE}


@dataclass(frozen=True, slots=True)
class CommandRequest:
    """What a screen asks for; ``tick_id`` is the newest tick the screen had when the person decided.

    ``mission_id`` and ``mission_sha256`` are what the robot reported when the person began to confirm.
    ``node`` is for ``NODE_ACTIONS``, ``place`` (ENU metres of the robot's datum) for ``PLACE_ACTIONS``, ``target`` for
    ``SKIP_TARGET``: the point that the screen showed as worked at.
    """

    robot_id: str
    action: Action
    command_id: str
    tick_id: str
    mission_id: str | None = None
    mission_sha256: str | None = None
    checklist_id: str | None = None
    node: str | None = None
    place: Point3 | None = None
    target: str | None = None


@dataclass(frozen=True, slots=True)
class UnattendedStart:
    """Which mission an armed queue starts; robot and hash must be those it sent."""

    robot_id: str
    command_id: str
    mission_id: str
    sha256: str


class CommandService:
    """Sends instant actions. Refusals are results with code and sentence, never exceptions."""

    def __init__(self, gate: Gate, leases: LeaseService, ledger: OrderLedger, rules: StartRules | None = None) -> None:
        self._gate, self._leases, self._ledger, self._rules = gate, leases, ledger, rules

    async def submit(self, actor: SessionInfo, request: CommandRequest) -> CommandResult:
        """Send one command and return what became of it within 2 s.

        The same ``command_id`` from the same browser returns the same result and acts once.
        """
        action = request.action
        ticket = Ticket(
            kind="command",
            ref=request.command_id,
            robot_id=request.robot_id,
            what=action.value,
            actor=actor,
            content=(
                request.mission_id or "",
                request.mission_sha256 or "",
                request.node or "",
                str(request.place or ""),
                request.target or "",
            ),
            is_urgent=action not in LEASED_ACTIONS | NODE_ACTIONS,  # the room of pausing is for pausing alone
            about=_about(request),
        )
        try:
            robot = self._gate.right(actor, ACTION_PERMISSION[action], request.robot_id)
        except OrderRefused as refused:
            return self._ledger.refuse(ticket, refused)
        return await self._ledger.place(ticket, lambda: self._order(actor, robot, request))

    async def start_unattended(
        self, actor: SessionInfo, request: UnattendedStart, still: Callable[[], None]
    ) -> CommandResult:
        """Start a mission without a person at the moment, under the lease the console holds for an armed queue.

        No screen decides here, so there is no tick: ``still`` decides instead, in the moment of sending, and raises
        ``OrderRefused`` when anything is not as it must be. Everything else is asked as for a person.
        """
        ticket = Ticket(
            kind="command",
            ref=request.command_id,
            robot_id=request.robot_id,
            what=Action.START.value,
            actor=actor,
            content=(request.mission_id,),
        )

        def prepare() -> CommandOrder:
            robot = self._gate.right(actor, ACTION_PERMISSION[Action.START], request.robot_id)
            if self._leases.holds(actor.session_id, robot.id) is None:
                raise OrderRefused(NO_LEASE, "The queue has no control of the robot any more.")
            still()
            self._gate.may_move(robot)
            self._gate.knows_state(robot)
            _is_able(robot, Action.START)
            loaded = robot.state.order if robot.state is not None else None
            if loaded is None or (loaded.mission_id, loaded.sha256) != (request.mission_id, request.sha256):
                raise OrderRefused(WRONG_MISSION, f"{robot.name} holds another mission than the queue sent.")
            if self._rules is not None:
                self._rules.check_flight(robot, loaded)
            order = self._build(actor, robot, Action.START, request.command_id, mission=loaded)
            return replace(order, is_supervised=False)

        return await self._ledger.place(ticket, prepare)

    async def close_drive(self, actor: SessionInfo, robot_id: str, command_id: str) -> CommandResult:
        """End manual driving for the holder because nothing was pressed for long; moves nothing, takes nothing."""
        ticket = Ticket("command", command_id, robot_id, Action.DRIVE_CLOSE.value, actor, ("no input",))

        def prepare() -> CommandOrder:
            robot = self._gate.right(actor, ACTION_PERMISSION[Action.DRIVE_CLOSE], robot_id)
            if self._leases.holds(actor.session_id, robot_id) is None:
                raise OrderRefused(NO_LEASE, "Control has ended already.")
            return self._build(actor, robot, Action.DRIVE_CLOSE, command_id, mission=None)

        return await self._ledger.place(ticket, prepare)

    def _order(self, actor: SessionInfo, robot: Robot, request: CommandRequest) -> CommandOrder:
        self._gate.decided_now(request.tick_id)
        _is_complete(robot, request)
        if request.action in _MOVING:
            self._gate.may_move(robot)
        if request.action in (Action.START, Action.RESUME):
            self._gate.knows_state(robot)
        if request.action is Action.TOOL_GO_TO:
            self._gate.knows_joints(robot)
        _is_able(robot, request.action)
        _is_at_target(robot, request)
        mission = _mission(robot, request)
        if mission is not None and self._rules is not None:
            self._rules.check(actor, robot, mission, request.checklist_id)
        order = self._build(actor, robot, request.action, request.command_id, mission=mission)
        # a robot refuses what it does not know: the target goes only to those that say they understand it
        is_told = robot.factsheet is not None and robot.factsheet.skips_by_name
        return replace(order, node=request.node, place=request.place, target=request.target if is_told else None)

    def _build(
        self, actor: SessionInfo, robot: Robot, action: Action, command_id: str, *, mission: Order | None
    ) -> CommandOrder:
        challenge = self._gate.challenge(robot)
        token, seq = 0, 0
        if action in LEASED_ACTIONS:
            lease = self._leases.control(actor, robot)
            token, seq = lease.token, self._leases.next_seq(lease)
        return CommandOrder(
            robot_id=robot.id,
            command_id=command_id,
            action=action,
            by=actor.user_name,
            lease_token=token,
            lease_seq=seq,
            ttl_ms=TTL_MS,
            challenge=challenge,
            mission_id=mission.mission_id if mission is not None else None,
            mission_sha256=mission.sha256 if mission is not None else None,
            is_supervised=self._is_supervised(robot, mission),
        )

    def _is_supervised(self, robot: Robot, mission: Order | None) -> bool:
        # never the robot's own word: it says how the mission was started last, and knows nothing of one that was not
        return mission is None or self._rules is None or self._rules.is_supervised(robot, mission)


def _is_complete(robot: Robot, request: CommandRequest) -> None:
    """Refuse an order that lacks what it is about, or names a node the robot does not have."""
    if (request.node is not None) != (request.action in NODE_ACTIONS):
        raise OrderRefused(INCOMPLETE, "Starting, stopping and restarting name a node; nothing else does.")
    if (request.place is not None) != (request.action in PLACE_ACTIONS):
        raise OrderRefused(INCOMPLETE, "Sending it somewhere names a place; nothing else does.")
    if request.target is not None and request.action is not Action.SKIP_TARGET:
        raise OrderRefused(INCOMPLETE, "Skipping names the point that is skipped; nothing else does.")
    if request.place is not None and not all(math.isfinite(one) for one in request.place):
        raise OrderRefused(INCOMPLETE, "The place is not a number.")
    declared = robot.factsheet.nodes if robot.factsheet is not None else ()
    if request.node is not None and request.node not in robot.nodes and request.node not in {n.name for n in declared}:
        raise OrderRefused(UNKNOWN_NODE, f"{robot.name} has no node {request.node}.")


def _is_able(robot: Robot, action: Action) -> None:
    """Refuse what uses a function of the robot that is off, with what turns it on."""
    if reason := obstacle(robot, action):
        raise OrderRefused(FUNCTION_OFF, reason)


def _is_at_target(robot: Robot, request: CommandRequest) -> None:
    """Refuse to skip another point than the one that was looked at: the robot may have gone on to the next."""
    targets = robot.worksite.targets if robot.worksite is not None else ()
    if request.target is not None and request.target not in {one.id for one in targets if one.status == "current"}:
        raise OrderRefused(OTHER_TARGET, f"{robot.name} works at another point now. Look at it and skip again.")


def _about(request: CommandRequest) -> str:
    if request.place is not None:
        return ", ".join(f"{one:.2f}" for one in request.place)
    return request.node or request.target or ""


def _mission(robot: Robot, request: CommandRequest) -> Order | None:
    """Return the mission to name in the order: the one on the robot, which must be the one that was looked at."""
    loaded = robot.state.order if robot.state is not None else None
    if loaded is not None and loaded.status is OrderStatus.NONE:
        loaded = None
    if request.mission_id is not None and loaded is None:
        raise OrderRefused(WRONG_MISSION, f"{robot.name} has no mission. Send this one first.")
    if request.action in (Action.START, Action.RESUME):
        return None if loaded is None else _as_seen(loaded, request)
    if request.mission_id is not None and loaded is not None and loaded.mission_id != request.mission_id:
        raise OrderRefused(WRONG_MISSION, f"{robot.name} holds another mission than this screen. Send this one first.")
    return None


def _as_seen(loaded: Order, request: CommandRequest) -> Order:
    """Refuse to move by a mission that nobody looked at: sending needs no control, so it may change at any moment."""
    if request.mission_id is None or request.mission_sha256 is None:
        text = "A start or resume names mission_id and mission_sha256, as the robot reports them."
        raise OrderRefused(INCOMPLETE, text)
    if (loaded.mission_id, loaded.sha256) != (request.mission_id, request.mission_sha256):
        raise OrderRefused(WRONG_MISSION, "The mission changed while you slid. Look at it and slide again.")
    return loaded
