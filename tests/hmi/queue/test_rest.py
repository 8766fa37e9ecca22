"""The queue over REST: who may, what is refused, what a screen gets."""

from __future__ import annotations

from datetime import timedelta
from typing import Any

import httpx
import pytest
from fastapi import FastAPI

from hmi.api import errors
from hmi.api.access import Access
from hmi.domain.role import Permission, Role, may
from tests.hmi.commands.field import person
from tests.hmi.missions.rig import Door, NoTokens
from tests.hmi.queue.rig import MORNING, PIETER, QueueFarm

P = Permission
WINDOW = {"name": "Night", "days": [0, 1, 2, 3, 4, 5, 6], "from_min": 1320, "to_min": 360}
ROUTES: list[tuple[str, str, dict[str, Any] | None, Permission]] = [
    ("GET", "/queue", None, P.WATCH),
    ("POST", "/queue/entries", {"mission_id": "wheat-1"}, P.SEND_MISSION),
    ("PATCH", "/queue/entries/q-none", {}, P.SEND_MISSION),
    ("POST", "/queue/entries/q-none/move", {"before": None}, P.SEND_MISSION),
    ("DELETE", "/queue/entries/q-none", None, P.SEND_MISSION),
    ("POST", "/queue/blackouts", WINDOW, P.SEND_MISSION),
    ("PUT", "/queue/blackouts/b-none", WINDOW, P.SEND_MISSION),
    ("DELETE", "/queue/blackouts/b-none", None, P.SEND_MISSION),
    ("POST", "/queue/arm", {"robots": [{"robot_id": "weeder-01", "revision": 0}], "duration_s": 3600, "tick": "x"},
     P.START),
    ("POST", "/queue/disarm", {"robots": ["weeder-01"]}, P.STOP),
    ("POST", "/queue/release", {"reason": "Clear", "tick": "x"}, P.RESET),
    ("POST", "/queue/robots/weeder-01/take-off", {"mission_id": "wheat-3"}, P.SEND_MISSION),
    ("POST", "/weather", {"station": "Yard", "wind_mps": 3.0}, P.SEND_MISSION),
]  # fmt: skip


def browser(farm: QueueFarm, role: Role | None) -> httpx.AsyncClient:
    """Return a browser of somebody, or of nobody."""
    app = FastAPI()
    who = None if role is None else person(f"{role.value.title()} Person", role)
    app.state.access = Access(Door(who), NoTokens(), farm.authorize)
    app.include_router(farm.queue.routes())
    errors.install(app)
    return httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://console.local")


@pytest.mark.parametrize("role", list(Role))
async def test_each_role_may_exactly_what_the_table_says(farm: QueueFarm, role: Role) -> None:
    wrong = []
    async with browser(farm, role) as client:
        for method, path, body, permission in ROUTES:
            answer = await client.request(method, path, json=body)
            is_refused = answer.status_code == 403 and answer.json()["code"] == "not_allowed"
            # a window that is not there is told to whoever may watch; changing it needs more
            if path.endswith("b-none") and method == "PUT":
                continue
            if is_refused == may(role, permission) or answer.status_code >= 500:
                wrong.append((method, path, answer.status_code, answer.text))
    assert wrong == []


async def test_nobody_gets_anywhere_without_signing_in(farm: QueueFarm) -> None:
    async with browser(farm, None) as client:
        for method, path, body, _permission in ROUTES:
            assert (await client.request(method, path, json=body)).status_code == 401, path


async def test_a_screen_gets_queues_reasons_and_armings(farm: QueueFarm) -> None:
    async with browser(farm, Role.OPERATOR) as client:
        at = (MORNING + timedelta(hours=2)).isoformat()
        body = {"mission_id": "wheat-1", "is_unattended": True, "earliest_utc": at, "repeat": {"kind": "daily"}}
        added = await client.post("/queue/entries", json=body)
        assert added.status_code == 201
        await farm.step(2)
        tick = farm.ticks.issue().id
        arm = {"robots": [{"robot_id": "weeder-01", "revision": 1}], "duration_s": 3600, "tick": tick}
        armed = await client.post("/queue/arm", json=arm)
        assert armed.json()["text"] == "Armed until 11:00."
        shown = (await client.get("/queue")).json()
    [entry] = shown["entries"]
    assert (entry["name"], entry["status"]) == ("Wheat 1", "queued")
    assert entry["waiting"]["text"] == "Waits until 12:00."
    assert entry["waiting"]["clears_utc"] == "2026-06-15T10:00:00.000+00:00"
    assert entry["repeat"] == {"kind": "daily", "days": [], "every_days": 1, "until": None}
    assert shown["robots"][0]["arming"]["by"] == "Operator Person"
    assert shown["zone"] == "Europe/Amsterdam"
    assert shown["weather"] is None


async def test_an_entry_moves_changes_and_goes(farm: QueueFarm) -> None:
    async with browser(farm, Role.PLANNER) as client:
        first = (await client.post("/queue/entries", json={"mission_id": "wheat-1"})).json()["id"]
        second = (await client.post("/queue/entries", json={"mission_id": "wheat-2"})).json()["id"]
        moved = await client.post(f"/queue/entries/{second}/move", json={"before": first})
        assert moved.json()["entries"] == [second, first]
        changed = await client.patch(f"/queue/entries/{first}", json={"is_unattended": True, "window_s": 3600})
        assert changed.json()["window_s"] == 3600
        assert (await client.delete(f"/queue/entries/{second}")).status_code == 204
        left = (await client.get("/queue")).json()["entries"]
    assert [one["id"] for one in left] == [first]
    assert farm.status("wheat-2") == "validated"


