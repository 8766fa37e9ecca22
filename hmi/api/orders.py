"""Commands, control, stop resets and missions to a robot: what a screen does, for programs."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from fastapi import APIRouter, Path
from pydantic import Field

from hmi.api.access import SignedIn
from hmi.api.body import Body, Id, Reason, Ref, Tick
from hmi.api.errors import REFUSAL_STATUS, ApiError
from hmi.commands.desk import CommandDesk
from hmi.commands.lease_service import LeaseOp
from hmi.commands.lease_words import asked_of, owner_of
from hmi.commands.ledger import CommandResult
from hmi.commands.mission_send import Way
from hmi.commands.reset import ResetRequest
from hmi.commands.service import CommandRequest
from hmi.domain.command import Action

Metres = Annotated[float, Field(ge=-100_000, le=100_000)]
RobotId = Annotated[str, Path(max_length=64)]


class CommandBody(Body):
    """An instant action."""

    command_id: Ref
    action: Literal[
        "start", "resume", "pause", "abort", "return_home", "drive_open", "drive_close",
        "go_to", "tool_retract", "tool_go_to", "skip_target", "stock_refilled",
        "node_start", "node_stop", "node_restart",
    ]  # fmt: skip
    tick: Tick
    mission_id: Annotated[Id | None, Field(description="start and resume: the mission the robot reports")] = None
    mission_sha256: Annotated[
        str | None, Field(pattern=r"^[0-9a-f]{64}\z", description="start and resume: its hash as the robot reports it")
    ] = None
    checklist_id: Annotated[str | None, Field(max_length=64, description="record of the pre-start checklist")] = None
    node: Annotated[Id | None, Field(description="for node_start, node_stop and node_restart")] = None
    place: Annotated[
        tuple[Metres, Metres, Metres] | None,
        Field(description="for go_to and tool_go_to: east, north, height above the ground there; metres", strict=False),
    ] = None
    target: Annotated[Id | None, Field(description="for skip_target: the point that was shown as worked at")] = None


class LeaseBody(Body):
    """An operation on control; ``session`` names the asker for grant and keep."""

    op: Literal["request", "release", "grant", "keep", "take"]
    tick: Tick = ""
    reason: Reason = ""
    session: Annotated[str, Field(max_length=64)] | None = None


class ResetBody(Body):
    """Which presses to reset, and why."""

    reset_id: Ref
    stop_ids: Annotated[list[Ref], Field(min_length=1, max_length=64)]
    reason: Reason
    tick: Tick


class SeenBody(Body):
    """Which press the person looked at."""

    stop_id: Ref


class MissionBody(Body):
    """Which stored mission to send; ``fresh``: what was done of it is forgotten."""

    mission_id: Id
    fresh: bool = False
    way: Annotated[Literal["direct", "cloud"], Field(description="how it goes to the robot")] = "direct"


def order_routes(desk: CommandDesk) -> APIRouter:
    """Return the routes that send orders."""
    router = APIRouter(prefix="/robots/{robot_id}", tags=["orders"])

    @router.post("/commands", summary="Command a robot")
    async def command(robot_id: RobotId, body: CommandBody, session: SignedIn) -> dict[str, Any]:
        action, tick = Action(body.action), body.tick
        request = CommandRequest(
            robot_id,
            action,
            body.command_id,
            tick,
            mission_id=body.mission_id,
            mission_sha256=body.mission_sha256,
            checklist_id=body.checklist_id,
            node=body.node,
            place=body.place,
            target=body.target,
        )
        result = await desk.commands.submit(session, request)
        return {"command_id": body.command_id, **outcome_of(result)}

    @router.post("/lease", summary="Ask for, give, keep, take or give back control")
    async def lease(robot_id: RobotId, body: LeaseBody, session: SignedIn) -> dict[str, Any]:
        result = desk.leases.operate(
            session, robot_id, LeaseOp(body.op), tick_id=body.tick, reason=body.reason, to_session=body.session
        )
        raise_if_forbidden(result.code, result.text)
        return {
            "granted": result.is_granted,
            "code": result.code,
            "text": result.text,
            "owner": owner_of(result.lease),
            "asked": asked_of(result.lease),
        }

    @router.post("/stop-reset", summary="Reset a STOP; moves nothing")
    async def stop_reset(robot_id: RobotId, body: ResetBody, session: SignedIn) -> dict[str, Any]:
        request = ResetRequest(robot_id, body.reset_id, tuple(body.stop_ids), body.reason, body.tick)
        result = await desk.resets.reset(session, request)
        return {"reset_id": body.reset_id, **outcome_of(result)}

    @router.post("/seen", status_code=204, summary="I see it standing still")
    async def seen(robot_id: RobotId, body: SeenBody, session: SignedIn) -> None:
        desk.seen.note(session, robot_id, body.stop_id)

    @router.post("/mission", summary="Send a stored mission; moves nothing")
    async def mission(robot_id: RobotId, body: MissionBody, session: SignedIn) -> dict[str, Any]:
        sent = await desk.missions.send(session, robot_id, body.mission_id, is_fresh=body.fresh, way=Way(body.way))
        raise_if_forbidden(sent.code, sent.text)
        told = {"outcome": sent.outcome.value, "code": sent.code, "text": sent.text, "sha256": sent.sha256}
        return {**told, "way": sent.way.value, "took_s": sent.took_s}

    return router


def outcome_of(result: CommandResult) -> dict[str, Any]:
    """Return what became of an order; raises what is an error of the request."""
    if result.ms is None:  # a robot's own words come with a time, and are never an error of the request
        raise_if_forbidden(result.code, result.text)
    return {"outcome": result.outcome.value, "code": result.code, "text": result.text, "ms": result.ms}


def raise_if_forbidden(code: str, text: str) -> None:
    """Raise what is an error of the request: missing rights, unknown robots."""
    status = REFUSAL_STATUS.get(code)
    if status is not None:
        raise ApiError(status, code, text)
