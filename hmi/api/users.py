"""People: made, changed, switched off."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from fastapi import APIRouter
from pydantic import Field

from hmi.api.access import UserManager
from hmi.api.body import Body, Name, Secret
from hmi.domain.role import Role
from hmi.security.accounts import Accounts
from hmi.store.users import User

RoleName = Literal["viewer", "operator", "planner", "supervisor", "dispatcher", "admin"]
Pin = Annotated[str, Field(max_length=16)]


class NewUser(Body):
    """A person; ``id`` is what is typed to sign in, made from the name if left out."""

    name: Name
    role: RoleName
    password: Secret
    id: Annotated[str, Field(max_length=64)] = ""
    pin: Pin = ""


class UserChange(Body):
    """What to change; an empty PIN takes it away."""

    name: Name | None = None
    role: RoleName | None = None
    is_active: bool | None = None
    password: Secret | None = None
    pin: Pin | None = None


def user_routes(accounts: Accounts) -> APIRouter:
    """Return the routes of people."""
    router = APIRouter(prefix="/users", tags=["people"])

    @router.get("", summary="Everybody of the farm")
    async def users(session: UserManager) -> dict[str, Any]:
        return {"users": [_user(u) for u in await accounts.all()]}

    @router.post("", status_code=201, summary="Add a person")
    async def add(body: NewUser, session: UserManager) -> dict[str, Any]:
        user = await accounts.create_user(
            body.name, Role(body.role), body.password, by=session.user_name, user_id=body.id, pin=body.pin
        )
        return _user(user)

    @router.patch("/{user_id}", summary="Change a person; their sessions end")
    async def change(user_id: str, body: UserChange, session: UserManager) -> dict[str, Any]:
        by = session.user_name
        if body.pin is not None:
            await accounts.set_pin(user_id, body.pin, by=by)
        if body.password is not None:
            await accounts.set_password(user_id, body.password, by=by)
        role = Role(body.role) if body.role is not None else None
        if (body.name, role, body.is_active) != (None, None, None):
            await accounts.change(user_id, by=by, name=body.name, role=role, is_active=body.is_active)
        return _user(next(u for u in await accounts.all() if u.id == user_id))

    return router


def _user(user: User) -> dict[str, Any]:
    return {
        "id": user.id,
        "name": user.name,
        "role": user.role.value,
        "is_active": user.is_active,
        "has_pin": user.has_pin,
        "created_utc": user.created_at.isoformat(timespec="milliseconds"),
    }
