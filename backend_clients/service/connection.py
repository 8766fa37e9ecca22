"""HTTP to one service: token, limits, retries with a budget, errors. Knows nothing of plans and forecasts."""

from __future__ import annotations

import asyncio
import json
import logging
import time
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import httpx
from pydantic import SecretStr

from backend_clients.http.exchange import Answer, BadAddress, Exchange, ExchangeFailed, check_address, trust
from backend_clients.http.retry import RetryBudget, RetryPolicy, asked_pause_s
from backend_clients.http.trouble import is_passing
from backend_clients.service.errors import BadRequest, NoAnswer, ServiceError, Unreadable, failure, refusal

MAX_TEXT = 200
NO_TOKEN = SecretStr("")

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Service:
    """Where a service is and how to deal with it.

    Args:
        url: e.g. ``https://plans.example/v1``; a user name or password in it is refused.
        token: bearer token, empty for an open service.
        ca: file of the authorities to trust, empty for those of this machine.
        timeout_s: the longest wait for an answer of one attempt.
        max_request, max_response: longest body sent and read, bytes.
    """

    url: str
    token: SecretStr = NO_TOKEN
    ca: str = ""
    timeout_s: float = 5.0
    max_request: int = 4 * 2**20
    max_response: int = 4 * 2**20
    retry: RetryPolicy = field(default_factory=lambda: RetryPolicy(attempts=2, deadline_s=5.0))

    def __post_init__(self) -> None:
        try:
            check_address(self.url, "the service", "set the token")
        except BadAddress as error:
            raise BadRequest(f"{error}") from error
        token = self.token.get_secret_value()
        if token and not (token.isascii() and token.isprintable() and " " not in token):
            raise BadRequest("a token has visible ASCII characters only")


@dataclass(frozen=True, slots=True)
class Call:
    """One request.

    Args:
        path: below the service's address, already encoded.
        body: JSON bytes, ``None`` for none.
        is_repeatable: sending it twice does the same as once.
    """

    method: str
    path: str
    parameters: Mapping[str, str] = field(default_factory=dict)
    headers: Mapping[str, str] = field(default_factory=dict)
    body: bytes | None = None
    is_repeatable: bool = True


Reply = Answer
"""An answer that is not an error; 304 is one."""


class ServiceConnection:
    """Sends calls to one service.

    Args:
        transport: test seam, as in httpx.
        sleep: waits between attempts.
        mono_s: monotonic clock, seconds.
    """

    def __init__(
        self,
        service: Service,
        *,
        transport: httpx.AsyncBaseTransport | None = None,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
        mono_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self.service = service
        self._sleep, self._mono_s = sleep, mono_s
        self._budget = RetryBudget(reserve=5.0)
        token = service.token.get_secret_value()
        try:
            verify = trust(service.url, service.ca)
        except BadAddress as error:
            raise BadRequest(f"{error}") from error
        self._exchange = Exchange(
            service.url,
            {"Authorization": f"Bearer {token}"} if token else {},
            verify,
            timeout_s=service.timeout_s,
            max_response=service.max_response,
            connections=(8, 2),
            transport=transport,
        )

    async def close(self) -> None:
        """Close all connections."""
        await self._exchange.close()

    async def send(self, call: Call) -> Reply:
        """Return the service's answer; what is repeatable is tried again after a passing failure.

        Raises:
            ServiceError: as in ``errors``.
        """
        if call.body is not None and len(call.body) > self.service.max_request:
            raise BadRequest(f"{len(call.body)} bytes are more than is sent at once ({self.service.max_request})")
        begin_s, attempt = self._mono_s(), 0
        self._budget.called()
        while True:
            attempt += 1
            try:
                return await self._once(call)
            except ServiceError as error:
                pause_s = self._pause_s(call, error, attempt, self._mono_s() - begin_s)
                if pause_s is None:
                    raise
                log.info("%s %s again in %.1f s: %s", call.method, call.path, pause_s, type(error).__name__)
                await self._sleep(pause_s)

    def _pause_s(self, call: Call, error: ServiceError, attempt: int, spent_s: float) -> float | None:
        policy = self.service.retry
        # whoever waited the whole time once is not made to wait again
        if not call.is_repeatable or not is_passing(error) or isinstance(error, NoAnswer) or attempt >= policy.attempts:
            return None
        pause_s = policy.pause_s(attempt, error.retry_after_s)
        return pause_s if spent_s + pause_s <= policy.deadline_s and self._budget.take() else None

    async def _once(self, call: Call) -> Reply:
        try:
            reply = await self._exchange.send(call.method, call.path, call.parameters, call.headers, call.body)
        except ExchangeFailed as failed:
            raise failure(failed) from failed
        if reply.status == 304 or reply.status < 300:
            return reply
        raise _refused(reply)


def _refused(reply: Reply) -> ServiceError:
    if reply.status < 400:
        return Unreadable(f"a redirect ({reply.status}) is not followed")
    found = refusal(reply.status, _said(reply.content))
    found.retry_after_s = asked_pause_s(reply.headers)
    return found


def _said(content: bytes) -> str:
    """Return the sentence of a service's refusal as plain text, empty if there is none."""
    try:
        told: Any = json.loads(content)
        text = str(told["text"])
    except (ValueError, KeyError, TypeError, RecursionError):
        return ""
    return "".join(c for c in text[:MAX_TEXT] if c.isprintable())
