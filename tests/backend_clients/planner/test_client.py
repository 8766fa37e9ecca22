"""The planner's client: what it takes for a plan, what it refuses, and that it cancels at the service."""

from __future__ import annotations

import asyncio
import json
import logging
from typing import Any

import httpx
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from backend_clients.planner.client import PlanFailed, TooSlow
from backend_clients.planner.messages import wish_sha256
from backend_clients.service import errors
from tests.backend_clients.planner.wishes import PATH, SERVICE, WISH, PlayedService

RUNNING = {"state": "running", "progress": 0.4, "words": "Row 4 of 10"}
DONE = {"state": "done", "progress": 1.0, "result": PATH}


async def test_a_plan_is_handed_in_followed_and_taken_and_then_need_not_be_kept() -> None:
    service, heard = PlayedService({"state": "queued"}, RUNNING, DONE), []
    client = service.client()
    path = await client.path(WISH, "key-1", lambda share, words: heard.append((share, words)))
    await client.close()
    assert path.segments[0].points == [(0.0, 0.0), (10.0, 0.0)]
    assert heard == [(0.0, ""), (0.4, "Row 4 of 10")]
    assert service.asked == [
        ("POST", "/v1/plans"), ("GET", "/v1/plans/key-1"), ("GET", "/v1/plans/key-1"), ("DELETE", "/v1/plans/key-1"),
    ]  # fmt: skip
    assert {one["authorization"] for one in service.headers} == {"Bearer secret-token"}


async def test_cancelling_cancels_at_the_service_even_before_it_answered() -> None:
    service, begun = PlayedService(RUNNING), asyncio.Event()

    async def for_ever(_seconds: float) -> None:
        begun.set()
        await asyncio.Event().wait()

    client = service.client(sleep=for_ever)
    work = asyncio.create_task(client.path(WISH, "key-2"))
    await begun.wait()
    work.cancel()
    with pytest.raises(asyncio.CancelledError):
        await work
    await client.close()
    assert service.asked[-1] == ("DELETE", "/v1/plans/key-2")


@pytest.mark.parametrize(
    "told",
    [
        {**DONE, "wish_sha256": "0" * 64},
        {**DONE, "id": "another"},
        {**DONE, "v": 2},
        {"state": "done"},
        {"state": "failed"},
        {**DONE, "progress": 7},
        {**DONE, "result": {"segments": []}},
        {**DONE, "result": {"segments": [{**PATH["segments"][0], "points": [[0, 0]]}]}},
        {**DONE, "result": {"segments": [{**PATH["segments"][0], "speed_mps": -1}]}},
        {**DONE, "result": {"segments": [{**PATH["segments"][0], "surprise": 1}]}},
        {**DONE, "result": {"segments": [{**PATH["segments"][0], "kind": "fly"}]}},
    ],
)
async def test_what_is_not_the_answer_to_this_wish_in_this_format_is_refused(told: dict[str, Any]) -> None:
    client = PlayedService(told).client()
    with pytest.raises(errors.Unreadable):
        await client.path(WISH, "key-3")
    await client.close()


async def test_infinite_numbers_are_refused() -> None:
    service = PlayedService(DONE)
    whole = {"id": "key", "wish_sha256": wish_sha256(WISH), "state": "done", "result": PATH}
    told = json.dumps({**whole, "progress": float("nan")}).encode()
    service.instead = lambda _request: httpx.Response(202, content=told)
    client = service.client()
    with pytest.raises(errors.Unreadable):
        await client.path(WISH, "key")
    await client.close()


async def test_why_a_planner_cannot_plan_is_told_and_too_long_is_too_long() -> None:
    problem = {"code": "field_too_small", "text": "The field is too small.", "field": "field_id"}
    client = PlayedService({"state": "failed", "problem": problem}).client()
    with pytest.raises(PlanFailed, match="too small") as refused:
        await client.path(WISH, "key")
    assert (refused.value.code, refused.value.field) == ("field_too_small", "field_id")
    slow = PlayedService(RUNNING)
    client = slow.client(limit_s=10.0)
    with pytest.raises(TooSlow, match="10 s"):
        await client.path(WISH, "key")
    await client.close()
    assert 9.0 < sum(slow.slept) <= 10.0
    assert slow.asked[-1][0] == "DELETE"


@pytest.mark.parametrize(
    ("status", "kind", "tries"),
    [
        (503, errors.ServiceFailed, 2),
        (401, errors.NotAllowed, 1),
        (413, errors.TooLarge, 1),
        (429, errors.Busy, 2),
        (404, errors.Gone, 1),
        (302, errors.Unreadable, 1),
    ],
)
async def test_a_refusal_of_the_service_has_its_own_error(
    status: int, kind: type[errors.ServiceError], tries: int
) -> None:
    service = PlayedService(DONE)
    service.instead = lambda _request: httpx.Response(status, json={"text": "No\nway \x00."}, headers={"Location": "/"})
    client = service.client()
    with pytest.raises(kind) as refused:
        await client.path(WISH, "key")
    await client.close()
    assert sum(method == "POST" for method, _ in service.asked) == tries
    assert refused.value.mend.endswith(".")
    assert "\n" not in str(refused.value)


async def test_an_answer_that_is_too_long_or_compressed_is_not_read() -> None:
    service = PlayedService(DONE)
    service.instead = lambda _request: httpx.Response(200, content=b" " * (17 * 2**20))
    client = service.client()
    with pytest.raises(errors.TooLong):
        await client.path(WISH, "key")
    service.instead = lambda _request: httpx.Response(200, headers={"Content-Encoding": "br"}, content=b"")
    with pytest.raises(errors.Unreadable, match="compressed"):
        await client.path(WISH, "key")
    await client.close()


async def test_credentials_stand_in_no_log_and_in_no_error(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.DEBUG)
    service = PlayedService(DONE)
    service.instead = lambda _request: httpx.Response(503)
    client = service.client()
    with pytest.raises(errors.ServiceFailed) as refused:
        await client.path(WISH, "key")
    await client.close()
    assert "secret-token" not in caplog.text + repr(refused.value) + repr(SERVICE)


@settings(max_examples=25)
@given(st.binary(max_size=200) | st.text(max_size=60).map(str.encode))
def test_whatever_comes_it_is_a_plan_or_an_error_of_ours(content: bytes) -> None:
    async def ask() -> None:
        service = PlayedService(DONE)
        service.instead = lambda _request: httpx.Response(200, content=content)
        client = service.client()
        with pytest.raises(errors.ServiceError):
            await client.path(WISH, "key")
        await client.close()

    asyncio.run(ask())
