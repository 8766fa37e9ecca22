"""Software nodes of a robot, what it can do because of them, and their life: start, stop, restart."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, Literal, Protocol

from fastapi import APIRouter, Path, Query
from starlette.requests import Request

from hmi.api.access import SignedIn, Watcher, access_of
from hmi.api.body import Body, Ref, Tick
from hmi.api.errors import ApiError, not_found
from hmi.api.orders import RobotId, outcome_of
from hmi.clock import Clock
from hmi.commands.ledger import CommandResult
from hmi.commands.service import CommandRequest
from hmi.domain.command import Action
from hmi.domain.ids import ID_PATTERN
from hmi.domain.robot import Robot
from hmi.domain.robot_log import MAX_LINES, LogFailed, LogSource, search
from hmi.domain.role import Permission
from hmi.presenters import functions, nodes
from hmi.security.session_info import SessionInfo

NodeName = Annotated[str, Path(pattern=ID_PATTERN.removesuffix("$") + r"\z")]
NodeAct = Literal["start", "stop", "restart"]
LOG_STATUS = {"no_address": 409, "no_answer": 504, "http_404": 404}


class NodeOrderBody(Body):
    """Names the order, and the picture it was decided on."""

    command_id: Ref
    tick: Tick


class Commands(Protocol):
    """``CommandService``, as far as nodes need it."""

    async def submit(self, actor: SessionInfo, request: CommandRequest) -> CommandResult:
        """Send one command."""
        ...


@dataclass(frozen=True, slots=True)
class NodeRoutes:
    """What these routes need.

    Args:
        robot_of: the newest known state of a robot.
    """

    robot_of: Callable[[str], Robot | None]
    commands: Commands
    logs: LogSource
    clock: Clock


def node_routes(parts: NodeRoutes) -> APIRouter:
    """Return the routes of nodes, functions and logs."""
    router = APIRouter(prefix="/robots/{robot_id}", tags=["nodes"])
    _add_reading(router, parts)

    @router.post("/nodes/{name}/{act}", summary="Start, stop or restart a node")
    async def order(
        robot_id: RobotId, name: NodeName, act: NodeAct, body: NodeOrderBody, session: SignedIn
    ) -> dict[str, Any]:
        action = Action(f"node_{act}")
        asked = CommandRequest(robot_id, action, body.command_id, body.tick, node=name)
        return {"command_id": body.command_id, **outcome_of(await parts.commands.submit(session, asked))}

    @router.get("/logs", summary="The last lines of the robot's own log")
    async def logs(
        request: Request,
        robot_id: RobotId,
        session: SignedIn,
        lines: Annotated[int, Query(ge=1, le=MAX_LINES)] = 200,
        q: Annotated[str, Query(max_length=100)] = "",
        node: Annotated[str, Query(max_length=64)] = "",
    ) -> dict[str, Any]:
        access_of(request).authorize(session, Permission.READ_LOGS, robot_id)
        robot = _robot(parts, session, robot_id)
        try:
            # a search looks at everything the robot keeps, not only at what would be shown
            kept = await parts.logs.tail_log(robot_id, MAX_LINES if q or node else lines)
        except LogFailed as failed:
            text = failed.text.replace("The robot", robot.name, 1)
            raise ApiError(LOG_STATUS.get(failed.code, 502), failed.code, text) from failed
        found = search(kept, words=q, node=node)
        return {"lines": found[-lines:], "found": len(found), "read": len(kept)}

    return router


def _add_reading(router: APIRouter, parts: NodeRoutes) -> None:
    @router.get("/nodes", summary="Software nodes with their life cycle and what is wrong with them")
    async def all_nodes(robot_id: RobotId, session: Watcher) -> dict[str, Any]:
        robot, now_s = _robot(parts, session, robot_id), parts.clock.mono_s()
        return {"now_ms": round(now_s * 1000, 1), **(nodes.present(robot, now_s) or {"nodes": []})}

    @router.get("/functions", summary="What the robot can do now, and why not")
    async def all_functions(robot_id: RobotId, session: Watcher) -> dict[str, Any]:
        robot, now_s = _robot(parts, session, robot_id), parts.clock.mono_s()
        found = functions.present(robot, now_s) or {"functions": [], "on": 0, "total": 0, "hint": ""}
        return {"now_ms": round(now_s * 1000, 1), **found}


def _robot(parts: NodeRoutes, session: SessionInfo, robot_id: str) -> Robot:
    robot = parts.robot_of(robot_id)
    if robot is None or robot.farm_id != session.farm_id:
        raise not_found(f"There is no robot {robot_id}.")
    return robot
