"""Answers: the policy with its nonce in every script tag, and the other headers."""

from __future__ import annotations

import re
from collections.abc import AsyncIterator

import pytest
from hypothesis import given
from hypothesis import strategies as st
from starlette.applications import Starlette
from starlette.middleware.gzip import GZipMiddleware
from starlette.requests import Request
from starlette.responses import HTMLResponse, JSONResponse, Response, StreamingResponse
from starlette.routing import Route
from starlette.types import ASGIApp

from hmi.security.content_policy import with_nonce
from hmi.security.response_headers import ResponseHeaders
from tests.hmi.security.asgi_client import AsgiClient

PAGE = """<!doctype html><html><head>
<script type="importmap">{"imports": {}}</script>
<!-- <script>alert("in a comment")</script> -->
<SCRIPT nonce="old" defer src="/a.js"></SCRIPT>
</head><body><script>const s = "<script>";</script><p>äöü</p></body></html>"""


async def page(_request: Request) -> HTMLResponse:
    """Answer with a page."""
    return HTMLResponse(PAGE, headers={"etag": "x", "cache-control": "max-age=60"})


async def slow(_request: Request) -> StreamingResponse:
    """Answer with a page in pieces that cut tags in two."""

    async def pieces() -> AsyncIterator[str]:
        for index in range(0, len(PAGE), 7):
            yield PAGE[index : index + 7]

    return StreamingResponse(pieces(), media_type="text/html")


async def values(_request: Request) -> JSONResponse:
    """Answer with JSON."""
    return JSONResponse({"a": 1})


async def picture(_request: Request) -> Response:
    """Answer with an SVG."""
    return Response("<svg/>", media_type="image/svg+xml")


ROUTES = [Route("/", page), Route("/slow", slow), Route("/json", values), Route("/svg", picture)]


def stop_url(host: str) -> str | None:
    """Name the gateway as the settings would."""
    return f"http://{host.split(':')[0]}:8081" if host.startswith("192.") else "https://farm.example/stop"


def browser(base_url: str = "http://192.168.1.5:8080", *, compressed: bool = False) -> AsgiClient:
    """Return a browser in front of pages with headers."""
    app: ASGIApp = Starlette(routes=ROUTES)
    if compressed:
        app = GZipMiddleware(app, minimum_size=1)
    return AsgiClient(ResponseHeaders(app, stop_url), base_url)


@pytest.fixture
def client() -> AsgiClient:
    """Return a browser on the local network."""
    return browser()


def nonce_of(response_policy: str) -> str:
    """Return the nonce of a policy."""
    match = re.search(r"'nonce-([^']+)'", response_policy)
    assert match
    return match[1]


@pytest.mark.parametrize("path", ["/", "/slow"])
@pytest.mark.parametrize("compressed", [False, True])
def test_every_script_tag_carries_the_nonce_of_the_policy(path: str, compressed: bool) -> None:
    response = browser(compressed=compressed).get(path)
    nonce = nonce_of(response.headers["content-security-policy"])
    assert response.text == (
        PAGE.replace('<script type="importmap">', f'<script nonce="{nonce}" type="importmap">')
        .replace('<SCRIPT nonce="old" defer', f'<SCRIPT nonce="{nonce}" defer')
        .replace("<body><script>", f'<body><script nonce="{nonce}">')
    )


def test_every_page_has_a_nonce_of_its_own_and_is_not_kept(client: AsgiClient) -> None:
    first, second = client.get("/"), client.get("/")
    assert nonce_of(first.headers["content-security-policy"]) != nonce_of(second.headers["content-security-policy"])
    assert first.headers["cache-control"] == "no-store"
    assert "etag" not in first.headers
    assert int(first.headers["content-length"]) == len(first.content)


