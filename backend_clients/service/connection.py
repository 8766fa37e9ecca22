"""HTTP to one service: token, limits, retries with a budget, errors. Knows nothing of plans and forecasts."""

from __future__ import annotations

import asyncio
import json
import logging
import ssl
import time
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass, field
from typing import Any
from urllib.parse import urlsplit

import httpx
from pydantic import SecretStr

from backend_clients.ngsi.retry import RetryBudget, RetryPolicy
from backend_clients.service.errors import (
    BadRequest,
    NoAnswer,
    ServiceError,
    ServiceRefused,
    TooLong,
    Unreachable,
    Unreadable,
    Untrusted,
    is_passing,
    refusal,
)
from backend_clients.trust import authorities, is_distrust

CONNECT_S = 3.0
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
            parts = urlsplit(self.url)
            is_usable = parts.scheme in ("http", "https") and bool(parts.hostname) and parts.port != 0
        except ValueError as error:
            raise BadRequest("the address of the service is no http or https URL") from error
        if not is_usable or parts.query or parts.fragment:
            raise BadRequest("the address of the service is no http or https URL")
        if parts.username is not None or parts.password is not None:
            raise BadRequest("credentials do not belong in the address; set the token")
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


@dataclass(frozen=True, slots=True)
class Reply:
    """An answer that is not an error; 304 is one."""

    status: int
    headers: httpx.Headers
    content: bytes


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
        # identity, since a small compressed answer can be a large one
        headers = {"Accept": "application/json", "Accept-Encoding": "identity"}
        token = service.token.get_secret_value()
        self._client = httpx.AsyncClient(
            base_url=service.url.rstrip("/") + "/",
            headers=headers | ({"Authorization": f"Bearer {token}"} if token else {}),
            timeout=httpx.Timeout(service.timeout_s, connect=min(CONNECT_S, service.timeout_s)),
            verify=_trust(service),
            follow_redirects=False,  # a redirect would carry the token elsewhere
            trust_env=False,
            transport=transport,
            limits=httpx.Limits(max_connections=8, max_keepalive_connections=2),
        )

    async def close(self) -> None:
        """Close all connections."""
        await self._client.aclose()

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
        pause_s = policy.pause_s(attempt, getattr(error, "retry_after_s", None))
        return pause_s if spent_s + pause_s <= policy.deadline_s and self._budget.take() else None

    async def _once(self, call: Call) -> Reply:
        headers = dict(call.headers)
        if call.body is not None:
            headers["Content-Type"] = "application/json"
        request = self._client.build_request(
            call.method, call.path, params=dict(call.parameters) or None, content=call.body, headers=headers
        )
        reply = await self._exchange(call, request)
        if reply.status == 304 or reply.status < 300:
            return reply
        raise _refused(reply)

    async def _exchange(self, call: Call, request: httpx.Request) -> Reply:
        what = f"{call.method} /{call.path}"
        try:
            async with asyncio.timeout(self.service.timeout_s):  # a byte now and then must not hold a call for ever
                response = await self._client.send(request, stream=True)
                try:
                    return Reply(response.status_code, response.headers, await self._read(response, what))
                finally:
                    await response.aclose()
        except (httpx.ConnectError, httpx.ConnectTimeout, httpx.PoolTimeout) as error:
            if is_distrust(error):
                raise Untrusted(f"{what}: {_reason(error)}") from error
            raise Unreachable(f"{what}: no connection: {_reason(error)}") from error
        except (httpx.TimeoutException, TimeoutError) as error:
            raise NoAnswer(f"{what}: no answer in {self.service.timeout_s:g} s") from error
        except httpx.DecodingError as error:
            raise Unreadable(f"{what}: the answer cannot be decoded") from error
        except httpx.HTTPError as error:
            raise Unreachable(f"{what}: {_reason(error)}") from error

    async def _read(self, response: httpx.Response, what: str) -> bytes:
        if response.headers.get("content-encoding", "identity") != "identity":
            raise Unreadable(f"{what}: the answer is compressed although nobody asked for it")
        content = bytearray()
        async for piece in response.aiter_bytes():
            content += piece
            if len(content) > self.service.max_response:
                raise TooLong(f"{what}: more than {self.service.max_response} bytes")
        return bytes(content)


def _trust(service: Service) -> ssl.SSLContext | bool:
    if not service.url.startswith("https:"):
        return False  # loading the authorities takes 30 ms and more, for nothing without TLS
    if not service.ca:
        return authorities()
    try:
        return ssl.create_default_context(cafile=service.ca)
    except OSError as error:  # an SSLError is one, too
        raise BadRequest(f"no file of authorities: {service.ca}") from error


def _refused(reply: Reply) -> ServiceError:
    if reply.status < 400:
        return Unreadable(f"a redirect ({reply.status}) is not followed")
    found: ServiceRefused = refusal(reply.status, _said(reply.content))
    asked = reply.headers.get("retry-after", "")
    found.retry_after_s = float(asked) if asked.isascii() and asked.isdigit() and len(asked) < 8 else None
    return found


def _said(content: bytes) -> str:
    """Return the sentence of a service's refusal as plain text, empty if there is none."""
    try:
        told: Any = json.loads(content)
        text = str(told["text"])
    except (ValueError, KeyError, TypeError, RecursionError):
        return ""
    return "".join(c for c in text[:MAX_TEXT] if c.isprintable())


def _reason(error: Exception) -> str:
    return f"{type(error).__name__} {error}".strip()[:MAX_TEXT]
