"""Static files, compressed once: brotli or gzip from memory, cached by the browser for good.

Compressing cold assets on every request blocks the event loop for about 50 ms each, which every live value and every
second path of STOP would feel. Here each asset is compressed once, in a thread, and then handed out as bytes.
"""

from __future__ import annotations

import asyncio
import gzip
import hashlib
from dataclasses import dataclass

import brotli
from starlette.datastructures import Headers
from starlette.types import ASGIApp, Message, Receive, Scope, Send

BROTLI_QUALITY = 9  # what the first browser gets
BROTLI_BEST = 10  # 5 % fewer bytes for ten times the work, done beside; 11 takes twice as long again for 1 %
WORTH_IT_BYTES = 8000
MIN_COMPRESSED_BYTES = 600
MAX_CACHED_BYTES = 96 * 1024 * 1024
IMMUTABLE = b"public, max-age=31536000, immutable"
COMPRESSIBLE = ("text/", "application/javascript", "application/json", "image/svg+xml", "application/manifest+json")


@dataclass(frozen=True, slots=True)
class Asset:
    """One file as it goes out; ``bodies`` by content encoding, ``""`` is the plain one."""

    content_type: bytes
    etag: bytes
    bodies: dict[str, bytes]


class CompressedAssets:
    """ASGI middleware that answers GET and HEAD below ``prefixes`` from memory.

    Only answers with status 200 are kept. Paths below the prefixes must name immutable content: they carry a version.
    """

    def __init__(self, app: ASGIApp, prefixes: tuple[str, ...], *, excluded: tuple[str, ...] = ()) -> None:
        self._app = app
        self._prefixes = prefixes
        self._excluded = excluded
        self._assets: dict[str, Asset] = {}
        self._bytes = 0
        self._one_at_a_time = asyncio.Lock()
        self._improving: set[asyncio.Task[None]] = set()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve from memory, or fetch from the inner app once."""
        if not self._is_asset(scope):
            await self._app(scope, receive, send)
            return
        key = f"{scope['path']}?{scope['query_string'].decode('latin-1')}"
        asset = self._assets.get(key)
        if asset is None:
            fetched = await self._fetch(scope)
            if fetched[0]["status"] != 200 or not _is_whole(fetched):
                for message in fetched:
                    await send(message)
                return
            asset = await asyncio.to_thread(_compress, fetched)
            if self._keep(key, asset) and len(asset.bodies.get("br", b"")) > WORTH_IT_BYTES:
                task = asyncio.create_task(self._improve(asset), name="improve-asset")
                self._improving.add(task)
                task.add_done_callback(self._improving.discard)
        await _answer(scope, asset, send)

    def _is_asset(self, scope: Scope) -> bool:
        if scope["type"] != "http" or scope["method"] not in ("GET", "HEAD"):
            return False
        path: str = scope["path"]
        if not path.startswith(self._prefixes) or path.startswith(self._excluded or ("\0",)):
            return False
        return "range" not in Headers(scope=scope)

    async def _fetch(self, scope: Scope) -> list[Message]:
        """Fetch a whole file, though the browser that asked for it first may leave meanwhile.

        Told of a leaving browser, the inner app would stop in the middle, and every later one would get that half.
        """
        plain = [(k, v) for k, v in scope["headers"] if k not in (b"accept-encoding", b"if-none-match")]
        messages: list[Message] = []

        async def collect(message: Message) -> None:
            messages.append(message)

        await self._app({**scope, "method": "GET", "headers": plain}, _never_leaves(), collect)
        return messages

    async def _improve(self, asset: Asset) -> None:
        async with self._one_at_a_time:
            asset.bodies["br"] = await asyncio.to_thread(brotli.compress, asset.bodies[""], quality=BROTLI_BEST)

    def _keep(self, key: str, asset: Asset) -> bool:
        size = sum(map(len, asset.bodies.values()))
        if key in self._assets or self._bytes + size > MAX_CACHED_BYTES:
            return False
        self._assets[key] = asset
        self._bytes += size
        return True


def _never_leaves() -> Receive:
    """Return the receiving side of a request without a body whose browser stays."""
    is_first = True

    async def receive() -> Message:
        nonlocal is_first
        if is_first:
            is_first = False
            return {"type": "http.request", "body": b"", "more_body": False}
        message: Message = await asyncio.get_running_loop().create_future()  # cancelled with the request at the latest
        return message

    return receive


def _is_whole(messages: list[Message]) -> bool:
    """Say whether a file came to its end: what is kept for good must be all of it."""
    promised = dict(messages[0]["headers"]).get(b"content-length")
    length = sum(len(m.get("body", b"")) for m in messages[1:])
    return not messages[-1].get("more_body", False) and promised in (None, b"%d" % length)


def _compress(messages: list[Message]) -> Asset:
    headers = dict(messages[0]["headers"])
    body = b"".join(m.get("body", b"") for m in messages[1:])
    content_type: bytes = headers.get(b"content-type", b"application/octet-stream")
    bodies = {"": body}
    if len(body) >= MIN_COMPRESSED_BYTES and content_type.decode("latin-1").startswith(COMPRESSIBLE):
        bodies["br"] = brotli.compress(body, quality=BROTLI_QUALITY)
        bodies["gzip"] = gzip.compress(body, compresslevel=9, mtime=0)
    etag = b'"' + hashlib.sha256(body).hexdigest()[:24].encode() + b'"'
    return Asset(content_type, etag, bodies)


async def _answer(scope: Scope, asset: Asset, send: Send) -> None:
    request = Headers(scope=scope)
    headers = [(b"content-type", asset.content_type), (b"etag", asset.etag), (b"cache-control", IMMUTABLE)]
    headers.append((b"vary", b"accept-encoding"))
    if request.get("if-none-match", "").encode("latin-1") == asset.etag:
        await send({"type": "http.response.start", "status": 304, "headers": headers})
        await send({"type": "http.response.body", "body": b""})
        return
    accepted = {part.split(";")[0].strip() for part in request.get("accept-encoding", "").split(",")}
    encoding = next((e for e in ("br", "gzip") if e in accepted and e in asset.bodies), "")
    body = asset.bodies[encoding]
    if encoding:
        headers.append((b"content-encoding", encoding.encode()))
    headers.append((b"content-length", str(len(body)).encode()))
    await send({"type": "http.response.start", "status": 200, "headers": headers})
    await send({"type": "http.response.body", "body": b"" if scope["method"] == "HEAD" else body})
