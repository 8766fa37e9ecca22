"""What reaches the console: known hosts, our own pages, and writing with the CSRF token."""

from __future__ import annotations

from datetime import UTC, datetime

import pytest
from hypothesis import given
from hypothesis import strategies as st
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import PlainTextResponse
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket

from hmi.domain.role import Role
from hmi.security.cookie import cookies_in
from hmi.security.origins import Origins, is_loopback, normal_origin
from hmi.security.request_guard import Headers, RequestGuard
from hmi.security.session_info import SessionInfo
from hmi.security.socket_policy import allowed_origin
from tests.hmi.security.asgi_client import AsgiClient

BASE = "http://192.168.1.5:8080"
SESSION = SessionInfo(
    "s", "martha", "Martha Keller", Role.OPERATOR, "d", "Tablet 3", "farm", "right-token", datetime.now(UTC)
)
COOKIE = {"cookie": "headland_session=good"}
CSRF = {"x-headland-csrf": "right-token"}
OWN = {"origin": BASE}
FOREIGN = {"origin": "http://evil.example"}


def session_of(headers: Headers) -> SessionInfo | None:
    """Know one cookie."""
    return SESSION if "good" in cookies_in(headers) else None


async def answer(_request: Request) -> PlainTextResponse:
    """Say that the request got through."""
    return PlainTextResponse("through")


async def socket(websocket: WebSocket) -> None:
    """Accept whatever comes."""
    await websocket.accept()


