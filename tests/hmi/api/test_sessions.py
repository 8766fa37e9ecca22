"""Signing in by REST, enrolled tablets, people."""

from __future__ import annotations

from typing import Any

from hmi.domain.role import Role
from tests.hmi.api.console import PASSWORD, Console


async def enrolled(console: Console) -> tuple[Any, str]:
    """Enrol a tablet; return its browser and its stop token."""
    client = await console.browser(Role.OPERATOR)
    answer = await client.post("/devices", json={"name": "  Tablet   3 "})
    assert answer.status_code == 201
    assert answer.json()["name"] == "Tablet 3"
    return client, answer.json()["stop_token"]


async def test_signing_in_gives_a_cookie_rights_and_a_stop_token(console: Console) -> None:
    await console.session(Role.OPERATOR)
    client = console.client()
    answer = await client.post("/session", json={"name": "Operator", "password": PASSWORD})
    body = answer.json()
    assert answer.status_code == 200
    assert body["user"] == {"id": "operator", "name": "Martha Keller", "role": "operator"}
    assert "drive" in body["rights"]
    assert "manage_users" not in body["rights"]
    cookie = answer.headers["set-cookie"]
    assert "HttpOnly" in cookie
    assert "SameSite=Lax" in cookie
    assert "Secure" not in cookie
    who = await client.get("/session")
    assert who.json()["csrf"] == body["csrf"]
    assert console.tokens.read_stop_token(body["stop_token"]).user_id == "operator"


async def test_over_https_the_cookie_is_for_https_only(console: Console) -> None:
    await console.session(Role.OPERATOR)
    client = console.client()
    answer = await client.post("https://console.local/api/v1/session", json={"name": "operator", "password": PASSWORD})
    assert "; Secure" in answer.headers["set-cookie"]


async def test_a_wrong_password_is_refused_and_many_make_one_wait(console: Console) -> None:
    await console.session(Role.OPERATOR)
    client = console.client()
    body = {"name": "operator", "password": "not this one"}
    first = await client.post("/session", json=body)
    assert (first.status_code, first.json()["code"]) == (401, "wrong_credentials")
    assert "set-cookie" not in first.headers
    answers = [await client.post("/session", json=body) for _ in range(12)]
    blocked = answers[-1]
    assert (blocked.status_code, blocked.json()["code"]) == (429, "too_many_tries")
    assert int(blocked.headers["retry-after"]) >= 1


async def test_a_password_or_a_pin_is_needed_not_both(console: Console) -> None:
    client = console.client()
    for body in ({"name": "operator"}, {"name": "operator", "password": "x", "pin": "1111"}):
        assert (await client.post("/session", json=body)).status_code == 422


async def test_signing_out_ends_the_session_and_gives_back_control(console: Console) -> None:
    client = await console.browser(Role.OPERATOR)
    gone = await client.delete("/session")
    assert gone.json() == {"stop_token": ""}
    assert "Max-Age=0" in gone.headers["set-cookie"]
    assert (await client.get("/session")).status_code == 401


async def test_an_enrolled_tablet_signs_people_in_by_pin(console: Console) -> None:
    _, token = await enrolled(console)
    await console.accounts.set_pin("operator", "4711", by="test")
    tablet = console.client()
    people = await tablet.get("/people", headers={"X-Headland-Stop-Token": token})
    assert people.json() == {
        "people": [{"id": "operator", "name": "Martha Keller", "role": "operator"}],
        "device": {"name": "Tablet 3"},
    }
    answer = await tablet.post("/session", json={"name": "operator", "pin": "4711", "stop_token": token})
    assert answer.json()["device"]["name"] == "Tablet 3"


async def test_a_browser_that_is_no_tablet_sees_nobody_and_takes_no_pin(console: Console) -> None:
    await console.session(Role.OPERATOR)
    client = console.client()
    assert (await client.get("/people")).json() == {"people": [], "device": {"name": ""}}
    forged = await client.get("/people", headers={"X-Headland-Stop-Token": "forged"})
    assert forged.json()["people"] == []
    answer = await client.post("/session", json={"name": "operator", "pin": "4711"})
    assert (answer.status_code, answer.json()["code"]) == (401, "not_enrolled")


async def test_a_lost_tablet_is_taken_out(console: Console) -> None:
    client, token = await enrolled(console)
    admin = await console.browser(Role.ADMIN)
    [device] = (await admin.get("/devices")).json()["devices"]
    assert device["revoked_utc"] is None
    assert (await admin.delete(f"/devices/{device['id']}")).status_code == 204
    assert (await client.get("/session")).status_code == 401
    press = {"stop_id": "stop-00000001", "robots": "all"}
    answer = await console.client().post("/stop", json=press, headers={"authorization": f"Bearer {token}"})
    assert (answer.status_code, answer.json()["code"]) == (401, "revoked")
    assert (await admin.delete("/devices/never-was")).status_code == 404


async def test_people_are_added_changed_and_switched_off(console: Console) -> None:
    admin = await console.browser(Role.ADMIN)
    added = await admin.post("/users", json={"name": "Piet Bos", "role": "operator", "password": PASSWORD})
    assert (added.status_code, added.json()["id"]) == (201, "piet-bos")
    again = await admin.post("/users", json={"name": "Piet Bos", "role": "operator", "password": PASSWORD})
    assert (again.status_code, again.json()["field"]) == (422, "user_id")
    weak = await admin.post("/users", json={"name": "Eva", "role": "viewer", "password": "short"})
    assert (weak.status_code, weak.json()["code"]) == (422, "weak_password")
    changed = await admin.patch("/users/piet-bos", json={"role": "viewer", "pin": "4711", "name": "Piet  Bos"})
    assert (changed.json()["role"], changed.json()["has_pin"]) == ("viewer", True)
    off = await admin.patch("/users/piet-bos", json={"is_active": False})
    assert off.json()["is_active"] is False
    assert (await admin.patch("/users/nobody", json={"name": "X"})).status_code == 404
    names = [u["name"] for u in (await admin.get("/users")).json()["users"]]
    assert "Piet Bos" in names


async def test_the_last_admin_cannot_lock_everybody_out(console: Console) -> None:
    admin = await console.browser(Role.ADMIN)
    answer = await admin.patch("/users/admin", json={"role": "viewer"})
    assert (answer.status_code, answer.json()["code"]) == (422, "last_admin")
