"""The service over HTTP: the open format of docs/protocols/planner.md as an ASGI application."""

from __future__ import annotations

import hmac
import re
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from pydantic import BaseModel, ValidationError
from starlette.applications import Starlette
from starlette.requests import ClientDisconnect, Request
from starlette.responses import Response
from starlette.routing import Route

from backend_clients.planner.messages import MAX_REQUEST, PlanRequest, Problem, ServiceInfo
from hmi.planning_service.desk import BUSY_AGAIN_S, NAME, DeskRefused, PlanDesk

KEY = re.compile(r"[A-Za-z0-9_-]{1,64}")


class PlannerEndpoint:
    """Answers requests for one desk.

    Args:
        token: bearer token that every request has to carry; empty lets everybody in.
    """

    def __init__(self, desk: PlanDesk, token: str = "") -> None:
        self._desk, self._token = desk, token

    def routes(self) -> list[Route]:
        """Return the routes."""
        return [
            Route("/", self._info),
            Route("/plans", self._submit, methods=["POST"]),
            Route("/plans/{plan_id}", self._plan, methods=["GET", "DELETE"]),
        ]

    async def _info(self, request: Request) -> Response:
        return self._guarded(request) or _json(ServiceInfo(service="planner", planner=NAME, waiting=self._desk.waiting))

    async def _submit(self, request: Request) -> Response:
        if refused := self._guarded(request):
            return refused
        key = request.headers.get("idempotency-key")
        if key is not None and not KEY.fullmatch(key):
            return _problem(422, "bad_key", "An idempotency key has 1 to 64 letters, digits, - or _.")
        try:
            body = await _body(request)
        except ClientDisconnect:
            return Response(status_code=400)
        if body is None:
            return _problem(413, "too_long", f"A request has at most {MAX_REQUEST} bytes.")
        try:
            report = self._desk.submit(PlanRequest.model_validate_json(body), key)
        except ValidationError as error:
            first = error.errors(include_url=False, include_input=False, include_context=False)[0]
            where = ".".join(str(part) for part in first["loc"])
            status = 400 if first["type"] == "json_invalid" else 422
            return _problem(status, "invalid", f"{where} {first['msg']}".strip()[:400], where[:64])
        except DeskRefused as refused_wish:
            return _refusal(refused_wish)
        return _json(report, 202, {"Location": f"plans/{report.id}"})

    async def _plan(self, request: Request) -> Response:
        if refused := self._guarded(request):
            return refused
        plan_id = request.path_params["plan_id"]
        try:
            if request.method == "DELETE":
                self._desk.give_up(plan_id)
                return Response(status_code=204)
            return _json(self._desk.report(plan_id))
        except DeskRefused as refused_plan:
            return _refusal(refused_plan)

    def _guarded(self, request: Request) -> Response | None:
        given = request.headers.get("authorization", "")
        if self._token and not hmac.compare_digest(given.encode(), f"Bearer {self._token}".encode()):
            return _problem(401, "not_allowed", "The token is missing or wrong.")
        return None


def make_application(desk: PlanDesk, token: str = "") -> Starlette:
    """Return the ASGI application of a desk; its end closes the desk."""

    @asynccontextmanager
    async def lifespan(_app: Starlette) -> AsyncIterator[None]:
        yield
        await desk.close()

    return Starlette(routes=PlannerEndpoint(desk, token).routes(), lifespan=lifespan)


async def _body(request: Request) -> bytes | None:
    """Return the body, ``None`` if it is too long; no more than the limit is read."""
    body = bytearray()
    async for part in request.stream():
        body += part
        if len(body) > MAX_REQUEST:
            return None
    return bytes(body)


def _json(model: BaseModel, status: int = 200, headers: dict[str, str] | None = None) -> Response:
    text = model.model_dump_json(exclude_none=True)
    return Response(text, status, {"Cache-Control": "no-store", **(headers or {})}, "application/json")


def _refusal(refused: DeskRefused) -> Response:
    response = _problem(refused.status, refused.code, refused.text)
    if refused.status == 429:
        response.headers["Retry-After"] = str(BUSY_AGAIN_S)
    return response


def _problem(status: int, code: str, text: str, field: str = "") -> Response:
    return _json(Problem(code=code, text=text, field=field), status)
