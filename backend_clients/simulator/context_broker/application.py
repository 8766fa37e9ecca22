"""The broker as an ASGI application, with its faults and their switch."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager

from pydantic import ValidationError
from starlette.applications import Starlette
from starlette.datastructures import Headers
from starlette.requests import ClientDisconnect, Request
from starlette.responses import Response
from starlette.routing import Mount
from starlette.types import ASGIApp, Receive, Scope, Send

from backend_clients.simulator.context_broker.broker import ContextBroker, refused
from backend_clients.simulator.context_broker.exchange import Answer
from backend_clients.simulator.context_broker.faults import Faults, FaultSwitch
from backend_clients.simulator.context_broker.refusal import Refusal

FAULTS_PATH = "/simulator/faults"  # PUT a ``Faults`` object, DELETE to end them; no broker has this
HALF_OPEN_S = 600.0
MAX_FAULTS = 4096


class BrokerEndpoint:
    """Speaks HTTP for a broker.

    Args:
        broker: what answers.
        switch: the faults in force.
    """

    def __init__(self, broker: ContextBroker, switch: FaultSwitch) -> None:
        self._broker, self._switch = broker, switch
        self._closing = asyncio.Event()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request."""
        if scope["type"] != "http":
            return
        request = Request(scope, receive)
        try:
            response = await self._served(request)
        except (ClientDisconnect, ConnectionError):
            return
        await response(scope, receive, send)

    def close(self) -> None:
        """Let requests that a fault holds go."""
        self._closing.set()

    async def _served(self, request: Request) -> ASGIApp:
        if request.url.path == FAULTS_PATH:
            return await self._switched(request)
        faults = self._switch.next(request.method)
        try:
            body = await _body(request, faults.max_body)
        except Refusal as problem:
            return _response(refused(problem))
        answer = self._answer(request, body, faults)
        if faults.delay_s:
            await self._wait(faults.delay_s)
        if faults.half_open:
            await self._wait(HALF_OPEN_S)
            return _Cut(b"", 0)
        return _Cut(answer.body, faults.cut) if faults.cut is not None else _response(answer)

    def _answer(self, request: Request, body: bytes, faults: Faults) -> Answer:
        if faults.token and request.headers.get("authorization") != f"Bearer {faults.token}":
            return refused(Refusal(401, "Unauthorized", "the token is missing or not valid"))
        is_lost = bool(faults.status) or faults.half_open
        answer = Answer()
        if not is_lost or faults.takes_effect:
            headers = _with_tenant(request.headers, faults.wrong_tenant)
            path = request.scope.get("raw_path", request.url.path.encode()).decode("latin-1").partition("?")[0]
            answer = self._broker.answer(request.method, path, request.query_params, headers, body)
        if faults.status:
            return refused(Refusal(faults.status, "SimulatedFault", "a tester switched this fault on"))
        return answer

    async def _wait(self, seconds: float) -> None:
        try:
            async with asyncio.timeout(seconds):
                await self._closing.wait()
        except TimeoutError:
            pass

    async def _switched(self, request: Request) -> Response:
        if request.method == "DELETE":
            self._switch.set(Faults())
            return Response(status_code=204)
        if request.method != "PUT":
            return Response(status_code=405, headers={"Allow": "PUT, DELETE"})
        try:
            self._switch.set(Faults.model_validate_json(await _body(request, MAX_FAULTS)))
        except ValidationError as error:
            return Response(str(error), status_code=400, media_type="text/plain")
        except Refusal as problem:
            return _response(refused(problem))
        return Response(status_code=204)


class _Cut:
    """An answer that promises more than it sends, as when a link dies in the middle."""

    def __init__(self, body: bytes, size: int) -> None:
        self._body, self._size = body, size

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        length = str(max(len(self._body), self._size + 1)).encode()
        headers = [(b"content-type", b"application/json"), (b"content-length", length)]
        await send({"type": "http.response.start", "status": 200, "headers": headers})
        await send({"type": "http.response.body", "body": self._body[: self._size], "more_body": True})
        raise ConnectionAbortedError("a tester cut this answer")


def make_application(
    broker: ContextBroker, switch: FaultSwitch | None = None, beside: Mapping[str, ASGIApp] | None = None
) -> Starlette:
    """Return the ASGI application of a broker, with others beside it; its end ends the broker's notifications."""
    endpoint = BrokerEndpoint(broker, switch or FaultSwitch())

    @asynccontextmanager
    async def lifespan(_app: Starlette) -> AsyncIterator[None]:
        yield
        endpoint.close()
        await broker.close()

    others = [Mount(path, app=application) for path, application in (beside or {}).items()]
    return Starlette(routes=[*others, Mount("/", app=endpoint)], lifespan=lifespan)


def _response(answer: Answer) -> Response:
    response = Response(answer.body, status_code=answer.status, headers=dict(answer.headers))
    if answer.media_type:
        response.headers["Content-Type"] = answer.media_type
    return response


def _with_tenant(headers: Headers, tenant: str | None) -> Headers:
    if tenant is None:
        return headers
    return Headers({**headers, "fiware-service": tenant})


async def _body(request: Request, limit: int) -> bytes:
    parts, size = [], 0
    async for chunk in request.stream():
        size += len(chunk)
        if size > limit:
            text = f"payload size: {max(size, _promised(request))}, max size supported: {limit}"
            raise Refusal(413, "RequestEntityTooLarge", text)
        parts.append(chunk)
    return b"".join(parts)


def _promised(request: Request) -> int:
    text = request.headers.get("content-length", "")
    return int(text) if text.isascii() and text.isdigit() and len(text) < 16 else 0
