"""The planner service over real HTTP: plans, progress, one plan a key, cancel, sizes, token."""

from __future__ import annotations

import asyncio
import json
from pathlib import Path
from typing import Any

import httpx
import jsonschema
import pytest

from backend_clients.planner.messages import MAX_REQUEST, PlanRequest, wish_sha256
from backend_clients.planner.schema import openapi
from hmi.planning.progress_note import read_progress
from hmi.planning_service.desk import WAITING_LIMIT, PlanDesk
from hmi.planning_service.form import form_of
from hmi.planning_service.work import planned
from tests.hmi.missions.test_document import wish
from tests.hmi.planning_service.rig import TOKEN, ServiceRig, service_rig, until

HEAD = {"Authorization": f"Bearer {TOKEN}", "Content-Type": "application/json"}


def body_of(**changes: Any) -> bytes:
    """Return a request for a plan."""
    form = form_of(wish(**changes))
    return PlanRequest(wish_sha256=wish_sha256(form), wish=form).model_dump_json().encode()


async def ended(rig: ServiceRig, http: httpx.AsyncClient, plan: str) -> dict[str, Any]:
    """Return a plan when it has ended."""
    await until(lambda: rig.desk.report(plan).state not in ("queued", "running"))
    told: dict[str, Any] = (await http.get(f"plans/{plan}")).json()
    return told


def browser(rig: ServiceRig, **headers: str) -> httpx.AsyncClient:
    """Return a client of the service."""
    return httpx.AsyncClient(base_url=rig.url, headers={**HEAD, **headers}, trust_env=False)


def check(kind: str, told: dict[str, Any]) -> None:
    """Assert that an answer fits the documented schema."""
    schema = {"$ref": f"#/components/schemas/{kind}", "components": openapi()["components"]}
    jsonschema.validate(told, schema)


async def test_a_wish_becomes_a_path_and_every_answer_fits_the_document() -> None:
    async with service_rig() as rig, browser(rig) as http:
        info = (await http.get("/")).json()
        check("ServiceInfo", info)
        assert info["service"] == "planner"
        taken = await http.post("plans", content=body_of())
        assert taken.status_code == 202
        check("PlanReport", taken.json())
        assert taken.headers["location"] == f"plans/{taken.json()['id']}"
        done = await ended(rig, http, taken.json()["id"])
        check("PlanReport", done)
        assert (done["state"], done["progress"]) == ("done", 1.0)
        assert {one["kind"] for one in done["result"]["segments"]} >= {"row", "headland"}
        assert done["wish_sha256"] == json.loads(body_of())["wish_sha256"]


async def test_why_a_wish_cannot_be_planned_is_said_in_words() -> None:
    async with service_rig() as rig, browser(rig) as http:
        taken = (await http.post("plans", content=body_of(width_m=39.0))).json()
        told = await ended(rig, http, taken["id"])
        check("PlanReport", told)
        assert told["state"] == "failed"
        assert told["problem"]["text"].endswith(".")


async def test_the_same_key_is_one_plan_and_belongs_to_one_wish() -> None:
    async with service_rig() as rig, browser(rig, **{"Idempotency-Key": "k-1"}) as http:
        rig.process.held = asyncio.Event()
        first, again = [await http.post("plans", content=body_of()) for _ in range(2)]
        other = await http.post("plans", content=body_of(width_m=2.0))
        assert (first.json()["id"], again.json()["id"]) == ("k-1", "k-1")
        assert (first.status_code, again.status_code, other.status_code) == (202, 202, 409)
        assert rig.desk.waiting == 1


async def test_cancelling_ends_the_work_and_frees_the_worker_for_the_next() -> None:
    async with service_rig() as rig, browser(rig) as http:
        rig.process.held = asyncio.Event()
        first = (await http.post("plans", content=body_of())).json()["id"]
        await until(lambda: rig.desk.report(first).state == "running")
        assert (await http.delete(f"plans/{first}")).status_code == 204
        assert (await http.get(f"plans/{first}")).status_code == 404
        assert (await http.delete(f"plans/{first}")).status_code == 404
        rig.process.held = None
        second = (await http.post("plans", content=body_of())).json()["id"]
        assert (await ended(rig, http, second))["state"] == "done"
        assert rig.process.is_given_up


async def test_more_plans_than_may_wait_are_refused_with_a_time_to_ask_again() -> None:
    async with service_rig() as rig, browser(rig) as http:
        rig.process.held = asyncio.Event()
        answers = [await http.post("plans", content=body_of()) for _ in range(WAITING_LIMIT + 1)]
        assert [one.status_code for one in answers] == [202] * WAITING_LIMIT + [429]
        assert int(answers[-1].headers["retry-after"]) > 0
        check("Problem", answers[-1].json())


@pytest.mark.parametrize(
    ("content", "status"),
    [
        (b"no json", 400),
        (b"{}", 422),
        (b'{"v": 2}', 422),
        (b"[" * 100_000, 400),
        (b" " * (MAX_REQUEST + 1), 413),
    ],
)
async def test_what_is_no_wish_is_refused_with_a_sentence(content: bytes, status: int) -> None:
    async with service_rig() as rig, browser(rig) as http:
        answer = await http.post("plans", content=content)
        assert answer.status_code == status
        check("Problem", answer.json())


async def test_nobody_gets_in_without_the_token() -> None:
    async with service_rig() as rig, httpx.AsyncClient(base_url=rig.url, trust_env=False) as http:
        for method, path in (("GET", "/"), ("POST", "/plans"), ("GET", "/plans/x"), ("DELETE", "/plans/x")):
            answer = await http.request(method, path, headers={"Authorization": "Bearer wrong"})
            assert answer.status_code == 401
            check("Problem", answer.json())


async def test_plans_that_nobody_fetches_are_forgotten() -> None:
    now = [0.0]
    async with service_rig() as rig:
        desk = PlanDesk(process=rig.process, mono_s=lambda: now[0])
        request = PlanRequest.model_validate_json(body_of())
        plan = desk.submit(request, None).id
        await until(lambda: desk.report(plan).state == "done")
        now[0] = 601.0
        with pytest.raises(Exception, match="not any more"):
            desk.report(plan)
        await desk.close()


def test_the_worker_says_how_far_it_is(tmp_path: Path) -> None:
    note = tmp_path / "note"
    note.touch()
    assert read_progress(note) == (0.0, "Starting")
    planned(form_of(wish()).model_dump_json().encode(), str(note))
    share, words = read_progress(note)
    assert 0 < share <= 1
    assert words


@pytest.mark.slow
async def test_a_plan_of_the_real_worker_process_can_be_cancelled_and_the_next_one_comes() -> None:
    desk = PlanDesk()
    request = PlanRequest.model_validate_json(body_of(width_m=0.06))
    first = desk.submit(request, "first")
    assert first.state == "queued"
    await until(lambda: desk.report("first").state == "running")
    desk.give_up("first")
    desk.submit(PlanRequest.model_validate_json(body_of()), "second")
    await until(lambda: desk.report("second").state not in ("queued", "running"))
    assert desk.report("second").state == "done"
    await desk.close()
