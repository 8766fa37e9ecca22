"""Faults before any HTTP service: slow, failing, half open, refusing, not JSON, a clock that is off."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import timedelta
from email.utils import format_datetime
from enum import StrEnum
from typing import Any

from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from hmi.clock import Clock, SystemClock

HALF_OPEN_S = 600.0
HUGE_BYTES = 20 * 2**20


class Fault(StrEnum):
    """What a service does instead of its work."""

    NONE = "none"
    FAIL = "fail"
    HALF_OPEN = "half-open"
    TOO_LARGE = "too-large"
    REFUSE = "refuse"
    NOT_JSON = "not-json"
    HUGE = "huge"
    CUT = "cut"


@dataclass(frozen=True, slots=True)
class Faults:
    """Faults in force.

    Args:
        fault: instead of every answer.
        delay_s: each answer waits so long.
        clock_s: how far the service's clock is ahead, in its ``Date`` header.
        alter: changes the JSON of every answer.
        paths: only requests whose path begins so are hit; empty is all.
    """

    fault: Fault = Fault.NONE
    delay_s: float = 0.0
    clock_s: float = 0.0
    alter: Callable[[Any], Any] | None = None
    paths: str = ""


class FaultyHttp:
    """An ASGI application with faults before it; put others in force through ``faults`` at any time."""

    def __init__(self, application: ASGIApp, faults: Faults | None = None, clock: Clock | None = None) -> None:
        self._application, self._clock = application, clock or SystemClock()
        self.faults = faults or Faults()
        self.requests = 0

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request."""
        if scope["type"] != "http":
            await self._application(scope, receive, send)
            return
        self.requests += 1
        faults = self.faults if scope["path"].startswith(self.faults.paths) else Faults()
        if faults.delay_s:
            await asyncio.sleep(faults.delay_s)
        if faults.fault is Fault.HALF_OPEN:
            await asyncio.sleep(HALF_OPEN_S)
        if faults.fault is Fault.CUT:
            await send({"type": "http.response.start", "status": 200, "headers": [(b"content-length", b"100000")]})
            await send({"type": "http.response.body", "body": b"{", "more_body": True})
            raise ConnectionAbortedError("a tester cut this answer")
        if faults.fault is not Fault.NONE:
            await _instead(faults.fault)(scope, receive, send)
            return
        await self._application(scope, receive, self._changed(faults, send))

    def _changed(self, faults: Faults, send: Send) -> Send:
        if faults.alter is None and not faults.clock_s:
            return send
        begun: list[Message] = []

        async def changed(message: Message) -> None:
            if message["type"] == "http.response.start":
                begun.append(message)
                return
            body = message.get("body", b"")
            if faults.alter is not None and body:
                body = json.dumps(faults.alter(json.loads(body))).encode()
            headers = [(k, v) for k, v in begun[0]["headers"] if k != b"content-length"]
            headers.append((b"content-length", str(len(body)).encode()))
            if faults.clock_s:
                date = self._clock.utc() + timedelta(seconds=faults.clock_s)
                headers.append((b"date", format_datetime(date, usegmt=True).encode()))
            await send({**begun[0], "headers": headers})
            await send({**message, "body": body})

        return changed

    def set(self, **changes: Any) -> None:
        """Put other faults in force; what is not named is off."""
        self.faults = replace(Faults(), **changes)


def _instead(fault: Fault) -> Response:
    if fault is Fault.NOT_JSON:
        return Response(b"<html>a proxy's page</html>", media_type="text/html")
    if fault is Fault.HUGE:
        return Response(b"[" + b" " * HUGE_BYTES + b"]", media_type="application/json")
    status = {Fault.FAIL: 503, Fault.TOO_LARGE: 413, Fault.REFUSE: 401}[fault]
    text = json.dumps({"code": "simulated", "text": "A tester switched this fault on."})
    return Response(text, status, media_type="application/json")
