"""One request and its answer, within limits: size, time, trust. Failures are told apart, never interpreted."""

from __future__ import annotations

import asyncio
import ssl
from collections.abc import Mapping
from dataclasses import dataclass
from urllib.parse import urlsplit

import httpx

from backend_clients.http.trouble import Trouble
from backend_clients.trust import authorities, distrust, speaks_no_tls

CONNECT_S = 3.0
MAX_REASON = 200
NO_TLS = "Check whether the address begins with http or with https."


class ExchangeFailed(Exception):
    """No answer that can be used.

    Args:
        trouble: ``UNREACHABLE``, ``SILENT``, ``UNTRUSTED`` or ``NOT_UNDERSTOOD``.
        has_left: the request may have arrived.
        is_too_long: the answer was longer than the limit; the rest was not read.
        mend: what mends it, empty if only the kind is known.
    """

    def __init__(
        self, trouble: Trouble, text: str, *, has_left: bool = False, is_too_long: bool = False, mend: str = ""
    ) -> None:
        super().__init__(text)
        self.trouble, self.has_left, self.is_too_long, self.mend = trouble, has_left, is_too_long, mend


class BadAddress(ValueError):
    """An address, or a file of authorities, that nothing can be sent with; the text never shows what is secret."""


@dataclass(frozen=True, slots=True)
class Answer:
    """What came, whatever its status."""

    status: int
    headers: httpx.Headers
    content: bytes


class Exchange:
    """Sends single requests to one service; knows no retries.

    Args:
        url: of the service.
        headers: of every request.
        verify: whom to trust, see ``trust``.
        timeout_s: the longest wait for a whole answer.
        max_response: longest answer read, bytes.
        connections: most of them at a time, and how many are kept open.
        transport: test seam, as in httpx.
    """

    def __init__(
        self,
        url: str,
        headers: Mapping[str, str],
        verify: ssl.SSLContext | bool,
        *,
        timeout_s: float,
        max_response: int,
        connections: tuple[int, int],
        transport: httpx.AsyncBaseTransport | None = None,
    ) -> None:
        self._timeout_s, self._max_response = timeout_s, max_response
        self._client = httpx.AsyncClient(
            base_url=url.rstrip("/") + "/",
            # identity, since a small compressed answer can be a large one
            headers={**headers, "Accept": "application/json", "Accept-Encoding": "identity"},
            timeout=httpx.Timeout(timeout_s, connect=min(CONNECT_S, timeout_s)),
            verify=verify,
            follow_redirects=False,  # a redirect would carry the token elsewhere
            trust_env=False,
            transport=transport,
            limits=httpx.Limits(max_connections=connections[0], max_keepalive_connections=connections[1]),
        )

    async def close(self) -> None:
        """Close all connections."""
        await self._client.aclose()

    async def send(
        self, method: str, path: str, parameters: Mapping[str, str], headers: Mapping[str, str], content: bytes | None
    ) -> Answer:
        """Return the answer to one request.

        Args:
            path: below the service's address, or a whole address; already encoded.
            content: a body, JSON unless ``headers`` say otherwise.

        Raises:
            ExchangeFailed: nothing usable came.
        """
        # never a content type without a body: Orion refuses it on GET and DELETE
        own = {"Content-Type": "application/json", **headers} if content is not None else dict(headers)
        request = self._client.build_request(
            method, path, params=dict(parameters) or None, content=content, headers=own
        )
        what = f"{method} {request.url.path}"
        try:
            async with asyncio.timeout(self._timeout_s):  # a byte now and then must not hold a call for ever
                response = await self._client.send(request, stream=True)
                try:
                    return Answer(response.status_code, response.headers, await self._read(response, what))
                finally:
                    await response.aclose()
        except (httpx.HTTPError, TimeoutError) as error:
            raise _failed(error, what, self._timeout_s) from error

    async def _read(self, response: httpx.Response, what: str) -> bytes:
        if response.headers.get("content-encoding", "identity") != "identity":
            text = f"{what}: the answer is compressed although nobody asked for it"
            raise ExchangeFailed(Trouble.NOT_UNDERSTOOD, text, has_left=True)
        content = bytearray()
        async for piece in response.aiter_bytes():
            content += piece
            if len(content) > self._max_response:
                text = f"{what}: more than {self._max_response} bytes"
                raise ExchangeFailed(Trouble.NOT_UNDERSTOOD, text, has_left=True, is_too_long=True)
        return bytes(content)


def check_address(url: str, what: str, credentials: str) -> None:
    """Return if ``url`` can be an address of a service; raises ``BadAddress``.

    Args:
        what: names the service in the text.
        credentials: says where they belong, since the address is no place for them.
    """
    try:
        parts = urlsplit(url)
        is_usable = parts.scheme in ("http", "https") and bool(parts.hostname) and parts.port != 0
    except ValueError as error:
        raise BadAddress(f"the address of {what} is no http or https URL") from error
    if not is_usable or parts.query or parts.fragment:
        raise BadAddress(f"the address of {what} is no http or https URL")
    if parts.username is not None or parts.password is not None:
        raise BadAddress(f"credentials do not belong in the address of {what}; {credentials}")


def trust(url: str, ca: str, *, is_ca_alone: bool = True) -> ssl.SSLContext | bool:
    """Return whom to trust at an address; raises ``BadAddress`` for a file that holds no authority.

    Args:
        ca: file of authorities, empty for those of this machine.
        is_ca_alone: those of this machine do not count beside the file.
    """
    if not url.startswith("https:"):
        return False  # loading the authorities takes 30 ms and more, for nothing without TLS
    if not ca:
        return authorities()
    try:
        context = ssl.create_default_context(cafile=ca)
        if not is_ca_alone:
            context.load_default_certs()
    except OSError as error:  # an SSLError is one, too
        raise BadAddress(f"no file of authorities: {ca}") from error
    return context


def reason(error: Exception) -> str:
    """Return what a library said of a failure, shortened."""
    return f"{type(error).__name__} {error}".strip()[:MAX_REASON]


def _failed(error: httpx.HTTPError | TimeoutError, what: str, timeout_s: float) -> ExchangeFailed:
    if isinstance(error, httpx.ConnectError | httpx.ConnectTimeout | httpx.PoolTimeout):
        why = distrust(error)
        if why is not None:
            return ExchangeFailed(Trouble.UNTRUSTED, f"{what}: {why.text}", mend=why.mend)
        mend = NO_TLS if speaks_no_tls(error) else ""
        return ExchangeFailed(Trouble.UNREACHABLE, f"{what}: no connection: {reason(error)}", mend=mend)
    if isinstance(error, httpx.TimeoutException | TimeoutError):
        return ExchangeFailed(Trouble.SILENT, f"{what}: no answer in {timeout_s:g} s", has_left=True)
    if isinstance(error, httpx.DecodingError):
        return ExchangeFailed(Trouble.NOT_UNDERSTOOD, f"{what}: the answer cannot be decoded", has_left=True)
    return ExchangeFailed(Trouble.UNREACHABLE, f"{what}: {reason(error)}", has_left=True)
