"""The gateway's websocket and HTTP interface; see ``docs/protocols/stop.md``."""

from __future__ import annotations

import asyncio
import ipaddress
import os
import re
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any
from urllib.parse import urlsplit

import msgspec
from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.middleware.cors import CORSMiddleware
from starlette.requests import ClientDisconnect, HTTPConnection, Request
from starlette.responses import Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from hmi.domain.stop_token import StopToken
from hmi.settings import Settings
from hmi.stop_gateway.errors import BadFrame, GatewayError, TokenRefused
from hmi.stop_gateway.frames import MAX_FRAME_BYTES, AuthFrame, PingFrame, StopFrame, encode, read_body, read_frame
from hmi.stop_gateway.gateway import Gateway
from hmi.stop_gateway.hub import Client
from hmi.stop_gateway.origins import origin_pattern

AUTH_WITHIN_S = 2.0
REFUSED_CLOSE = 4401
PREFLIGHT_S = 86_400
_encoder = msgspec.json.Encoder()


class GatewayApp:
    """Websocket and HTTP handlers around one ``Gateway``."""

    def __init__(self, gateway: Gateway, settings: Settings) -> None:
        self._gateway = gateway
        self._origins = re.compile(origin_pattern(settings))

    async def websocket(self, websocket: WebSocket) -> None:
        """Serve ``/ws``: one browser until it goes."""
        origin = websocket.headers.get("origin")
        if origin is not None and not self._origins.fullmatch(origin):
            await websocket.close(4403)  # before accept: the handshake fails with 403
            return
        await websocket.accept()
        client = Client(websocket)
        try:
            token = await self._first_frame(websocket)
        except (TokenRefused, BadFrame) as error:
            await websocket.send_text(encode({"k": "refused", "code": error.code, "text": error.text}))
            await websocket.close(REFUSED_CLOSE)
            return
        except WebSocketDisconnect:
            return
        writer = asyncio.create_task(client.write(), name="stop-browser")
        try:
            self._gateway.greet(client, token)
            await self._serve(websocket, client, token)
        except WebSocketDisconnect:
            pass
        finally:
            self._gateway.hub.leave(client)
            client.close()
            writer.cancel()

    async def stop(self, request: Request) -> Response:
        """Serve ``POST /stop``."""
        try:
            body = read_body(await _body(request))
            token = self._gateway.admit(_bearer(request) or body.token)
            steps = self._gateway.press(body.stop_id, body.robots, token)
        except GatewayError as error:
            return _json({"code": error.code, "text": error.text}, 401 if isinstance(error, TokenRefused) else 400)
        return _json({"stop_id": body.stop_id, "steps": steps}, 202)

    async def steps(self, request: Request) -> Response:
        """Serve ``GET /stop/{stop_id}``."""
        try:
            self._gateway.admit(_bearer(request))
        except TokenRefused as error:
            return _json({"code": error.code, "text": error.text}, 401)
        stop_id = request.path_params["stop_id"]
        return _json({"stop_id": stop_id, "steps": self._gateway.dispatcher.steps(stop_id)}, 200)

    async def health(self, request: Request) -> Response:
        """Serve ``GET /health``; the process id is for the machine itself only."""
        own = {"pid": os.getpid()} if _is_loopback(request) else {}
        return _json({**self._gateway.health(), **own}, 200)

    async def _first_frame(self, websocket: WebSocket) -> StopToken:
        try:
            async with asyncio.timeout(AUTH_WITHIN_S):
                frame = read_frame(await _text(websocket))
        except TimeoutError as error:
            raise TokenRefused(f"No STOP token within {AUTH_WITHIN_S:.0f} s.") from error
        if not isinstance(frame, AuthFrame):
            raise TokenRefused("The first frame must carry the STOP token.")
        return self._gateway.admit(frame.token)

    async def _serve(self, websocket: WebSocket, client: Client, token: StopToken) -> None:
        while True:
            text = await _text(websocket)
            try:
                match read_frame(text):
                    case StopFrame(stop_id=stop_id, robots=robots):
                        # asked again at each press: a tablet may have been revoked since it connected
                        if self._gateway.dispatcher.registry.is_revoked(token.device_id):
                            raise TokenRefused("This tablet was taken out of use. STOP does not work here.")
                        for step in self._gateway.press(stop_id, robots, token):
                            client.tell((step["stop_id"], step["robot"]), encode(step))
                    case PingFrame(n=n):
                        client.tell("pong", encode({"k": "pong", "n": n}))
                    case AuthFrame(token=text):
                        token = self._gateway.admit(text)
            except GatewayError as error:
                client.tell("error", encode({"k": "error", "code": error.code, "text": error.text}))


def make_app(gateway: Gateway, settings: Settings) -> Starlette:
    """Return the ASGI application; its life is the gateway's life."""
    handlers = GatewayApp(gateway, settings)

    @asynccontextmanager
    async def life(_app: Starlette) -> AsyncIterator[None]:
        await gateway.start()
        yield
        await gateway.stop()

    cors = Middleware(
        CORSMiddleware,
        allow_origin_regex=origin_pattern(settings),
        allow_methods=["GET", "POST"],
        allow_headers=["authorization", "content-type"],
        allow_private_network=True,
        max_age=PREFLIGHT_S,
    )
    return Starlette(routes=_routes(handlers, settings), middleware=[cors], lifespan=life)


def _routes(handlers: GatewayApp, settings: Settings) -> list[Any]:
    def paths() -> list[Any]:
        return [
            WebSocketRoute("/ws", handlers.websocket),
            Route("/health", handlers.health),
            Route("/stop", handlers.stop, methods=["POST"]),
            Route("/stop/{stop_id}", handlers.steps),
        ]

    # a reverse proxy may or may not strip the path of the public address
    prefix = urlsplit(settings.stop_public_url or "").path.rstrip("/")
    return [*([Mount(prefix, routes=paths())] if prefix else []), *paths()]


async def _body(request: Request) -> bytes:
    data = b""
    try:
        async for chunk in request.stream():
            data += chunk
            if len(data) > MAX_FRAME_BYTES:
                raise BadFrame(f"The body has more than {MAX_FRAME_BYTES} bytes.")
    except ClientDisconnect as error:
        raise BadFrame("The body ended early.") from error
    return data


async def _text(websocket: WebSocket) -> str | bytes:
    message = await websocket.receive()
    if message["type"] != "websocket.receive":
        raise WebSocketDisconnect(message.get("code", 1006))
    text: str | None = message.get("text")
    return text if text is not None else message.get("bytes") or b""


def _bearer(connection: HTTPConnection) -> str:
    scheme, _, token = connection.headers.get("authorization", "").partition(" ")
    return token.strip() if scheme.lower() == "bearer" else ""


def _is_loopback(request: Request) -> bool:
    if request.client is None or any(h in request.headers for h in ("forwarded", "x-forwarded-for")):
        return False  # a proxy on this machine speaks for somebody else
    try:
        return ipaddress.ip_address(request.client.host).is_loopback
    except ValueError:
        return False


def _json(body: object, status: int) -> Response:
    return Response(_encoder.encode(body), status, media_type="application/json")
