"""Orders by REST: outcomes, refusals, and what other browsers hear."""

from __future__ import annotations

from typing import Any

import httpx

from hmi.domain.role import Role
from tests.hmi.api.console import Console
from tests.hmi.commands.field import SHA, mission


async def send(console: Console, client: httpx.AsyncClient, action: str, ref: str = "command-1", **more: Any) -> Any:
    """Send a command on a fresh picture and return the answer's body."""
    body = {"command_id": ref, "action": action, "tick": console.field.tick(), **more}
    answer = await client.post("/robots/weeder-01/commands", json=body)
    assert answer.status_code == 200, answer.text
    return answer.json()


async def test_a_mission_is_sent_started_and_paused(console: Console) -> None:
    client = await console.browser(Role.OPERATOR)
    sent = await client.post("/robots/weeder-01/mission", json={"mission_id": "field-1"})
    told = sent.json()
    assert told.pop("took_s") >= 0
    assert told == {
        "outcome": "accepted",
        "code": "ok",
        "text": "Weeder 01 has Field 1 and read it back. Sending does not move the robot.",
        "sha256": SHA,
        "way": "direct",
    }
    console.field.weeder.mission = mission("field-1")
    started = await send(console, client, "start", mission_id="field-1", mission_sha256=SHA)
    assert started == {"command_id": "command-1", "outcome": "accepted", "code": "ok", "text": "", "ms": 0}
    paused = await send(console, client, "pause", "command-2")
    assert paused["outcome"] == "accepted"
    outcomes = [(e.actor, e.ref, e.outcome) for e in await console.written("command")]
    assert outcomes == []  # the desk of this console audits into the field's log
    assert console.field.audit.outcomes("command") == ["pending", "accepted", "pending", "accepted"]


async def test_a_program_that_starts_without_saying_what_is_told_how(console: Console) -> None:
    client = await console.browser(Role.OPERATOR)
    console.field.weeder.mission = mission("field-1")
    for number, (named, status, code) in enumerate(
        [
            ({}, 422, "incomplete"),
            ({"mission_id": "field-1"}, 422, "incomplete"),
            ({"mission_id": "field-1", "mission_sha256": "short"}, 422, "invalid"),
            ({"mission_id": "field-1", "mission_sha256": "b" * 64}, 200, "wrong_mission"),
        ]
    ):
        body = {"command_id": f"command-{number}", "action": "resume", "tick": console.field.tick(), **named}
        answer = await client.post("/robots/weeder-01/commands", json=body)
        assert (answer.status_code, answer.json()["code"]) == (status, code), answer.text
    assert console.field.weeder.orders == []


async def test_a_repeated_request_gets_the_same_answer_and_acts_once(console: Console) -> None:
    client = await console.browser(Role.OPERATOR)
    body = {"command_id": "command-1", "action": "return_home", "tick": console.field.tick()}
    answers = [(await client.post("/robots/weeder-01/commands", json=body)).json() for _ in range(3)]
    assert answers[0] == answers[1] == answers[2]
    assert console.field.weeder.done == ["command-1"]


async def test_refusals_of_the_console_are_outcomes_with_words(console: Console) -> None:
    martha = await console.browser(Role.OPERATOR)
    anna = await console.browser(Role.SUPERVISOR, browser="2")
    assert (await send(console, martha, "return_home"))["outcome"] == "accepted"
    held = await send(console, anna, "return_home", "command-2")
    assert (held["outcome"], held["code"]) == ("rejected", "held_by_other")
    assert held["text"] == "Martha Keller has control. Ask for it."
    late = {"command_id": "command-3", "action": "pause", "tick": console.field.tick()}
    console.field.wait(2.5)
    answer = (await martha.post("/robots/weeder-01/commands", json=late)).json()
    assert (answer["outcome"], answer["code"], answer["ms"]) == ("rejected", "stale_tick", None)


async def test_a_silent_robot_is_told_as_a_time_out(console: Console) -> None:
    client = await console.browser(Role.OPERATOR)
    console.field.weeder.is_silent = True
    assert (await send(console, client, "return_home"))["outcome"] == "timed_out"


async def test_a_robot_that_says_not_allowed_is_an_outcome_not_an_error(console: Console) -> None:
    client = await console.browser(Role.OPERATOR)
    console.field.weeder.refuse_with = ("not_allowed", "The key switch is off.")
    answer = await send(console, client, "return_home")
    assert (answer["outcome"], answer["code"]) == ("rejected", "not_allowed")


