"""The registry by REST, and robots as programs see them."""

from __future__ import annotations

import json
from dataclasses import replace

from hmi.domain.role import Role
from tests.hmi.api.console import Console
from tests.hmi.presenters.robots import SHEET


async def test_a_robot_that_was_only_heard_is_shown_as_new_and_accepted(console: Console) -> None:
    stranger = console.field.add("weeder-02", "Weeder 02")
    stranger.is_registered = False
    admin = await console.browser(Role.ADMIN)
    assert [r["id"] for r in (await admin.get("/robots/new")).json()["robots"]] == ["weeder-02"]
    assert [r["id"] for r in (await admin.get("/robots")).json()["robots"]] == ["weeder-01"]
    body = {
        "id": "weeder-02",
        "name": "Weeder 02",
        "family": "weeder",
        "http_url": "http://10.0.0.7:9000/",
        "http_token": "t0ken",
    }
    answer = await admin.post("/robots", json=body)
    assert answer.status_code == 201
    assert answer.json()["http_url"] == "http://10.0.0.7:9000"
    assert answer.json()["has_http_token"] is True
    assert "t0ken" not in answer.text
    assert stranger.is_registered
    told = json.loads((console.folder / "stop" / "robots.json").read_text())
    assert {r["id"]: r["token"] for r in told}["weeder-02"] == "t0ken"
    [entry] = await console.written("robot")
    assert (entry.outcome, entry.robot_id, entry.actor) == ("accepted", "weeder-02", "Admin")


async def test_the_width_of_its_tool_is_told_for_planning(console: Console) -> None:
    planner = await console.browser(Role.PLANNER)
    assert (await planner.get("/robots")).json()["robots"][0]["tool_width_m"] is None
    console.field.weeder.factsheet = replace(SHEET, tool_width_m=1.5)
    assert (await planner.get("/robots")).json()["robots"][0]["tool_width_m"] == 1.5


async def test_a_robot_with_a_stop_that_is_not_reset_cannot_be_removed(console: Console) -> None:
    admin = await console.browser(Role.ADMIN)
    console.field.weeder.press("stop-00000001", "Martha Keller")
    answer = await admin.delete("/robots/weeder-01")
    assert (answer.status_code, answer.json()["code"]) == (409, "stop_open")
    assert "Reset it, then remove the robot." in answer.json()["text"]
    console.field.weeder.presses.clear()
    console.stops_at.add("weeder-01")  # the robot is silent and says nothing, but it was told to stop
    assert (await admin.delete("/robots/weeder-01")).status_code == 409
    assert [r["id"] for r in (await admin.get("/robots")).json()["robots"]] == ["weeder-01"]
    console.stops_at.clear()
    assert (await admin.delete("/robots/weeder-01")).status_code == 204


async def test_an_id_is_taken_once(console: Console) -> None:
    admin = await console.browser(Role.ADMIN)
    answer = await admin.post("/robots", json={"id": "weeder-01", "name": "Another"})
    assert (answer.status_code, answer.json()["code"]) == (409, "already_exists")


ADDRESSES = (
    "ftp://10.0.0.7",
    "http://",
    "//10.0.0.7",
    "http://user:pass@10.0.0.7",
    "http://10.0.0.7/?x=1",
    "javascript:1",
    "http://10.0.0.7:x",
    "http://10.0.0.7:99999",
    "http://10.0.0.7:0",
    "http://[::1",
    "http://müller..de",
)


async def test_an_address_that_is_none_is_refused(console: Console) -> None:
    admin = await console.browser(Role.ADMIN)
    for address in ADDRESSES:
        answer = await admin.patch("/robots/weeder-01", json={"http_url": address})
        assert (answer.status_code, answer.json()["field"]) == (422, "http_url"), address


async def test_a_token_that_no_header_can_carry_is_refused(console: Console) -> None:
    admin = await console.browser(Role.ADMIN)
    for token in ("gehölz", "a\nb", "\u200bsecret"):
        answer = await admin.patch("/robots/weeder-01", json={"http_token": token})
        assert (answer.status_code, answer.json()["field"]) == (422, "http_token"), token
    assert (await admin.patch("/robots/weeder-01", json={"http_token": "s3cret ~!"})).status_code == 200


