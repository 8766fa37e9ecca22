"""The fleet as a whole: orders to several robots, groups, saved views, and today's figures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Path, Request
from pydantic import Field, JsonValue

from hmi.api.access import SignedIn, Watcher, access_of
from hmi.api.body import Body, Id, Name, Ref, Tick
from hmi.api.errors import ApiError
from hmi.commands.fleet_actions import MOST_ROBOTS, FleetActions, RobotResult
from hmi.commands.fleet_groups import FleetGroupBook
from hmi.commands.lease_words import owner_of
from hmi.commands.refusal import ACTION_PERMISSION
from hmi.domain.command import Action, Outcome
from hmi.domain.fleet_day import DayFigures
from hmi.domain.role import Permission
from hmi.store.fleet_groups import FleetGroup, FleetView

EntryId = Annotated[str, Path(max_length=64)]
RobotIds = Annotated[list[Id], Field(min_length=1, max_length=MOST_ROBOTS)]
MAX_FILTER = 40


class ActionBody(Body):
    """An order to several robots; ``action_id`` makes a repeated request act once."""

    action: Literal["pause", "return_home", "abort"]
    robots: RobotIds
    tick: Tick
    action_id: Ref | None = None


class RobotMission(Body):
    """Which mission goes to which robot."""

    robot: Id
    mission_id: Id


class FleetMissionBody(Body):
    """One mission for robots, or one each."""

    mission_id: Id | None = None
    robots: Annotated[list[Id], Field(default_factory=list, max_length=MOST_ROBOTS)]
    pairs: Annotated[list[RobotMission], Field(default_factory=list, max_length=MOST_ROBOTS)]


class GroupBody(Body):
    """A group of robots."""

    name: Name
    robots: RobotIds


class ViewBody(Body):
    """A way to look at the fleet; ``filter`` is the screen's own."""

    name: Name
    filter: Annotated[dict[str, JsonValue], Field(max_length=MAX_FILTER)]


@dataclass(frozen=True, slots=True)
class FleetRoutes:
    """What the routes need."""

    actions: FleetActions
    groups: FleetGroupBook
    day: Callable[[], DayFigures]


def fleet_routes(parts: FleetRoutes) -> APIRouter:
    """Return the routes of the fleet."""
    router = APIRouter(prefix="/fleet", tags=["fleet"])

    @router.post("/actions", summary="Order several robots; each answers for itself")
    async def act(body: ActionBody, request: Request, session: SignedIn) -> dict[str, Any]:
        access_of(request).authorize(session, ACTION_PERMISSION[Action(body.action)])
        results = await parts.actions.act(session, Action(body.action), body.robots, body.tick, body.action_id or "")
        return _results(results)

    @router.post("/mission", summary="Send stored missions to several robots; moves nothing")
    async def mission(body: FleetMissionBody, request: Request, session: SignedIn) -> dict[str, Any]:
        access_of(request).authorize(session, Permission.SEND_MISSION)
        pairs = [(one.robot, one.mission_id) for one in body.pairs]
        if body.mission_id is not None:
            pairs += [(robot, body.mission_id) for robot in body.robots]
        if not pairs:
            raise ApiError(422, "invalid", "Name a mission and robots.", "pairs")
        return _results(await parts.actions.send(session, pairs))

    @router.get("/kpis", summary="What the fleet did today")
    async def kpis(_session: Watcher) -> dict[str, Any]:
        day = parts.day()
        return {
            "area_m2": round(day.area_m2, 1),
            "plants": day.plants,
            "working_s": round(day.working_s),
            "heard_s": round(day.heard_s),
            "utilisation": None if day.utilisation is None else round(day.utilisation, 3),
            "interventions": day.interventions,
            "interventions_per_hour": _rounded(day.interventions_per_hour),
        }

    _add_groups(router, parts.groups)
    return router


def _add_groups(router: APIRouter, book: FleetGroupBook) -> None:
    @router.get("/groups", summary="Groups of robots by name")
    async def groups(session: Watcher) -> dict[str, Any]:
        return {"groups": [_group(one) for one in await book.groups(session)]}

    @router.post("/groups", status_code=201, summary="Keep robots under a name")
    async def add(body: GroupBody, session: SignedIn) -> dict[str, Any]:
        return _group(await book.add(session, body.name, body.robots))

    @router.put("/groups/{group_id}", summary="Replace name and robots of a group")
    async def change(group_id: EntryId, body: GroupBody, session: SignedIn) -> dict[str, Any]:
        return _group(await book.change(session, group_id, body.name, body.robots))

    @router.delete("/groups/{group_id}", status_code=204, summary="Delete a group; its robots stay")
    async def remove(group_id: EntryId, session: SignedIn) -> None:
        await book.remove(session, group_id)

    @router.get("/views", summary="My saved views by name")
    async def views(session: Watcher) -> dict[str, Any]:
        return {"views": [_view(one) for one in await book.views(session)]}

    @router.post("/views", status_code=201, summary="Keep a view; one of the same name is replaced")
    async def save(body: ViewBody, session: SignedIn) -> dict[str, Any]:
        return _view(await book.save_view(session, body.name, body.filter))

    @router.delete("/views/{view_id}", status_code=204, summary="Delete one of my views")
    async def forget(view_id: EntryId, session: SignedIn) -> None:
        await book.remove_view(session, view_id)


def _results(results: list[RobotResult]) -> dict[str, Any]:
    accepted = sum(one.outcome is Outcome.ACCEPTED for one in results)
    return {"results": [_result(one) for one in results], "accepted": accepted, "total": len(results)}


def _result(one: RobotResult) -> dict[str, Any]:
    told = {"robot": one.robot_id, "outcome": one.outcome.value, "code": one.code, "text": one.text}
    return told if one.lease is None else {**told, "owner": owner_of(one.lease)}


def _group(one: FleetGroup) -> dict[str, Any]:
    return {"id": one.id, "name": one.name, "robots": list(one.robots), "changed_by": one.changed_by}


def _view(one: FleetView) -> dict[str, Any]:
    return {"id": one.id, "name": one.name, "filter": one.filter}


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 2)
