"""Limits and delays of alarm types. For admins; of priority 1 a second one agrees."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Path
from pydantic import Field

from hmi.api.access import SignedIn
from hmi.api.body import Body, Reason
from hmi.api.errors import ApiError, not_found
from hmi.commands.alarm_limits_desk import AlarmLimitsDesk
from hmi.commands.refusal import OrderRefused
from hmi.domain.alarm.tuning import BadTuning, Tuning
from hmi.domain.ids import ID_PATTERN
from hmi.store.errors import NotFound

Code = Annotated[str, Path(pattern=ID_PATTERN, max_length=64)]
Number = Annotated[float, Field(ge=0, le=1e6)]


class ValuesBody(Body):
    """Seconds, and the limit in the unit of the type; null where it has none."""

    on_s: Number
    off_s: Number
    at: Number | None = None
    deadband: Number | None = None


class LimitBody(Body):
    """``values`` null: as shipped."""

    values: ValuesBody | None
    reason: Reason


def alarm_limits_routes(desk: AlarmLimitsDesk) -> APIRouter:
    """Return the routes of limits; they come before ``/alarms/{id}``."""
    router = APIRouter(tags=["alarms"])

    @router.get("/alarms/limits", summary="Every alarm type: shipped, set, and waiting for a second person")
    async def view(session: SignedIn) -> dict[str, Any]:
        return desk.view(session)

    @router.put("/alarms/limits/{code}", summary="Set delays and limit of a type")
    async def change(code: Code, body: LimitBody, session: SignedIn) -> dict[str, Any]:
        values = None if body.values is None else Tuning(**body.values.model_dump())
        try:
            return await desk.change(session, code, values, body.reason)
        except BadTuning as error:
            raise ApiError(422, "invalid", error.text, error.field) from error
        except OrderRefused as error:
            raise ApiError(422, error.code, error.text, "reason") from error
        except NotFound as error:
            raise not_found("There is no such alarm.") from error

    @router.post("/alarms/limits/{code}/agree", summary="Agree, as the second person")
    async def agree(code: Code, session: SignedIn) -> dict[str, Any]:
        return await _answer(desk.agree(session, code))

    @router.post("/alarms/limits/{code}/drop", summary="Take back or decline what was asked for")
    async def drop(code: Code, session: SignedIn) -> dict[str, Any]:
        return await _answer(desk.drop(session, code))

    return router


async def _answer(asked: Any) -> dict[str, Any]:
    try:
        answer: dict[str, Any] = await asked
    except OrderRefused as error:
        raise ApiError(409, error.code, error.text) from error
    except NotFound as error:
        raise not_found("There is no such alarm.") from error
    return answer
