"""Every route and every role: who may, who may not, and that no route is forgotten."""

from __future__ import annotations

from typing import Any

import httpx
import pytest

from hmi.domain.role import Permission, Role, may
from tests.hmi.api.console import Console

P = Permission
NEW_ROBOT = {"id": "weeder-09", "name": "Weeder 09", "family": "weeder"}
NEW_USER = {"name": "Piet Bos", "role": "viewer", "password": "a long enough one"}
RESET = {"reset_id": "reset-00000001", "stop_ids": ["stop-00000001"], "reason": "Test", "tick": "x"}

NODE_ORDER = {"command_id": "command-node", "tick": "x"}


def command(action: str) -> dict[str, Any]:
    """Return the body of a command."""
    return {"command_id": f"command-{action}", "action": action, "tick": "x"}


def lease(op: str) -> dict[str, Any]:
    """Return the body of a lease operation."""
    return {"op": op, "tick": "x", "reason": "needed"}


ROUTES: list[tuple[str, str, dict[str, Any] | None, Permission | None]] = [
    ("GET", "/session", None, P.WATCH),
    ("POST", "/devices", {"name": "Tablet 9"}, P.ENROL_DEVICE),
    ("GET", "/devices", None, P.ENROL_DEVICE),
    ("DELETE", "/devices/tablet-9", None, P.MANAGE_USERS),
    ("GET", "/robots", None, P.WATCH),
    ("GET", "/robots/new", None, P.WATCH),
    ("GET", "/robots/weeder-01", None, P.WATCH),
    ("POST", "/robots", NEW_ROBOT, P.MANAGE_ROBOTS),
    ("GET", "/robots/weeder-01/chart", None, P.WATCH),
    ("GET", "/robots/weeder-01/state-times", None, P.WATCH),
    ("GET", "/robots/weeder-01/state-times.csv", None, P.WATCH),
    ("GET", "/robots/weeder-01/transitions", None, P.WATCH),
    ("PATCH", "/robots/weeder-01", {"name": "Weeder One"}, P.MANAGE_ROBOTS),
    ("POST", "/robots/weeder-01/commands", command("start"), P.START),
    ("POST", "/robots/weeder-01/commands", command("resume"), P.RESUME),
    ("POST", "/robots/weeder-01/commands", command("pause"), P.PAUSE),
    ("POST", "/robots/weeder-01/commands", command("abort"), P.ABORT),
    ("POST", "/robots/weeder-01/commands", command("return_home"), P.RETURN_HOME),
    ("POST", "/robots/weeder-01/commands", command("drive_open"), P.DRIVE),
    ("POST", "/robots/weeder-01/commands", command("drive_close"), P.DRIVE),
    ("POST", "/robots/weeder-01/commands", {**command("go_to"), "place": [1.0, 2.0, 0.0]}, P.GO_TO),
    ("POST", "/robots/weeder-01/commands", command("tool_retract"), P.TOOL),
    ("POST", "/robots/weeder-01/commands", {**command("tool_go_to"), "place": [1.0, 2.0, 0.0]}, P.TOOL),
    ("POST", "/robots/weeder-01/commands", command("skip_target"), P.TOOL),
    ("POST", "/robots/weeder-01/commands", command("stock_refilled"), P.TOOL),
    ("POST", "/robots/weeder-01/commands", {**command("node_stop"), "node": "gnss"}, P.MANAGE_NODES),
    ("GET", "/robots/weeder-01/nodes", None, P.WATCH),
    ("GET", "/robots/weeder-01/functions", None, P.WATCH),
    ("POST", "/robots/weeder-01/nodes/gnss/start", NODE_ORDER, P.MANAGE_NODES),
    ("POST", "/robots/weeder-01/nodes/gnss/stop", NODE_ORDER, P.MANAGE_NODES),
    ("POST", "/robots/weeder-01/nodes/gnss/restart", NODE_ORDER, P.MANAGE_NODES),
    ("GET", "/robots/weeder-01/logs", None, P.READ_LOGS),
    ("POST", "/robots/weeder-01/lease", lease("request"), P.LEASE),
    ("POST", "/robots/weeder-01/lease", lease("release"), P.LEASE),
    ("POST", "/robots/weeder-01/lease", lease("grant"), P.LEASE),
    ("POST", "/robots/weeder-01/lease", lease("keep"), P.LEASE),
    ("POST", "/robots/weeder-01/lease", lease("take"), P.TAKE_LEASE),
    ("POST", "/robots/weeder-01/stop-reset", RESET, P.RESET),
    ("POST", "/robots/weeder-01/seen", {"stop_id": "stop-00000001"}, P.WATCH),
    ("POST", "/robots/weeder-01/mission", {"mission_id": "field-1"}, P.SEND_MISSION),
    ("POST", "/stop", {"stop_id": "stop-00000001", "robots": "all"}, P.STOP),
    ("GET", "/stop/stop-00000001", None, P.STOP),
    ("GET", "/events", None, P.WATCH),
    ("GET", "/history/weeder-01", None, P.WATCH),
    ("GET", "/history/weeder-01/track", None, P.WATCH),
    ("GET", "/audit", None, P.READ_AUDIT),
    ("GET", "/audit/verify", None, P.READ_AUDIT),
    ("GET", "/diagnostics", None, P.READ_DIAGNOSTICS),
    ("GET", "/users", None, P.MANAGE_USERS),
    ("POST", "/users", NEW_USER, P.MANAGE_USERS),
    ("PATCH", "/users/viewer", {"name": "Vera Lang"}, P.MANAGE_USERS),
    ("DELETE", "/robots/weeder-01", None, P.MANAGE_ROBOTS),
    ("DELETE", "/session", None, P.WATCH),
]
OPEN = {("GET", "/health"), ("POST", "/session"), ("GET", "/people")}