async def test_an_id_that_could_not_be_a_topic_is_refused(console: Console) -> None:
    admin = await console.browser(Role.ADMIN)
    for robot_id in ("", "Weeder", "weeder 1", "../x", "weeder\n", "-weeder", "w" * 65, "wéeder"):
        answer = await admin.post("/robots", json={"id": robot_id, "name": "X"})
        assert (answer.status_code, answer.json()["field"]) == (422, "id"), robot_id


async def test_what_is_left_out_stays_and_null_takes_away(console: Console) -> None:
    admin = await console.browser(Role.ADMIN)
    await admin.patch("/robots/weeder-01", json={"contact_name": "Jonas Weber", "contact_phone": "+49 151 0000"})
    changed = await admin.patch("/robots/weeder-01", json={"contact_phone": None, "keep_out_m": 20.0})
    body = changed.json()
    assert (body["contact_name"], body["contact_phone"], body["keep_out_m"]) == ("Jonas Weber", None, 20.0)
    assert body["name"] == "Weeder 01"


async def test_tokens_are_not_written_into_the_audit(console: Console) -> None:
    admin = await console.browser(Role.ADMIN)
    await admin.patch("/robots/weeder-01", json={"http_token": "s3cret"})
    [entry] = await console.written("robot")
    assert entry.data == {"http_token": "***"}


async def test_where_a_robot_listens_is_told_to_those_who_manage_it_alone(console: Console) -> None:
    admin = await console.browser(Role.ADMIN)
    await admin.patch("/robots/weeder-01", json={"http_url": "http://10.0.0.7:9000"})
    viewer = await console.browser(Role.VIEWER, browser="2")
    for path in ("/robots", "/robots/weeder-01"):
        assert "10.0.0.7" in (await admin.get(path)).text
        assert "10.0.0.7" not in (await viewer.get(path)).text


async def test_one_robot_comes_with_all_its_groups_and_who_has_control(console: Console) -> None:
    client = await console.browser(Role.OPERATOR)
    body = {"op": "request", "tick": console.field.tick()}
    await client.post("/robots/weeder-01/lease", json=body)
    robot = (await client.get("/robots/weeder-01")).json()
    assert robot["id"]["name"] == "Weeder 01"
    assert robot["safety"]["latched"] is False
    assert robot["lease"]["owner"]["name"] == "Martha Keller"
    assert robot["now_ms"] >= robot["link"]["t"]
    assert (await client.get("/robots/weeder-77")).status_code == 404


async def test_a_robot_that_is_removed_loses_its_operator(console: Console) -> None:
    admin = await console.browser(Role.ADMIN)
    await admin.post("/robots/weeder-01/lease", json={"op": "request", "tick": console.field.tick()})
    assert (await admin.delete("/robots/weeder-01")).status_code == 204
    assert console.field.desk.leases.of("weeder-01") is None
    assert not console.field.weeder.is_registered
    body = {"command_id": "command-1", "action": "pause", "tick": console.field.tick()}
    answer = await admin.post("/robots/weeder-01/commands", json=body)
    assert (answer.status_code, answer.json()["code"]) == (403, "not_registered")
    assert (await admin.delete("/robots/weeder-01")).status_code == 404


async def test_a_change_that_stop_could_not_be_told_of_says_so(console: Console) -> None:
    admin = await console.browser(Role.ADMIN)
    (console.folder / "stop" / "robots.json").unlink()
    (console.folder / "stop" / "robots.json").mkdir()
    (console.folder / "stop" / "robots.json" / "in-the-way").touch()
    answer = await admin.patch("/robots/weeder-01", json={"name": "Weeder One"})
    assert (answer.status_code, answer.json()["code"]) == (500, "stop_list_not_written")
    robots = (await admin.get("/robots")).json()["robots"]
    assert robots[0]["name"] == "Weeder One"
