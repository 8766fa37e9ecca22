"""HTTP to a broker: headers, limits, retries, errors. Knows nothing of entities."""

from __future__ import annotations

import asyncio
import json
import ssl
import time
import uuid
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass, field
from typing import Any
from urllib.parse import urlsplit

import httpx
import structlog

from backend_clients.ngsi.errors import (
    BadInput,
    BrokerRefused,
    NgsiError,
    NoAnswer,
    NotAllowed,
    TooLong,
    Unreachable,
    Unreadable,
    Untrusted,
    refusal,
)
from backend_clients.ngsi.retry import RetryBudget, RetryPolicy, is_passing
from backend_clients.ngsi.tenant import Tenant
from backend_clients.ngsi.token import TokenSource
from backend_clients.trust import is_distrust

MAX_REQUEST = 1_048_576  # Orion refuses longer ones
MAX_RESPONSE = 16 * 1024 * 1024
CONNECT_S = 3.0
READ_S = 10.0

log = structlog.get_logger(__name__)


@dataclass(frozen=True, slots=True)
class Broker:
    """Where a broker is and how to deal with it.

    Args:
        url: e.g. ``https://broker.example/orion``; a user name or password in it is refused.
        tenant: where entities live.
        verify: ``False`` takes any certificate, a text is the file of the authorities to trust.
        timeout_s: the longest wait for an answer of one attempt.
        max_response: longest answer read, bytes.
    """

    url: str
    tenant: Tenant = field(default_factory=Tenant)
    verify: bool | str = True
    timeout_s: float = READ_S
    max_response: int = MAX_RESPONSE
    retry: RetryPolicy = field(default_factory=RetryPolicy)

    def __post_init__(self) -> None:
        try:
            parts = urlsplit(self.url)
            is_usable = parts.scheme in ("http", "https") and bool(parts.hostname) and parts.port != 0
        except ValueError as error:
            raise BadInput("the broker's address is no http or https URL") from error
        if not is_usable or parts.query or parts.fragment:
            raise BadInput("the broker's address is no http or https URL")
        if parts.username is not None or parts.password is not None:
            raise BadInput("credentials do not belong in the broker's address; give a token source")


@dataclass(frozen=True, slots=True)
class Call:
    """One request.

    Args:
        path: below the broker's address, already encoded.
        body: JSON, ``None`` for none; bytes are JSON already.
        is_repeatable: sending it twice does the same as once.
    """

    method: str
    path: str
    parameters: Mapping[str, str] = field(default_factory=dict)
    body: Any = None
    is_repeatable: bool = False


@dataclass(frozen=True, slots=True)
class Reply:
    """An answer that is not an error; ``attempts`` counts how often it was asked for."""

    status: int
    headers: httpx.Headers
    content: bytes
    attempts: int = 1

    def json(self) -> Any:
        """Return the JSON of the answer; raises ``Unreadable``."""
        try:
            return json.loads(self.content, parse_constant=_no_constant)
        except (ValueError, RecursionError) as error:
            raise Unreadable(f"the answer is not JSON: {self.content[:60]!r}") from error


