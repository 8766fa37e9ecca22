"""Pages go out compressed where the browser takes it, and whole where it does not."""

from __future__ import annotations

import httpx
import pytest
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import HTMLResponse, JSONResponse, Response, StreamingResponse
from starlette.routing import Route

from hmi.page_compression import CompressedPages

PAGE = "<p>Weeder 01 stands.</p>" * 200


async def page(_: Request) -> Response:
    return HTMLResponse(PAGE)


async def small(_: Request) -> Response:
    return HTMLResponse("<p>no</p>")


async def data(_: Request) -> Response:
    return JSONResponse({"text": PAGE})


async def streamed(_: Request) -> Response:
    return StreamingResponse((PAGE for _ in range(2)), media_type="text/html")


APP = CompressedPages(
    Starlette(routes=[Route(f"/{one.__name__}", one) for one in (page, small, data, streamed)]),
)


async def get(path: str, accepted: str) -> httpx.Response:
    async with httpx.AsyncClient(transport=httpx.ASGITransport(APP), base_url="http://farm") as client:
        return await client.get(path, headers={"accept-encoding": accepted})


@pytest.mark.parametrize(("accepted", "used"), [("gzip, deflate", "gzip"), ("gzip, deflate, br", "br")])
async def test_a_page_is_packed_and_reads_the_same(accepted: str, used: str) -> None:
    answer = await get("/page", accepted)
    assert answer.headers["content-encoding"] == used
    assert int(answer.headers["content-length"]) < len(PAGE) / 5
    assert answer.text == PAGE
    assert "accept-encoding" in answer.headers["vary"].lower()


@pytest.mark.parametrize("accepted", ["", "identity", "deflate"])
async def test_who_takes_nothing_gets_it_plain(accepted: str) -> None:
    answer = await get("/page", accepted)
    assert "content-encoding" not in answer.headers
    assert answer.text == PAGE


@pytest.mark.parametrize("path", ["/small", "/data", "/streamed"])
async def test_everything_else_passes_through(path: str) -> None:
    assert "content-encoding" not in (await get(path, "gzip, br")).headers
