"""HTTP to a broker: headers, limits, retries, errors. Knows nothing of entities."""

from __future__ import annotations

import asyncio
import json
import time
import uuid
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import httpx
import structlog

from backend_clients.http.exchange import Answer, BadAddress, Exchange, ExchangeFailed, check_address, trust
from backend_clients.http.retry import RetryBudget, RetryPolicy, asked_pause_s
from backend_clients.http.trouble import is_passing
from backend_clients.ngsi.errors import BadInput, NgsiError, NoAnswer, NotAllowed, Unreadable, failure, refusal
from backend_clients.ngsi.tenant import Tenant
from backend_clients.ngsi.token import TokenSource

MAX_REQUEST = 1_048_576  # Orion refuses longer ones
MAX_RESPONSE = 16 * 1024 * 1024
READ_S = 10.0
_NEVER_ARRIVED = frozenset({408, 425})  # a broker answers neither; a proxy does for a while
_OF_PROXIES = frozenset({401, 403, 413, 429})  # mean the same whoever says so, in whatever words

log = structlog.get_logger(__name__)


@dataclass(frozen=True, slots=True)
class Broker:
    """Where a broker is and how to deal with it.

    Args:
        url: e.g. ``https://broker.example/orion``; a user name or password in it is refused.
        tenant: where entities live.
        ca: file of the authorities to trust, empty for those of this machine.
        timeout_s: the longest wait for an answer of one attempt.
        max_response: longest answer read, bytes.
    """

    url: str
    tenant: Tenant = field(default_factory=Tenant)
    ca: str = ""
    timeout_s: float = READ_S
    max_response: int = MAX_RESPONSE
    retry: RetryPolicy = field(default_factory=RetryPolicy)

    def __post_init__(self) -> None:
        try:
            check_address(self.url, "the broker", "give a token source")
        except BadAddress as error:
            raise BadInput(f"{error}") from error


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
        try:
            verify = trust(broker.url, broker.ca)
        except BadAddress as error:
            raise BadInput(f"{error}") from error
        self._exchange = Exchange(
            broker.url,
            broker.tenant.headers(),
            verify,
            timeout_s=broker.timeout_s,
            max_response=broker.max_response,
            connections=(20, 10),
            transport=transport,
        )

    async def close(self) -> None:
        """Close all connections, those of the token source too."""
        await self._exchange.close()
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
        pause_s = policy.pause_s(attempt, error.retry_after_s)
        if spent_s + pause_s > policy.deadline_s or not self._budget.take():
            return None
        return pause_s

    async def _with_token(self, call: Call, content: bytes | None, correlator: str) -> Reply:
        token = {} if self._tokens is None else await self._tokens.headers()
        try:
            return await self._once(call, content, correlator, token)
        except NotAllowed as error:
            # a 401 did nothing, so any request may be sent again with a new token
            if error.status != 401 or self._tokens is None or not self._tokens.refused(token):
                raise
            return await self._once(call, content, correlator, await self._tokens.headers())

    async def _once(self, call: Call, content: bytes | None, correlator: str, token: dict[str, str]) -> Reply:
        headers = {"Fiware-Correlator": correlator, **token}
        begin_s = self._mono_s()
        try:
            reply = await self._exchange.send(call.method, call.path, call.parameters, headers, content)
        except ExchangeFailed as failed:
            raise failure(failed) from failed
        log.debug("ngsi.call", method=call.method, path=call.path, status=reply.status, correlator=correlator,
                  ms=round((self._mono_s() - begin_s) * 1000))  # fmt: skip
        if reply.status >= 300:
            raise _refused(reply, correlator)
        return Reply(reply.status, reply.headers, reply.content)


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


def _refused(reply: Answer, correlator: str) -> NgsiError:
    if reply.status < 400:
        return Unreadable(f"a redirect ({reply.status}) is not followed")
    if reply.status in _NEVER_ARRIVED:
        late = NoAnswer(f"{reply.status}: the request did not get through in time")
        late.retry_after_s = asked_pause_s(reply.headers)
        return late
    is_of_proxy = False
    try:
        body = json.loads(reply.content)
        error, description = str(body["error"])[:80], str(body.get("description", ""))[:2000]
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        if reply.status not in _OF_PROXIES and reply.status < 500:
            # a proxy whose broker is away says 404 or 400 to everything: that is about no entity
            return Unreadable(f"the answer is {reply.status}, and not that of a context broker")
        error, description = f"HTTP{reply.status}", "an answer that is not NGSI-v2"
        is_of_proxy = True
    found = refusal(reply.status, error, description, correlator)
    found.is_of_proxy = is_of_proxy
    found.retry_after_s = asked_pause_s(reply.headers)
    return found


def _no_constant(text: str) -> None:
    raise ValueError(text)