class Connection:
    """Sends calls to one broker.

    Args:
        broker: where it is.
        tokens: where credentials come from; ``None`` for an open broker.
        transport: test seam, as in httpx.
        sleep: waits between attempts.
        mono_s: monotonic clock, seconds.
    """

    def __init__(
        self,
        broker: Broker,
        tokens: TokenSource | None = None,
        *,
        transport: httpx.AsyncBaseTransport | None = None,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
        mono_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self.broker = broker
        self._tokens, self._sleep, self._mono_s = tokens, sleep, mono_s
        self._budget = RetryBudget()
        self._client = httpx.AsyncClient(
            base_url=broker.url.rstrip("/") + "/",
            # identity, since a small compressed answer can be a large one
            headers={**broker.tenant.headers(), "Accept": "application/json", "Accept-Encoding": "identity"},
            timeout=httpx.Timeout(broker.timeout_s, connect=min(CONNECT_S, broker.timeout_s)),
            verify=_trust(broker),
            follow_redirects=False,  # a redirect would carry the token elsewhere
            trust_env=False,
            transport=transport,
            limits=httpx.Limits(max_connections=20, max_keepalive_connections=10),
        )

    async def close(self) -> None:
        """Close all connections, those of the token source too."""
        await self._client.aclose()
        if self._tokens is not None:
            await self._tokens.close()

    async def send(self, call: Call) -> Reply:
        """Return the broker's answer; what is repeatable is tried again after a passing failure.

        Raises:
            NgsiError: as in ``errors``; of ``Unreachable``, ``is_outcome_unknown`` says that it may have taken effect.
        """
        content = _content(call.body)
        correlator = str(uuid.uuid4())
        begin_s, attempt, is_unknown = self._mono_s(), 0, False
        self._budget.called()
        while True:
            attempt += 1
            try:
                reply = await self._with_token(call, content, correlator)
                return Reply(reply.status, reply.headers, reply.content, attempt)
            except NgsiError as error:
                is_unknown = call.method != "GET" and (is_unknown or _is_unknown(error))
                error.attempts, error.is_outcome_unknown = attempt, is_unknown
                pause_s = self._pause_s(call, error, attempt, self._mono_s() - begin_s)
                if pause_s is None:
                    raise
                log.info("ngsi.again", method=call.method, path=call.path, attempt=attempt, correlator=correlator,
                         because=type(error).__name__, pause_s=round(pause_s, 2))  # fmt: skip
                await self._sleep(pause_s)

    def _pause_s(self, call: Call, error: NgsiError, attempt: int, spent_s: float) -> float | None:
        """Return how long to wait before the next attempt, ``None`` if there is none."""
        policy = self.broker.retry
        if not call.is_repeatable or not is_passing(error) or attempt >= policy.attempts:
            return None
        pause_s = policy.pause_s(attempt, getattr(error, "retry_after_s", None))
        if spent_s + pause_s > policy.deadline_s or not self._budget.take():
            return None
        return pause_s

    async def _with_token(self, call: Call, content: bytes | None, correlator: str) -> Reply:
        try:
            return await self._once(call, content, correlator)
        except NotAllowed as error:
            # a 401 did nothing, so any request may be sent again with a new token
            if error.status != 401 or self._tokens is None or not self._tokens.refused():
                raise
            return await self._once(call, content, correlator)

    async def _once(self, call: Call, content: bytes | None, correlator: str) -> Reply:
        headers = {"Fiware-Correlator": correlator}
        if content is not None:
            headers["Content-Type"] = "application/json"  # never on GET and DELETE: Orion refuses it there
        if self._tokens is not None:
            headers |= await self._tokens.headers()
        begin_s = self._mono_s()
        request = self._client.build_request(
            call.method, call.path, params=dict(call.parameters) or None, content=content, headers=headers
        )
        reply = await self._exchange(call, request)
        log.debug("ngsi.call", method=call.method, path=call.path, status=reply.status, correlator=correlator,
                  ms=round((self._mono_s() - begin_s) * 1000))  # fmt: skip
        if reply.status >= 300:
            raise _refused(reply, correlator)
        return reply

    async def _exchange(self, call: Call, request: httpx.Request) -> Reply:
        what = f"{call.method} {call.path}"
        try:
            async with asyncio.timeout(self.broker.timeout_s):  # a byte now and then must not hold a call for ever
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
            text = f"{what}: no answer in {self.broker.timeout_s:g} s"
            raise NoAnswer(text, is_outcome_unknown=True) from error
        except httpx.DecodingError as error:
            raise Unreadable(f"{what}: the answer cannot be decoded") from error
        except httpx.HTTPError as error:
            raise Unreachable(f"{what}: {_reason(error)}", is_outcome_unknown=True) from error

    async def _read(self, response: httpx.Response, what: str) -> bytes:
        if response.headers.get("content-encoding", "identity") != "identity":
            raise Unreadable(f"{what}: the answer is compressed although nobody asked for it")
        content = bytearray()
        async for piece in response.aiter_bytes():
            content += piece
            if len(content) > self.broker.max_response:
                raise TooLong(f"{what}: more than {self.broker.max_response} bytes")
        return bytes(content)


def _trust(broker: Broker) -> ssl.SSLContext | bool:
    if not broker.url.startswith("https:"):
        return False  # loading the authorities takes 30 ms and more, for nothing without TLS
    if not isinstance(broker.verify, str):
        return broker.verify
    try:
        return ssl.create_default_context(cafile=broker.verify)
    except OSError as error:  # an SSLError is one, too
        raise BadInput(f"no file of authorities: {broker.verify}") from error


def _is_unknown(error: NgsiError) -> bool:
    """Say whether a write that ended so may have taken effect."""
    return error.is_outcome_unknown or isinstance(error, Unreadable)


def _content(body: Any) -> bytes | None:
    if body is None:
        return None
    content: bytes = body
    if not isinstance(body, bytes):
        content = json.dumps(body, ensure_ascii=False, allow_nan=False, separators=(",", ":")).encode()
    if len(content) > MAX_REQUEST:
        raise BadInput(f"{len(content)} bytes are more than a broker takes at once ({MAX_REQUEST})")
    return content


def _refused(reply: Reply, correlator: str) -> NgsiError:
    if reply.status < 400:
        return Unreadable(f"a redirect ({reply.status}) is not followed")
    error, description = "", ""
    try:
        body = json.loads(reply.content)
        error, description = str(body["error"])[:80], str(body.get("description", ""))[:2000]
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        error, description = f"HTTP{reply.status}", "an answer that is not NGSI-v2"
    found: BrokerRefused = refusal(reply.status, error, description, correlator)
    found.retry_after_s = _seconds(reply.headers.get("retry-after", ""))
    return found


def _seconds(text: str) -> float | None:
    return float(text) if text.isascii() and text.isdigit() and len(text) < 8 else None


def _reason(error: Exception) -> str:
    return f"{type(error).__name__} {error}".strip()[:200]


def _no_constant(text: str) -> None:
    raise ValueError(text)
