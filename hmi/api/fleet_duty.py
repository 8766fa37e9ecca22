"""Who is responsible for which robot, hand-overs, the shift book; and wall screens."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from typing import Annotated, Any

from fastapi import APIRouter, Path, Request, Response
from pydantic import Field

from hmi.api.access import SignedIn, Watcher, access_of
from hmi.api.body import Body, Id, Name, Secret
from hmi.api.orders import RobotId
from hmi.commands.fleet_duty import DutyDesk
from hmi.domain.role import Permission
from hmi.security.cookie import set_cookie_header
from hmi.security.stop_tokens import StopTokens
from hmi.security.walls import COOKIE_S, WallScreens
from hmi.store.duty import Duty, HandOver
from hmi.store.walls import Wall

Note = Annotated[str, Field(max_length=500)]
RobotIds = Annotated[list[Id], Field(min_length=1, max_length=1000)]
UserId = Annotated[str, Field(min_length=1, max_length=64)]
WallId = Annotated[str, Path(pattern=r"^[0-9a-f]{64}\z")]


class DutyBody(Body):
    """Take a robot (my own id), hand it to somebody, or give it back (null)."""

    user: UserId | None
    note: Note = ""


class HandOverBody(Body):
    """To whom these robots are offered."""

    robots: RobotIds
    to_user: UserId
    note: Note = ""


class RobotsBody(Body):
    """Which robots."""

    robots: RobotIds
    note: Note = ""


class WallBody(Body):
    """What a wall screen is called."""

    name: Name


class KeyBody(Body):
    """The key of a wall screen."""

    key: Annotated[Secret, Field(max_length=100)]


@dataclass(frozen=True, slots=True)
class DutyRoutes:
    """What the routes need."""

    desk: DutyDesk
    walls: WallScreens
    tokens: StopTokens


def duty_routes(parts: DutyRoutes) -> APIRouter:
    """Return the routes of duty and wall screens."""
    router = APIRouter(prefix="/fleet", tags=["fleet"])
    desk = parts.desk

    @router.get("/duty", summary="Who is responsible, to whom robots are offered, and the shift book")
    async def duty(session: Watcher) -> dict[str, Any]:
        people = await desk.people(session)
        return {
            "duty": {one.robot_id: _duty(one) for one in desk.all(session)},
            "freed": {one.robot_id: {"since": _ms(one.since)} for one in desk.freed(session)},
            "people": [{"id": one.id, "name": one.name, "role": one.role.value} for one in people],
            "book": [_line(one) for one in await desk.book(session)],
        }

    @router.put("/duty/{robot_id}", summary="Take, hand over or give back one robot")
    async def put(robot_id: RobotId, body: DutyBody, session: SignedIn) -> dict[str, Any]:
        if body.user is None:
            changed = await desk.release(session, [robot_id], body.note)
        else:
            changed = await desk.hand_over(session, [robot_id], body.user, body.note)
        return _changed(changed)

    @router.post("/duty/handover", summary="Offer robots to somebody; to myself is taking them")
    async def hand_over(body: HandOverBody, session: SignedIn) -> dict[str, Any]:
        return _changed(await desk.hand_over(session, body.robots, body.to_user, body.note))

    @router.post("/duty/release", summary="Be responsible no longer")
    async def release(body: RobotsBody, session: SignedIn) -> dict[str, Any]:
        return _changed(await desk.release(session, body.robots, body.note))

    @router.post("/duty/accept", summary="Take over what is offered to me")
    async def accept(body: RobotsBody, session: SignedIn) -> dict[str, Any]:
        return _changed(await desk.accept(session, body.robots))

    @router.post("/duty/decline", summary="Leave it with who offered it, or withdraw my offer")
    async def decline(body: RobotsBody, session: SignedIn) -> dict[str, Any]:
        return _changed(await desk.decline(session, body.robots, body.note))

    _add_walls(router, parts)
    return router


def _add_walls(router: APIRouter, parts: DutyRoutes) -> None:
    @router.get("/walls", summary="Wall screens")
    async def walls(request: Request, session: SignedIn) -> dict[str, Any]:
        access_of(request).authorize(session, Permission.MANAGE_WALLS)
        return {"walls": [_wall(one) for one in await parts.walls.all()]}

    @router.post("/walls", status_code=201, summary="Make a wall screen; its key is shown once")
    async def make(body: WallBody, request: Request, session: SignedIn) -> dict[str, Any]:
        access_of(request).authorize(session, Permission.MANAGE_WALLS)
        made = await parts.walls.make(session, body.name)
        return {**_wall(made.wall), "key": made.key}

    @router.delete("/walls/{wall_id}", status_code=204, summary="Take a wall screen out; it goes dark at once")
    async def revoke(wall_id: WallId, request: Request, session: SignedIn) -> None:
        access_of(request).authorize(session, Permission.MANAGE_WALLS)
        await parts.walls.revoke(session, wall_id)

    @router.post("/walls/open", summary="Make this browser a wall screen, by its key")
    async def open_wall(body: KeyBody, request: Request, response: Response) -> dict[str, Any]:
        session = parts.walls.open(body.key)
        is_secure = request.url.scheme == "https"
        response.headers["set-cookie"] = set_cookie_header(body.key, COOKIE_S, is_secure=is_secure)
        return {"name": session.device_name, "stop_token": parts.tokens.issue_stop_token(session)}


def _changed(duties: list[Duty]) -> dict[str, Any]:
    return {"duty": {one.robot_id: _duty(one) for one in duties}}


def _duty(one: Duty) -> dict[str, Any]:
    offer = {
        "to": one.offered_to, "to_name": one.offered_name, "by": one.offered_by, "by_id": one.offered_by_id,
        "at": _ms(one.offered_at), "note": one.offered_note,
    }  # fmt: skip
    return {
        "user": one.user_id,
        "name": one.user_name,
        "since": _ms(one.since),
        "note": one.note,
        "offer": offer if one.offered_to else None,
    }


def _line(one: HandOver) -> dict[str, Any]:
    return {
        "at": _ms(one.at),
        "what": one.what,
        "by": one.by,
        "to": one.to_name,
        "robots": list(one.robots),
        "note": one.note,
    }


def _wall(one: Wall) -> dict[str, Any]:
    return {
        "id": one.id,
        "name": one.name,
        "made_by": one.made_by,
        "made_at": _ms(one.made_at),
        "revoked_at": _ms(one.revoked_at),
    }


def _ms(at: datetime | None) -> int | None:
    return None if at is None else round(at.timestamp() * 1000)
