"""Demo only: situations that can be played on simulated robots and stations. These routes do not exist elsewhere."""

from __future__ import annotations

from typing import Annotated, Any, Protocol

from fastapi import APIRouter, Path

from hmi.api.access import Watcher
from hmi.api.body import Body, Id
from hmi.api.errors import ApiError, not_found
from hmi.api.orders import RobotId
from hmi.domain.role import Permission
from hmi.security.authorization import Authorize

StationId = Annotated[str, Path(pattern=r"^[a-z0-9][a-z0-9_-]{0,63}\z")]


class StageAway(Exception):
    """The simulator does not answer."""


class Stage(Protocol):
    """Where situations are played: the simulator."""

    async def situations(self) -> dict[str, Any]:
        """Return ``{"situations": [...], "stations": [...], "now": {id: situation}}``; raises ``StageAway``."""
        ...

    async def play(self, robot_id: str, situation: str | None) -> str:
        """Play or end a situation on a robot or station; return why not, empty if done. Raises ``StageAway``."""
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
        await _play(stage, robot_id, body.situation)
        return {"robot": robot_id, "situation": body.situation}

    @router.post("/demo/stations/{station_id}/situation", summary="Let a situation happen to a field sensor")
    async def play_station(station_id: StationId, body: SituationBody, session: Watcher) -> dict[str, Any]:
        authorize(session, Permission.PAUSE)
        await _play(stage, station_id, body.situation)
        return {"station": station_id, "situation": body.situation}

    return router


async def _play(stage: Stage, played_on: str, situation: str | None) -> None:
    try:
        problem = await stage.play(played_on, situation)
    except KeyError as error:
        raise not_found("The simulator has no such robot, station or situation.") from error
    except StageAway as error:
        raise _away() from error
    if problem:
        raise ApiError(409, "not_possible", problem, "situation")


def _away() -> ApiError:
    return ApiError(503, "simulator_away", "The simulator does not answer. It starts again by itself in a moment.")
