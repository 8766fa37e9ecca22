"""Security headers on every answer; pages also get a policy with a fresh nonce.

Pure ASGI. Only pages (``text/html``) are held back until they are whole; everything else passes straight through.
"""

from __future__ import annotations

import logging
import zlib
from collections.abc import Callable

from starlette.types import ASGIApp, Message, Receive, Scope, Send

from hmi.security.content_policy import (
    DOCUMENT_POLICY,
    VIEWER_PATH,
    new_nonce,
    page_policy,
    viewer_policy,
    with_nonce,
)
from hmi.security.origins import is_loopback

logger = logging.getLogger(__name__)
Headers = list[tuple[bytes, bytes]]

_ALWAYS: Headers = [
    (b"x-content-type-options", b"nosniff"),
    (b"cross-origin-resource-policy", b"same-origin"),
]
# They speak to documents only; on each of sixty files they would cost a cold page 10 KB.
_ON_PAGES: Headers = [
    (b"referrer-policy", b"same-origin"),
    (
        b"permissions-policy",
        b"camera=(), microphone=(), payment=(), usb=(), geolocation=(self), screen-wake-lock=(self), fullscreen=(self)",
    ),
]
_HSTS = (b"strict-transport-security", b"max-age=31536000")
_OPENER = (b"cross-origin-opener-policy", b"same-origin")
_DOCUMENTS = (b"image/svg+xml", b"text/xml", b"application/xml", b"application/xhtml+xml")
_GZIP = 16 + zlib.MAX_WBITS


class ResponseHeaders:
    """Adds the headers.

    Args:
        app: what is protected; anything that compresses pages is best put outside of this.
        stop_url_of: returns the public address of the STOP gateway for the ``Host`` of a request.
        tiles_origin: the server of the online map, if an admin has set one.
    """

    def __init__(self, app: ASGIApp, stop_url_of: Callable[[str], str | None], tiles_origin: str | None = None) -> None:
        self._app = app
        self._policy = lambda nonce, host: page_policy(nonce, host, stop_url_of(host), tiles_origin)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on and amend the answer."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        await self._app(scope, receive, _Answer(scope, send, self._policy))


class _Answer:
    """The ``send`` of one request."""

    def __init__(self, scope: Scope, send: Send, policy: Callable[[str, str], str]) -> None:
        self._scope = scope
        self._send = send
        self._policy = policy
        self._start: Message | None = None
        self._page: list[bytes] = []

    async def __call__(self, message: Message) -> None:
        if message["type"] == "http.response.start":
            await self._begin(message)
        elif message["type"] == "http.response.body" and self._start is not None:
            await self._hold(self._start, message)
        else:
            await self._send(message)

    async def _begin(self, message: Message) -> None:
        headers: Headers = list(message["headers"])
        kind = _value(headers, b"content-type").partition(b";")[0].strip().lower()
        present = {name.lower() for name, _ in headers}
        added = _ALWAYS + _ON_PAGES if kind == b"text/html" or kind in _DOCUMENTS else _ALWAYS
        headers += [header for header in added if header[0] not in present]
        if self._scope["scheme"] == "https":
            headers.append(_HSTS)
        if kind in _DOCUMENTS and b"content-security-policy" not in present:
            headers.append((b"content-security-policy", DOCUMENT_POLICY.encode()))
        if kind == b"application/json" and b"cache-control" not in present:
            headers.append((b"cache-control", b"no-store"))
        message = {**message, "headers": headers}
        if kind == b"text/html":
            self._start = message
        else:
            await self._send(message)

    async def _hold(self, start: Message, message: Message) -> None:
        self._page.append(message.get("body", b""))
        if message.get("more_body", False):
            return
        nonce = new_nonce()
        headers, body = start["headers"], b"".join(self._page)
        body = _rewritten(_value(headers, b"content-encoding").lower(), body, nonce)
        self._start = None
        await self._send({**start, "headers": self._page_headers(headers, nonce, len(body))})
        await self._send({"type": "http.response.body", "body": body})

    def _page_headers(self, headers: Headers, nonce: str, length: int) -> Headers:
        host = _value(self._scope["headers"], b"host").decode("latin-1")
        is_viewer = self._scope["path"].startswith(VIEWER_PATH)
        policy = viewer_policy(nonce, host) if is_viewer else self._policy(nonce, host)
        replaced = {b"content-length", b"content-security-policy", b"cache-control", b"etag"}
        is_body_known = self._scope["method"] != "HEAD"
        kept = [header for header in headers if header[0].lower() not in replaced]
        kept += [(b"content-security-policy", policy.encode("latin-1")), (b"cache-control", b"no-store")]
        if is_body_known:
            kept.append((b"content-length", str(length).encode()))
        # Browsers complain about this header where they do not honour it: on plain HTTP in the network.
        if self._scope["scheme"] == "https" or is_loopback(host):
            kept.append(_OPENER)
        return kept


def _rewritten(encoding: bytes, body: bytes, nonce: str) -> bytes:
    if encoding in (b"", b"identity"):
        return with_nonce(body, nonce)
    if encoding == b"gzip":
        page = with_nonce(zlib.decompress(body, _GZIP), nonce)
        packer = zlib.compressobj(5, wbits=_GZIP)
        return packer.compress(page) + packer.flush()
    logger.error("a page came as %s: its scripts got no nonce and will not run", encoding.decode("latin-1"))
    return body


def _value(headers: Headers, name: bytes) -> bytes:
    return next((value for key, value in headers if key.lower() == name), b"")
