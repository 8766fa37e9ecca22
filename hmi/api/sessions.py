"""Signing in and out, enrolling a tablet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from fastapi import APIRouter, Request, Response
from pydantic import Field

from hmi.api.access import Enroller, SignedIn, UserManager, bearer
from hmi.api.body import Body, Name, Secret
from hmi.api.errors import ApiError
from hmi.domain.role import PERMISSIONS
from hmi.security.cookie import clear_cookie_header, cookies_in, set_cookie_header
from hmi.security.enrolment import Enrolment
from hmi.security.session_info import SessionInfo
from hmi.security.sessions import Sessions
from hmi.security.sign_in import SignedIn as SignInResult
from hmi.security.sign_in import SignIn
from hmi.security.stop_tokens import StopTokens
from hmi.store.database import Database
from hmi.store.devices import Devices


class SignInBody(Body):
    """Name and password, or on an enrolled tablet a PIN; ``stop_token`` is what the tablet keeps and names it."""

    name: Annotated[str, Field(min_length=1, max_length=200)]
    password: Secret = ""
    pin: Annotated[str, Field(max_length=16)] = ""
    stop_token: Annotated[str, Field(max_length=2048)] = ""


class DeviceBody(Body):
    """What the tablet is called."""

    name: Name


@dataclass(frozen=True, slots=True)
class SessionRoutes:
    """What the routes of sessions and tablets need."""

    sign_in: SignIn
    sessions: Sessions
    tokens: StopTokens
    enrolment: Enrolment
    devices: Devices
    database: Database


def session_routes(parts: SessionRoutes) -> APIRouter:
    """Return the routes of sessions and tablets."""
    router = APIRouter(tags=["sessions"])

    @router.post("/session", summary="Sign in")
    async def sign_in(body: SignInBody, request: Request, response: Response) -> dict[str, Any]:
        if bool(body.password) == bool(body.pin):
            raise ApiError(422, "invalid", "Give a password or a PIN.", "password")
        address = request.client.host if request.client is not None else ""
        old = next(iter(cookies_in(request.scope["headers"])), None)
        if body.password:
            result = await parts.sign_in.with_password(
                body.name, body.password, address=address, stop_token=body.stop_token, old_cookie=old
            )
        else:
            result = await parts.sign_in.with_pin(
                body.name, body.pin, address=address, stop_token=body.stop_token, old_cookie=old
            )
        response.headers["set-cookie"] = _cookie(request, result, parts.sessions.lifetime_s)
        return _whoami(result.session, result.stop_token)

    @router.get("/session", summary="Who am I")
    async def who(session: SignedIn) -> dict[str, Any]:
        return _whoami(session, parts.tokens.issue_stop_token(session))

    @router.delete("/session", summary="Sign out; the pages of this session close")
    async def sign_out(session: SignedIn, response: Response) -> dict[str, Any]:
        token = await parts.sign_in.sign_out(session)
        response.headers["set-cookie"] = clear_cookie_header()
        return {"stop_token": token}

    @router.get("/people", summary="People with a PIN, for the tiles of an enrolled tablet; nobody elsewhere")
    async def people(request: Request) -> dict[str, Any]:
        token = request.headers.get("x-headland-stop-token") or bearer(request)
        known = await parts.sign_in.people(token)
        return {
            "people": [{"id": p.id, "name": p.name, "role": p.role.value} for p in known],
            "device": {"name": parts.tokens.read_stop_token(token).device_name if known else ""},
        }

    @router.post("/devices", status_code=201, summary="Enrol this tablet")
    async def enrol(body: DeviceBody, session: Enroller) -> dict[str, Any]:
        enrolled = await parts.enrolment.enrol(session, body.name)
        return {"device_id": enrolled.device.id, "name": enrolled.device.name, "stop_token": enrolled.stop_token}

    @router.get("/devices", summary="Enrolled tablets")
    async def devices(session: Enroller) -> dict[str, Any]:
        known = await parts.database.run(parts.devices.all, session.farm_id)
        return {
            "devices": [
                {
                    "id": d.id,
                    "name": d.name,
                    "enrolled_by": d.enrolled_by,
                    "enrolled_utc": d.enrolled_at.isoformat(timespec="milliseconds"),
                    "revoked_utc": d.revoked_at.isoformat(timespec="milliseconds") if d.revoked_at else None,
                }
                for d in known
            ]
        }

    @router.delete("/devices/{device_id}", status_code=204, summary="Take a lost tablet out")
    async def revoke(device_id: str, session: UserManager) -> None:
        await parts.enrolment.revoke(session, device_id)

    return router


def _cookie(request: Request, result: SignInResult, lifetime_s: float) -> str:
    return set_cookie_header(result.cookie, lifetime_s, is_secure=request.url.scheme == "https")


def _whoami(session: SessionInfo, stop_token: str) -> dict[str, Any]:
    return {
        "user": {"id": session.user_id, "name": session.user_name, "role": session.role.value},
        "device": {"id": session.device_id, "name": session.device_name},
        "session": session.session_id,
        "farm": session.farm_id,
        "rights": sorted(p.value for p in PERMISSIONS[session.role]),
        "csrf": session.csrf,
        "stop_token": stop_token,
        "expires_utc": session.expires_utc.isoformat(timespec="milliseconds"),
    }