async def call(client: httpx.AsyncClient, method: str, path: str, body: dict[str, Any] | None) -> httpx.Response:
    """Call one route."""
    return await client.request(method, path, json=body)


@pytest.mark.parametrize("role", list(Role))
async def test_each_role_may_exactly_what_the_table_says(console: Console, role: Role) -> None:
    client = await console.browser(role)
    wrong = []
    for method, path, body, permission in ROUTES:
        answer = await call(client, method, path, body)
        is_refused = answer.status_code == 403 and answer.json()["code"] == "not_allowed"
        if permission is not None and is_refused == may(role, permission):
            wrong.append((method, path, body, answer.status_code, answer.text))
        if answer.status_code in (401, 500):
            wrong.append((method, path, body, answer.status_code, answer.text))
    assert wrong == []


async def test_nobody_gets_anywhere_without_signing_in(console: Console) -> None:
    client = console.client()
    for method, path, body, _permission in ROUTES:
        answer = await call(client, method, path, body)
        assert (answer.status_code, answer.json()["code"]) == (401, "not_signed_in"), (method, path)


async def test_nobody_gets_anywhere_with_a_cookie_of_before(console: Console) -> None:
    cookie, session = await console.session(Role.ADMIN)
    client = console.client(cookie, session)
    await console.sessions.end(session.session_id)
    for method, path, body, _permission in ROUTES:
        answer = await call(client, method, path, body)
        assert answer.status_code == 401, (method, path)


async def test_nothing_is_changed_without_the_csrf_token(console: Console) -> None:
    cookie, session = await console.session(Role.ADMIN)
    client = console.client(cookie, session)
    client.headers["x-headland-csrf"] = "wrong"
    for method, path, body, _permission in ROUTES:
        if method == "GET" or path == "/stop":
            continue
        answer = await call(client, method, path, body)
        assert (answer.status_code, answer.json()["code"]) == (403, "csrf"), (method, path)


async def test_every_route_is_in_the_table(console: Console) -> None:
    paths = console.api.openapi()["paths"]
    known = {(method.upper(), path) for path, methods in paths.items() for method in methods}
    named = {"weeder-01": "{robot_id}", "tablet-9": "{device_id}", "viewer": "{user_id}", "stop-00000001": "{stop_id}"}

    def pattern(path: str) -> str:
        if "/nodes/gnss/" in path:
            return "/robots/{robot_id}/nodes/{name}/{act}"
        return "/".join(named.get(part, part) for part in path.split("/"))

    assert known == {(method, pattern(path)) for method, path, _, _ in ROUTES} | OPEN
