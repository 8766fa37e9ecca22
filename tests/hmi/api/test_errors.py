"""Errors: one shape, a sentence, never a stack trace."""

from __future__ import annotations

import json
from typing import Any

import httpx
import pytest

from hmi.domain.role import Role
from hmi.store.errors import DatabaseFull, DatabaseUnavailable
from tests.hmi.api.console import Console


def shape(answer: httpx.Response) -> tuple[int, str]:
    """Return status and code, after checking that the body is an error of ours."""
    body = answer.json()
    assert set(body) == {"code", "text", "field"}
    assert body["text"].endswith(".")
    assert "Traceback" not in answer.text
    return answer.status_code, body["code"]


async def test_an_unknown_address_and_a_wrong_method_are_told_in_our_shape(console: Console) -> None:
    client = await console.browser(Role.ADMIN)
    assert shape(await client.get("/nothing-here")) == (404, "not_found")
    wrong = await client.put("/robots", json={})
    assert shape(wrong) == (405, "method_not_allowed")
    assert "GET" in wrong.headers["allow"]


BODIES: list[tuple[dict[str, Any], str]] = [
    ({"command_id": "command-1", "action": "start", "tick": "x", "extra": 1}, "extra"),
    ({"command_id": "command-1", "action": "explode", "tick": "x"}, "action"),
    ({"command_id": "short", "action": "start", "tick": "x"}, "command_id"),
    ({"command_id": "command-1\n", "action": "start", "tick": "x"}, "command_id"),
    ({"command_id": 12345678, "action": "start", "tick": "x"}, "command_id"),
    ({"command_id": "command-1", "action": "start", "tick": "x" * 81}, "tick"),
    ({"command_id": "command-1", "action": "start"}, "tick"),
    ({"command_id": "command-1", "action": "start", "tick": "x", "mission_id": "../etc"}, "mission_id"),
]
NO_OBJECTS = [
    b"", b"{", b"null", b"[]", b'"text"', b"\xff\xfe", b"[" * 50_000, b'{"command_id": NaN}',
    b'{"command_id": "\\ud800\\ud800\\ud800", "action": "start", "tick": "x"}',
]  # fmt: skip
NO_NUMBERS = ["NaN", "Infinity", "-Infinity", "1e999", "0", "-1", '"1"', "true", "1e300"]
JSON = {"content-type": "application/json"}


async def test_a_body_that_is_not_as_written_down_is_refused_with_its_field(console: Console) -> None:
    client = await console.browser(Role.OPERATOR)
    for body, field in BODIES:
        answer = await client.post("/robots/weeder-01/commands", json=body)
        assert shape(answer) == (422, "invalid"), body
        assert answer.json()["field"] == field
    assert console.field.weeder.orders == []


async def test_what_is_no_json_object_is_refused(console: Console) -> None:
    client = await console.browser(Role.OPERATOR)
    for body in NO_OBJECTS:
        answer = await client.post("/robots/weeder-01/commands", content=body, headers=JSON)
        assert shape(answer) == (422, "invalid"), body[:40]


async def test_what_is_no_sensible_number_is_refused(console: Console) -> None:
    client = await console.browser(Role.ADMIN)
    for number in NO_NUMBERS:
        answer = await client.patch("/robots/weeder-01", content=f'{{"decel_mps2": {number}}}', headers=JSON)
        assert shape(answer) == (422, "invalid"), number
        assert answer.json()["field"] == "decel_mps2"


@pytest.mark.parametrize("is_announced", [True, False])
async def test_a_body_over_the_limit_is_refused_however_it_comes(console: Console, is_announced: bool) -> None:
    client = await console.browser(Role.OPERATOR)
    big = json.dumps({"command_id": "x" * 70_000}).encode()

    async def stream() -> Any:
        for start in range(0, len(big), 8192):
            yield big[start : start + 8192]

    content = big if is_announced else stream()
    answer = await client.post(
        "/robots/weeder-01/commands", content=content, headers={"content-type": "application/json"}
    )
    assert shape(answer) == (413, "too_large")


async def test_a_fault_of_ours_is_a_sentence_and_goes_to_the_log(
    console: Console, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    client = await console.browser(Role.ADMIN)

    async def broken() -> list[Any]:
        raise RuntimeError("secret detail")

    monkeypatch.setattr(console.accounts, "all", broken)
    answer = await client.get("/users")
    assert shape(answer) == (500, "failed")
    assert "secret detail" not in answer.text
    assert "secret detail" in caplog.text


@pytest.mark.parametrize(
    ("error", "said"),
    [(DatabaseUnavailable, ""), (DatabaseFull, "disk of the server is full")],
)
async def test_a_database_that_is_away_or_full_is_told_as_such(
    console: Console, monkeypatch: pytest.MonkeyPatch, error: type[DatabaseUnavailable], said: str
) -> None:
    client = await console.browser(Role.ADMIN)

    def away(*_args: Any, **_more: Any) -> Any:
        raise error("full at /secret/path")

    monkeypatch.setattr(console.audit, "recent", away)
    answer = await client.get("/audit")
    assert shape(answer) == (503, "database_unavailable")
    assert said in answer.json()["text"]
    assert "/secret/path" not in answer.text


async def test_the_interface_describes_itself(console: Console) -> None:
    answer = await console.client().get("/openapi.json")
    assert answer.status_code == 200
    described = answer.json()
    assert described["info"]["title"] == "Headland"
    assert "/robots/{robot_id}/commands" in described["paths"]