def test_the_policy_is_strict_and_names_the_stop_gateway(client: AsgiClient) -> None:
    policy = client.get("/").headers["content-security-policy"]
    parts = dict(part.split(" ", 1) for part in policy.split("; "))
    assert parts["default-src"] == "'self'"
    assert "'unsafe-inline'" not in parts["script-src"]
    assert parts["script-src-attr"] == parts["object-src"] == parts["base-uri"] == "'none'"
    assert parts["frame-ancestors"] == "'self'"
    assert parts["worker-src"] == "'self' blob:"
    assert parts["connect-src"].split() == [
        "'self'", "ws://192.168.1.5:8080", "wss://192.168.1.5:8080", "http://192.168.1.5:8081", "ws://192.168.1.5:8081",
    ]  # fmt: skip


def test_an_online_map_opens_pictures_and_fetches_of_one_origin_and_nothing_else() -> None:
    def parts_of(tiles: str | None) -> dict[str, str]:
        client = AsgiClient(ResponseHeaders(Starlette(routes=ROUTES), stop_url, tiles), "http://192.168.1.5:8080")
        return dict(part.split(" ", 1) for part in client.get("/").headers["content-security-policy"].split("; "))

    closed, opened = parts_of(None), parts_of("https://tiles.example")
    for name in ("img-src", "connect-src"):
        assert opened.pop(name) == f"{closed.pop(name)} https://tiles.example"
    assert {k: v for k, v in opened.items() if k != "script-src"} == {
        k: v for k, v in closed.items() if k != "script-src"
    }
    assert "tiles.example" not in opened["script-src"]


def test_behind_a_proxy_the_gateways_path_is_not_part_of_the_policy() -> None:
    policy = browser("https://farm.example").get("/").headers["content-security-policy"]
    assert "https://farm.example wss://farm.example;" in policy


def test_every_answer_carries_the_plain_headers(client: AsgiClient) -> None:
    for path in ("/", "/json", "/svg", "/missing"):
        headers = client.get(path).headers
        assert headers["x-content-type-options"] == "nosniff"
        assert headers["cross-origin-resource-policy"] == "same-origin"
        is_document = path in ("/", "/svg")
        assert headers.get("referrer-policy") == ("same-origin" if is_document else None)
        assert ("geolocation=(self)" in headers.get("permissions-policy", "")) is is_document
        assert "strict-transport-security" not in headers
    assert client.get("/json").headers["cache-control"] == "no-store"
    assert "content-security-policy" not in client.get("/json").headers


def test_nothing_runs_in_a_picture_that_is_opened_like_a_page(client: AsgiClient) -> None:
    assert "sandbox" in client.get("/svg").headers["content-security-policy"]


@pytest.mark.parametrize(
    ("base_url", "has_hsts", "has_opener"),
    [
        ("https://192.168.1.5:8080", True, True),
        ("http://127.0.0.1:8080", False, True),
        ("http://localhost:8080", False, True),
        ("http://192.168.1.5:8080", False, False),
    ],
)
def test_headers_for_secure_contexts_are_sent_where_browsers_honour_them(
    base_url: str, has_hsts: bool, has_opener: bool
) -> None:
    headers = browser(base_url).get("/").headers
    assert ("strict-transport-security" in headers) == has_hsts
    assert ("cross-origin-opener-policy" in headers) == has_opener


def test_a_head_request_gets_the_headers_of_the_page(client: AsgiClient) -> None:
    response = client.request("HEAD", "/")
    assert response.status_code == 200
    assert "content-security-policy" in response.headers


@given(st.binary(max_size=300))
def test_a_page_is_changed_by_nonces_only(html: bytes) -> None:
    assert with_nonce(html, "N").replace(b' nonce="N"', b"") == with_nonce(html, "M").replace(b' nonce="M"', b"")


@given(st.text(alphabet="ab<>!-/ \n", max_size=40))
def test_text_without_scripts_is_left_alone(text: str) -> None:
    assert with_nonce(text.encode(), "N") == text.encode()