@pytest.fixture
def client() -> AsgiClient:
    """Return a browser in front of a guarded console."""
    app = Starlette(
        routes=[
            WebSocketRoute("/{path:path}", socket),
            Route("/{path:path}", answer, methods=["GET", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"]),
        ]
    )
    return AsgiClient(RequestGuard(app, Origins(["https://farm.example"]), session_of), BASE)


def test_reading_needs_nothing(client: AsgiClient) -> None:
    assert client.get("/operate/weeder-01", headers=COOKIE).status_code == 200
    assert client.get("/api/v1/health", headers=FOREIGN).status_code == 200


@pytest.mark.parametrize("method", ["POST", "PUT", "PATCH", "DELETE"])
def test_writing_by_rest_needs_the_csrf_token(client: AsgiClient, method: str) -> None:
    path = "/api/v1/robots/weeder-01/commands"
    refused = client.request(method, path, headers=COOKIE | OWN)
    assert (refused.status_code, refused.json()["code"]) == (403, "csrf")
    assert refused.json()["text"] == "This page is out of date. Reload it and try again."
    assert client.request(method, path, headers=COOKIE | OWN | {"x-headland-csrf": "wrong"}).status_code == 403
    assert client.request(method, path, headers=COOKIE | OWN | CSRF).status_code == 200
    assert client.request(method, path, headers=COOKIE | CSRF).status_code == 200


def test_two_csrf_tokens_are_none(client: AsgiClient) -> None:
    headers = [("cookie", "headland_session=good"), ("x-headland-csrf", "right-token"), ("x-headland-csrf", "x")]
    assert client.post("/api/v1/x", headers=headers).status_code == 403


def test_without_a_session_the_handler_answers(client: AsgiClient) -> None:
    assert client.post("/api/v1/x").status_code == 200
    assert client.post("/api/v1/x", headers={"cookie": "headland_session=gone"} | OWN).status_code == 200


@pytest.mark.parametrize("path", ["/api/v1/x", "/api/v1/session", "/api/v1/stop", "/upload"])
def test_foreign_pages_cannot_write(client: AsgiClient, path: str) -> None:
    for origin in ("http://evil.example", "null", "http://192.168.1.5:8081", "https://192.168.1.5:8080", ""):
        refused = client.post(path, headers=COOKIE | CSRF | {"origin": origin})
        assert (refused.status_code, refused.json()["code"]) == (403, "foreign_origin")


def test_signing_in_and_stop_need_no_csrf_token_but_our_own_page(client: AsgiClient) -> None:
    for path in ("/api/v1/session", "/api/v1/stop"):
        assert client.post(path, headers=COOKIE | OWN).status_code == 200
        assert client.post(path, headers=COOKIE).status_code == 403
    assert client.request("DELETE", "/api/v1/session", headers=COOKIE | OWN).status_code == 403


def test_a_stop_token_needs_no_csrf_token(client: AsgiClient) -> None:
    bearer = {"authorization": "Bearer token"}
    assert client.post("/api/v1/stop", headers=COOKIE | bearer).status_code == 200
    assert client.post("/api/v1/stop", headers=COOKIE | bearer | FOREIGN).status_code == 403


def test_writing_beside_rest_needs_our_own_page(client: AsgiClient) -> None:
    assert client.post("/_nicegui/client/x/upload/1", headers=COOKIE).status_code == 403
    assert client.post("/_nicegui/client/x/upload/1", headers=COOKIE | OWN).status_code == 200


@pytest.mark.parametrize("path", ["/live", "/_nicegui_ws/socket.io/?transport=websocket"])
def test_websockets_open_for_our_own_pages_only(client: AsgiClient, path: str) -> None:
    for headers in (OWN, {"origin": "https://farm.example"}):
        assert client.opens_websocket(path, headers)
    for headers in ({}, FOREIGN, {"origin": "null"}, {"origin": "http://192.168.1.5"}):
        assert not client.opens_websocket(path, headers)


def test_the_socket_of_the_pages_is_refused_without_origin_as_plain_http_too(client: AsgiClient) -> None:
    path = "/_nicegui_ws/socket.io/?EIO=4&transport=polling"
    assert client.get(path).status_code == 403
    assert client.get(path, headers=FOREIGN).status_code == 403
    assert client.get(path, headers=OWN).status_code == 200


@pytest.mark.parametrize(
    "host",
    [
        "192.168.1.5",
        "192.168.1.5:8080",
        "[fd00::5]:8080",
        "localhost:8080",
        "farm-pc",
        "headland.local",
        "farm.example",
    ],
)
def test_known_names_are_answered(client: AsgiClient, host: str) -> None:
    assert client.get("/", headers={"host": host}).status_code == 200


@pytest.mark.parametrize(
    "host",
    [
        "evil.example",
        "farm.example.evil.example",
        "192.168.1.5.evil.example",
        "a b",
        "x:99999",
        "[fd00::5",
        "a;b",
        "x@y",
    ],
)
def test_names_that_others_could_point_at_us_are_refused(client: AsgiClient, host: str) -> None:
    refused = client.get("/", headers={"host": host})
    assert (refused.status_code, refused.json()["code"]) == (421, "unknown_host")


def test_a_page_of_a_rebound_name_cannot_open_a_socket(client: AsgiClient) -> None:
    headers = {"host": "evil.example:8080", "origin": "http://evil.example:8080"}
    assert not client.opens_websocket("/live", headers)


@pytest.mark.parametrize(
    ("origin", "normal"),
    [
        ("http://Farm-PC:80", "http://farm-pc"),
        ("https://farm.example:443", "https://farm.example"),
        ("http://[FD00::5]:8080", "http://[fd00::5]:8080"),
        ("null", None),
        ("http://x/path", None),
        ("http://user@x", None),
        ("file://x", None),
        ("http://x:port", None),
        (None, None),
    ],
)
def test_origins_have_one_form(origin: str | None, normal: str | None) -> None:
    assert normal_origin(origin) == normal


@given(st.text(max_size=60), st.text(max_size=60))
def test_no_text_makes_the_judge_fall_over(origin: str, host: str) -> None:
    origins = Origins()
    if origins.is_allowed(origin, "http", host):
        assert origins.is_known_host(host)
    is_loopback(host)


def test_a_setting_that_is_no_origin_is_refused_at_start() -> None:
    with pytest.raises(ValueError, match=r"farm\.example"):
        Origins(["farm.example"])
    assert Origins(["https://farm.example/"]).is_allowed("https://farm.example", "http", "10.0.0.1")


@pytest.mark.parametrize(("scheme", "origin"), [("wss", "https://10.0.0.1:8080"), ("ws", "http://10.0.0.1:8080")])
def test_the_pages_socket_judges_origins_itself_too(scheme: str, origin: str) -> None:
    judge = allowed_origin(Origins())
    environ = {"HTTP_HOST": "10.0.0.1:8080", "asgi.scope": {"scheme": scheme}}
    assert judge(origin, environ)
    assert not judge("http://evil.example", environ)
    assert not judge(None, environ)
