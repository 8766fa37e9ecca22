"""An OAuth2 token endpoint (RFC 6749) and the proxy before a broker that lets in who has its newest token."""

from __future__ import annotations

import base64
import secrets
from urllib.parse import parse_qs

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route
from starlette.types import ASGIApp, Receive, Scope, Send

CLIENT, SECRET, USER, PASSWORD = "headland", "s3cret", "farm", "p&w word"


class TokenService:
    """Gives tokens out and takes them back.

    Args:
        life_s: told as ``expires_in``.
    """

    def __init__(self, life_s: float = 300.0) -> None:
        self.life_s, self.status = life_s, 0
        self.secret, self.asked = SECRET, 0
        self.valid: set[str] = set()
        self.application = Starlette(routes=[Route("/token", self._token, methods=["POST"])])

    def behind(self, broker: ASGIApp) -> ASGIApp:
        """Return the broker behind a proxy that lets in whoever has a token of ours, and answers 401 to others."""

        async def proxy(scope: Scope, receive: Receive, send: Send) -> None:
            if scope["type"] == "http":
                sent = dict(scope["headers"]).get(b"authorization", b"").decode()
                if sent.removeprefix("Bearer ") not in self.valid:
                    await Response("Log in", 401)(scope, receive, send)
                    return
            await broker(scope, receive, send)

        return proxy

    async def _token(self, request: Request) -> Response:
        self.asked += 1
        if self.status:
            return Response("trouble", self.status)
        form = {key: values[0] for key, values in parse_qs((await request.body()).decode()).items()}
        pair = base64.b64decode(request.headers.get("authorization", "").removeprefix("Basic ")).decode()
        if pair != f"{CLIENT}:{self.secret}":
            return JSONResponse({"error": "invalid_client", "error_description": pair}, 401)
        if form["grant_type"] == "password" and (form["username"], form["password"]) != (USER, PASSWORD):
            return JSONResponse({"error": "invalid_grant"}, 400)
        token = secrets.token_urlsafe(16)
        self.valid.add(token)
        return JSONResponse({"access_token": token, "token_type": "Bearer", "expires_in": self.life_s})
