"""Demo only: situations that can be played on a simulated robot. These routes do not exist outside the demo."""

from __future__ import annotations

from typing import Any, Protocol

from fastapi import APIRouter

from hmi.api.access import Watcher
from hmi.api.body import Body, Id
from hmi.api.errors import ApiError, not_found
from hmi.api.orders import RobotId
from hmi.domain.role import Permission
from hmi.security.authorization import Authorize


class StageAway(Exception):
    """The simulator does not answer."""


class Stage(Protocol):
    """Where situations are played: the simulator."""

    async def situations(self) -> dict[str, Any]:
        """Return ``{"situations": [...], "now": {robot: situation}}``; raises ``StageAway``."""
        ...

    async def play(self, robot_id: str, situation: str | None) -> str:
        """Play or end a situation; return why not, empty if done. Raises ``StageAway``."""
        ...


class SituationBody(Body):
    """Which situation to play; null ends the one that is on."""

    situation: Id | None


def demo_routes(stage: Stage, authorize: Authorize) -> APIRouter:
    """Return the routes of the demo panel."""
    router = APIRouter(tags=["demo"])

    @router.get("/demo/situations", summary="What can happen to a simulated robot, and what does")
    async def situations(_session: Watcher) -> dict[str, Any]:
        try:
            return await stage.situations()
        except StageAway as error:
            raise _away() from error

    @router.post("/demo/robots/{robot_id}/situation", summary="Let a situation happen, or end it")
    async def play(robot_id: RobotId, body: SituationBody, session: Watcher) -> dict[str, Any]:
        authorize(session, Permission.PAUSE, robot_id)
        try:
            problem = await stage.play(robot_id, body.situation)
        except KeyError as error:
            raise not_found("The simulator has no such robot or situation.") from error
        except StageAway as error:
            raise _away() from error
        if problem:
            raise ApiError(409, "not_possible", problem, "situation")
        return {"robot": robot_id, "situation": body.situation}

    return router


def _away() -> ApiError:
    return ApiError(503, "simulator_away", "The simulator does not answer. It starts again by itself in a moment.")
