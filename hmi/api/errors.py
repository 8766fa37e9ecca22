"""One shape for every error, ``{"code","text","field"}``, mapped in one place; no stack trace ever leaves.

::

    ApiError      a route's own refusal, with status, code and sentence
"""

from __future__ import annotations

import logging
from collections.abc import Awaitable, Callable
from http import HTTPStatus
from typing import Any

from fastapi import FastAPI
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import JSONResponse

from hmi.commands.refusal import OrderRefused
from hmi.domain.alarm.life import AlarmRefused
from hmi.security.errors import BadAccount, SecurityError, TooManyTries
from hmi.store.errors import (
    AlreadyExists,
    DatabaseFull,
    DatabaseUnavailable,
    NotFound,
    PicturesBusy,
    PicturesFull,
    StopListNotWritten,
    StoreError,
    TooMuchMarked,
)

log = logging.getLogger(__name__)

REFUSAL_STATUS = {
    "not_signed_in": 401,
    "not_allowed": 403,
    "not_registered": 403,
    "other_farm": 403,
    "unknown_robot": 404,
    "unknown_station": 404,
    "unknown_node": 404,
    "incomplete": 422,
    "has_progress": 409,
}
"""Refusals of the console that are an error of the request, not an outcome of an order."""

_HTTP_CODES = {
    400: "invalid",
    401: "not_signed_in",
    403: "not_allowed",
    404: "not_found",
    405: "method_not_allowed",
    413: "too_large",
}
_STORE: tuple[tuple[type[StoreError], int, str, str], ...] = (
    (NotFound, 404, "not_found", "There is no such entry. It may have been removed meanwhile."),
    (AlreadyExists, 409, "already_exists", "This id is taken already."),
    (
        DatabaseFull,
        503,
        "database_unavailable",
        "The disk of the server is full: nothing new can be recorded. Make room there, then try again.",
    ),
    (DatabaseUnavailable, 503, "database_unavailable", "The records cannot be used right now. Try again in a moment."),
    (
        StopListNotWritten,
        500,
        "stop_list_not_written",
        "Saved, but the STOP gateway was not told. Check the disk of the data folder.",
    ),
    (PicturesFull, 507, "disk_full", "Not kept: the disk of the server has too little room left. Tell an admin."),
    (TooMuchMarked, 409, "too_much_marked", "Marked pictures fill their room. Take the mark off others first."),
    (PicturesBusy, 503, "busy", "Not kept: more pictures come than the disk takes. Try again in a moment."),
)


class ApiError(Exception):
    """A refusal of a route.

    Args:
        text: one sentence for a person.
        field: the input at fault, if it is one.
    """

    def __init__(self, status: int, code: str, text: str, field: str | None = None) -> None:
        super().__init__(f"{status} {code}: {text}")
        self.status, self.code, self.text, self.field = status, code, text, field


def not_found(text: str) -> ApiError:
    """Return the error for something that is not there."""
    return ApiError(404, "not_found", text)


def install(app: FastAPI) -> None:
    """Map every error that can reach ``app``."""
    handlers: dict[type[Exception], Callable[[Request, Any], Awaitable[JSONResponse]]] = {
        ApiError: _api_error,
        SecurityError: _security_error,
        OrderRefused: _order_refused,
        AlarmRefused: _alarm_refused,
        StoreError: _store_error,
        RequestValidationError: _invalid,
        HTTPException: _http_error,
        Exception: _failed,
    }
    for kind, handler in handlers.items():
        app.add_exception_handler(kind, handler)


def answer(
    status: int, code: str, text: str, field: str | None = None, headers: dict[str, str] | None = None
) -> JSONResponse:
    """Return an error in the one shape."""
    return JSONResponse({"code": code, "text": text, "field": field}, status, headers)


async def _api_error(_request: Request, error: ApiError) -> JSONResponse:
    return answer(error.status, error.code, error.text, error.field)


async def _security_error(_request: Request, error: SecurityError) -> JSONResponse:
    field = error.field if isinstance(error, BadAccount) else None
    headers = {"Retry-After": str(max(1, round(error.retry_after_s)))} if isinstance(error, TooManyTries) else None
    status = 404 if error.code == "unknown" else error.http_status
    return answer(status, error.code, error.text, field, headers)


async def _order_refused(_request: Request, error: OrderRefused) -> JSONResponse:
    return answer(REFUSAL_STATUS.get(error.code, 409), error.code, error.text)


async def _alarm_refused(_request: Request, error: AlarmRefused) -> JSONResponse:
    return answer(409, error.code, error.text)


async def _store_error(_request: Request, error: StoreError) -> JSONResponse:
    for kind, status, code, text in _STORE:
        if isinstance(error, kind):
            return answer(status, code, text)
    log.error("the store failed: %s", error)
    return answer(500, "failed", "Something went wrong here. It was written to the log.")


async def _invalid(_request: Request, error: RequestValidationError) -> JSONResponse:
    first = error.errors()[0]
    place = [str(part) for part in first["loc"] if part not in ("body", "query", "path")]
    field = ".".join(place) or None
    message = str(first["msg"]).removeprefix("Value error, ")
    return answer(422, "invalid", f"{field}: {message}." if field else f"{message}.", field)


async def _http_error(_request: Request, error: HTTPException) -> JSONResponse:
    code = _HTTP_CODES.get(error.status_code, HTTPStatus(error.status_code).name.lower())
    texts = {
        400: "The body is not JSON.",
        404: "There is no such address.",
        405: "This address does not take that method.",
    }
    headers = dict(error.headers) if error.headers else None
    status = 422 if error.status_code == 400 else error.status_code
    return answer(status, code, texts.get(error.status_code, str(error.detail)), headers=headers)


async def _failed(request: Request, error: Exception) -> JSONResponse:
    log.error("%s %s failed", request.method, request.url.path, exc_info=error)
    return answer(500, "failed", "Something went wrong here. It was written to the log.")