async def test_a_robot_that_does_not_exist_is_not_found(console: Console) -> None:
    client = await console.browser(Role.ADMIN)
    bodies: dict[str, dict[str, Any]] = {
        "commands": {"command_id": "command-1", "action": "pause", "tick": "x"},
        "lease": {"op": "request", "tick": "x"},
        "stop-reset": {"reset_id": "reset-00001", "stop_ids": ["stop-00001"], "reason": "Test", "tick": "x"},
        "seen": {"stop_id": "stop-00001"},
        "mission": {"mission_id": "field-1"},
    }
    for path, body in bodies.items():
        answer = await client.post(f"/robots/weeder-99/{path}", json=body)
        assert (answer.status_code, answer.json()["code"]) == (404, "unknown_robot"), path


async def test_control_is_asked_for_given_and_taken(console: Console) -> None:
    field = console.field
    martha = await console.browser(Role.OPERATOR)
    anna = await console.browser(Role.SUPERVISOR, browser="2")

    async def operate(client: httpx.AsyncClient, op: str, **more: Any) -> Any:
        answer = await client.post("/robots/weeder-01/lease", json={"op": op, "tick": field.tick(), **more})
        assert answer.status_code == 200, answer.text
        return answer.json()

    mine = await operate(martha, "request")
    assert (mine["granted"], mine["owner"]["name"]) == (True, "Martha Keller")
    asked = await operate(anna, "request")
    assert (asked["granted"], asked["code"], asked["asked"][0]["name"]) == (False, "asked", "Anna Ostermeier")
    assert (await operate(martha, "keep"))["asked"] == []
    await operate(anna, "request")
    given = await operate(martha, "grant", session=asked["asked"][0]["session"])
    assert given["owner"]["name"] == "Anna Ostermeier"
    await operate(anna, "release")
    await operate(martha, "request")
    unsaid = await operate(anna, "take")
    assert (unsaid["granted"], unsaid["code"]) == (False, "reason_missing")
    taken = await operate(anna, "take", reason="Person in the field")
    assert (taken["granted"], taken["owner"]["name"]) == (True, "Anna Ostermeier")


async def test_a_stop_is_reset_by_who_pressed_it(console: Console) -> None:
    client = await console.browser(Role.OPERATOR)
    console.field.weeder.press("stop-000001", "Martha Keller")
    console.field.pressers["stop-000001"] = {"operator"}
    body = {"reset_id": "reset-00001", "stop_ids": ["stop-000001"], "reason": "Test", "tick": console.field.tick()}
    answer = (await client.post("/robots/weeder-01/stop-reset", json=body)).json()
    assert answer == {"reset_id": "reset-00001", "outcome": "accepted", "code": "ok", "text": "", "ms": 0}
    assert not console.field.weeder.is_latched


async def test_what_a_person_saw_is_recorded_and_changes_nothing(console: Console) -> None:
    client = await console.browser(Role.VIEWER)
    answer = await client.post("/robots/weeder-01/seen", json={"stop_id": "stop-000001"})
    assert (answer.status_code, answer.content) == (204, b"")
    [entry] = [e for e in console.field.audit.entries if e.kind == "seen"]
    assert (entry.actor, entry.ref) == ("Viewer", "stop-000001")
    assert console.field.weeder.orders == []


async def test_an_interrupted_mission_starts_fresh_only_when_that_is_said(console: Console) -> None:
    console.field.missions.done["field-1"] = "row 2 of 4, 0.01 ha done"
    client = await console.browser(Role.OPERATOR)
    answer = await client.post("/robots/weeder-01/mission", json={"mission_id": "field-1"})
    assert (answer.status_code, answer.json()["code"]) == (409, "has_progress")
    assert "row 2 of 4" in answer.json()["text"]
    assert "Resume it, resume it later, or start it fresh" in answer.json()["text"]
    assert console.field.missions.noted == []
    fresh = await client.post("/robots/weeder-01/mission", json={"mission_id": "field-1", "fresh": True})
    assert fresh.json()["outcome"] == "accepted"
    viewer = await console.browser(Role.VIEWER, browser="2")
    answer = await viewer.post("/robots/weeder-01/mission", json={"mission_id": "field-1"})
    assert answer.status_code == 403
