"""Static files leave compressed, cached and identical."""

from __future__ import annotations

import asyncio
import gzip
import random

import brotli
import httpx
import pytest
from starlette.types import Receive, Scope, Send

from hmi.assets import CompressedAssets

SCRIPT = b"const answer = 42;\n" * 200


class Origin:
    """Serves one script and counts how often it was asked."""

    def __init__(self) -> None:
        self.asked = 0

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        self.asked += 1
        status = 200 if scope["path"].endswith(".js") else 404
        headers = [(b"content-type", b"text/javascript")]
        await send({"type": "http.response.start", "status": status, "headers": headers})
        await send({"type": "http.response.body", "body": SCRIPT if status == 200 else b"no"})


@pytest.fixture
def origin() -> Origin:
    return Origin()


@pytest.fixture
def client(origin: Origin) -> httpx.AsyncClient:
    transport = httpx.ASGITransport(app=CompressedAssets(origin, ("/static/",)))
    return httpx.AsyncClient(transport=transport, base_url="http://test")


@pytest.mark.parametrize(("encoding", "unpack"), [("br", brotli.decompress), ("gzip", gzip.decompress)])
async def test_an_asset_is_compressed_as_the_browser_asks(client: httpx.AsyncClient, encoding: str, unpack) -> None:  # type: ignore[no-untyped-def]
    async with client, client.stream("GET", "/static/a.js", headers={"accept-encoding": encoding}) as answer:
        raw = b"".join([part async for part in answer.aiter_raw()])
    assert answer.headers["content-encoding"] == encoding
    assert len(raw) < len(SCRIPT) / 10
    assert unpack(raw) == SCRIPT


async def test_the_origin_is_asked_once_and_a_known_etag_costs_no_body(
    client: httpx.AsyncClient, origin: Origin
) -> None:
    async with client:
        first = await client.get("/static/a.js")
        again = await client.get("/static/a.js", headers={"if-none-match": first.headers["etag"]})
    assert origin.asked == 1
    assert first.content == SCRIPT
    assert "immutable" in first.headers["cache-control"]
    assert (again.status_code, again.content) == (304, b"")


async def test_a_big_asset_becomes_smaller_beside_and_reads_the_same() -> None:
    words = random.Random(1).choices(["row", "weed", "crop", "laser", "track", "field", "stop", "east"], k=40_000)
    script = "".join(f"{word}{k % 97};" for k, word in enumerate(words)).encode()

    async def origin(scope: Scope, receive: Receive, send: Send) -> None:
        headers = [(b"content-type", b"text/javascript")]
        await send({"type": "http.response.start", "status": 200, "headers": headers})
        await send({"type": "http.response.body", "body": script})

    transport = httpx.ASGITransport(app=CompressedAssets(origin, ("/static/",)))
    async with httpx.AsyncClient(transport=transport, base_url="http://test") as client:

        async def get() -> httpx.Response:
            return await client.get("/static/big.js", headers={"accept-encoding": "br"})

        first = last = await get()
        for _ in range(1000):
            if int(last.headers["content-length"]) < int(first.headers["content-length"]):
                break
            await asyncio.sleep(0.02)
            last = await get()
        else:
            pytest.fail("it never became smaller")
    assert first.content == last.content == script


async def test_a_missing_asset_stays_missing_and_is_not_cached(client: httpx.AsyncClient, origin: Origin) -> None:
    async with client:
        answers = [await client.get("/static/none.css") for _ in range(2)]
    assert [a.status_code for a in answers] == [404, 404]
    assert origin.asked == 2
    assert "cache-control" not in answers[0].headers


async def test_other_paths_pass_untouched(client: httpx.AsyncClient) -> None:
    async with client:
        answer = await client.get("/api/x.js")
    assert "content-encoding" not in answer.headers


async def test_a_browser_that_leaves_half_way_does_not_halve_the_file_for_the_next() -> None:
    async def origin(scope: Scope, receive: Receive, send: Send) -> None:
        """Serve in pieces, and stop in the middle when the browser is said to have left."""
        await receive()
        gone = asyncio.ensure_future(receive())
        headers = [(b"content-type", b"text/javascript"), (b"content-length", b"%d" % len(SCRIPT))]
        await send({"type": "http.response.start", "status": 200, "headers": headers})
        for at in range(0, len(SCRIPT), 500):
            await asyncio.sleep(0)
            if gone.done():
                break
            await send({"type": "http.response.body", "body": SCRIPT[at : at + 500], "more_body": True})
        await send({"type": "http.response.body", "body": b"", "more_body": False})
        gone.cancel()

    async def left() -> dict[str, str]:
        return {"type": "http.disconnect"}

    async def nowhere(message: object) -> None:
        pass

    assets = CompressedAssets(origin, ("/static/",))
    scope = {"type": "http", "method": "GET", "path": "/static/a.js", "query_string": b"", "headers": []}
    await assets(scope, left, nowhere)
    async with httpx.AsyncClient(transport=httpx.ASGITransport(app=assets), base_url="http://test") as client:
        assert (await client.get("/static/a.js")).content == SCRIPT