@pytest.mark.parametrize(
    ("body", "code"),
    [
        ({"mission_id": "none"}, "unknown_mission"),
        ({"mission_id": "wheat-1", "robot_id": "nobody"}, "not_registered"),
        ({"mission_id": "wheat-1", "repeat": {"kind": "daily"}}, "no_time"),
        ({"mission_id": "wheat-1", "repeat": {"kind": "weekly"}, "earliest_utc": "2026-06-16T06:00Z"}, "invalid"),
        ({"mission_id": "wheat-1", "earliest_utc": "2026-06-14T06:00:00Z"}, "too_late"),
        ({"mission_id": "wheat-1", "earliest_utc": "2026-06-16T06:00"}, "invalid"),
        ({"mission_id": "wheat-1", "earliest_utc": "soon"}, "invalid"),
        ({"mission_id": "wheat-1", "earliest_utc": "0001-01-01T00:00:00+14:00"}, "invalid"),
        ({"mission_id": "wheat-1", "earliest_utc": "9999-12-31T23:59:59Z"}, "invalid"),
        ({"mission_id": "wheat-1", "hurry": True}, "invalid"),
    ],
)
async def test_what_makes_no_sense_is_refused_with_a_sentence(farm: QueueFarm, body: dict[str, Any], code: str) -> None:
    async with browser(farm, Role.OPERATOR) as client:
        answer = await client.post("/queue/entries", json=body)
    assert (answer.status_code in (403, 409, 422), answer.json()["code"]) == (True, code)
    assert farm.queue.store.entries() == []


async def test_a_mission_is_in_one_queue_only(farm: QueueFarm) -> None:
    await farm.add("wheat-1")
    async with browser(farm, Role.OPERATOR) as client:
        answer = await client.post("/queue/entries", json={"mission_id": "wheat-1"})
    assert answer.json()["text"] == "Wheat 1 is in a queue already. Copy it to run it again."


async def test_weather_counts_until_it_is_old_and_is_not_taken_from_the_future(farm: QueueFarm) -> None:
    async with browser(farm, Role.OPERATOR) as client:
        told = await client.post("/weather", json={"station": "Yard", "wind_mps": 3.5})
        late = await client.post("/weather", json={"station": "Yard", "wind_mps": 1.0, "utc": "2026-06-15T09:00:00Z"})
        shown = (await client.get("/queue")).json()["weather"]
    assert told.json()["wind_mps"] == 3.5
    assert late.json()["code"] == "from_the_future"
    assert (shown["station"], shown["rain_mm_h"]) == ("Yard", None)


async def test_a_blackout_window_is_kept_over_a_restart_and_disarms(farm: QueueFarm) -> None:
    await farm.add("wheat-1", earliest=MORNING + timedelta(hours=1))
    await farm.arm()
    async with browser(farm, Role.OPERATOR) as client:
        made = (await client.post("/queue/blackouts", json=WINDOW)).json()
        assert farm.disarmed() == "Operator Person changed the queue."
        await client.put(f"/queue/blackouts/{made['id']}", json={**WINDOW, "name": "Quiet"})
    await farm.again()
    async with browser(farm, Role.OPERATOR) as client:
        assert [one["name"] for one in (await client.get("/queue")).json()["blackouts"]] == ["Quiet"]
        assert (await client.delete(f"/queue/blackouts/{made['id']}")).status_code == 204


async def test_every_change_of_the_queue_is_in_the_audit(farm: QueueFarm) -> None:
    entry = await farm.add("wheat-1")
    await farm.arm()
    async with browser(farm, Role.VIEWER) as client:
        await client.post("/queue/disarm", json={})
    async with browser(farm, Role.OPERATOR) as client:
        await client.delete(f"/queue/entries/{entry.id}")
    assert farm.kept.audit.outcomes("queue") == ["added", "armed", "disarmed", "removed"]


async def test_a_mission_that_keeps_the_queue_waiting_is_named_and_can_be_taken_off(farm: QueueFarm) -> None:
    await farm.desk.missions.send(PIETER, "weeder-01", "wheat-3")
    await farm.step(2)
    await farm.add("wheat-1")
    await farm.step(2)
    async with browser(farm, Role.OPERATOR) as client:
        [robot] = (await client.get("/queue")).json()["robots"]
        assert robot["holds"] == {"mission_id": "wheat-3", "name": "Wheat 3"}
        other = await client.post("/queue/robots/weeder-01/take-off", json={"mission_id": "wheat-2"})
        assert (other.status_code, other.json()["code"]) == (409, "not_held")
        done = await client.post("/queue/robots/weeder-01/take-off", json={"mission_id": "wheat-3"})
        assert done.json()["text"].startswith("Wheat 3 gives way.")
        await farm.step(3)
        [robot] = (await client.get("/queue")).json()["robots"]
        assert robot["holds"] is None
    assert farm.weeder.holds == "wheat-1"
