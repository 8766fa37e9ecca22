"""Audit, events, history, health, diagnostics and metrics."""

from __future__ import annotations

import json

import httpx
import pytest
from sqlalchemy import text

from hmi.domain.role import Role
from hmi.store.audit_chain import AuditEntry
from tests.hmi.api.console import BASE, Console
from tests.hmi.commands.field import FARM


async def fill(console: Console, count: int) -> None:
    """Write some audit lines."""
    for number in range(count):
        console.audit.append(
            AuditEntry(FARM, "Martha Keller", "Tablet 1", "command", "accepted", "weeder-01", f"c-{number}", "pause")
        )
    await console.written("command")


async def test_the_audit_is_read_page_by_page_newest_first(console: Console) -> None:
    await fill(console, 5)
    client = await console.browser(Role.SUPERVISOR)
    first = (await client.get("/audit", params={"limit": 3, "kind": "command"})).json()
    assert [e["ref"] for e in first["entries"]] == ["c-4", "c-3", "c-2"]
    assert first["entries"][0]["robot_id"] == "weeder-01"
    rest = (await client.get("/audit", params={"limit": 3, "kind": "command", "before": first["next_before"]})).json()
    assert [e["ref"] for e in rest["entries"]] == ["c-1", "c-0"]
    assert rest["next_before"] is None


async def test_a_changed_audit_is_found(console: Console) -> None:
    await fill(console, 3)
    client = await console.browser(Role.SUPERVISOR)
    assert (await client.get("/audit/verify")).json()["is_whole"] is True
    with console.database.connect_writing() as connection:  # somebody with the file in hand removes the lock first
        names = connection.scalars(text("SELECT name FROM sqlite_master WHERE type = 'trigger'")).all()
        for name in names:
            connection.execute(text(f"DROP TRIGGER {name}"))
        connection.execute(text("UPDATE audit SET text = 'start' WHERE ref = 'c-1'"))
    verdict = (await client.get("/audit/verify")).json()
    assert verdict["is_whole"] is False
    assert verdict["first_broken_seq"] is not None


async def test_a_question_that_makes_no_sense_is_refused(console: Console) -> None:
    client = await console.browser(Role.SUPERVISOR)
    for query in ("limit=0", "limit=1001", "limit=x", "before=x"):
        answer = await client.get(f"/audit?{query}")
        assert (answer.status_code, answer.json()["code"]) == (422, "invalid"), query


async def test_history_and_track_of_a_quiet_hour_are_empty(console: Console) -> None:
    client = await console.browser(Role.VIEWER)
    answer = (await client.get("/history/weeder-01", params={"field": ["soc", "speed_mps"]})).json()
    assert (answer["fields"], answer["points"]) == (["soc", "speed_mps"], [])
    assert (await client.get("/history/weeder-01/track")).json()["points"] == []
    assert (await client.get("/events")).json() == {"events": []}


NONSENSE = [
    ("/history/weeder-01?field=password", "field"),
    ("/history/weeder-01?start=2026-05-04T10:00:00", "start"),
    ("/history/weeder-01?start=2026-05-04T10:00:00Z&end=2026-05-04T09:00:00Z", "start"),
    ("/history/weeder-01?start=1990-05-04T10:00:00Z", "start"),
    ("/history/weeder-01?start=0001-01-01T00:00:00%2B14:00", "start"),
    ("/history/weeder-01?points=5001", "points"),
    ("/events?kind=nonsense", "kind"),
    ("/events?start=nonsense", "start"),
]


async def test_a_span_or_field_that_is_none_is_refused(console: Console) -> None:
    client = await console.browser(Role.VIEWER)
    for path, field in NONSENSE:
        answer = await client.get(path)
        assert (answer.status_code, answer.json()["field"]) == (422, field), path


async def test_there_is_no_history_of_a_robot_nobody_registered(console: Console) -> None:
    client = await console.browser(Role.VIEWER)
    assert (await client.get("/history/weeder-77")).status_code == 404


def keep(console: Console, parts: dict[str, object]) -> None:
    """Write what the process keeper says."""
    (console.folder / "run").mkdir(exist_ok=True)
    (console.folder / "run" / "keeper.json").write_text(json.dumps({"pid": 1, "parts": parts}))


PARTS: dict[str, object] = {
    "console": {"state": "ok", "pid": 11, "restarts": 0, "url": None},
    "stop": {"state": "ok", "pid": 12, "restarts": 1, "url": "http://127.0.0.1:8081", "last_down": {"from_utc": "x"}},
    "broker": {"state": "ok", "pid": 13, "restarts": 0, "url": "mqtt://127.0.0.1:1883", "secret": "no"},
}


async def test_health_shows_every_part_to_anybody(console: Console) -> None:
    keep(console, PARTS)
    answer = await console.client().get("/health")
    body = answer.json()
    assert (answer.status_code, body["status"], body["version"]) == (200, "ok", "0.1.0")
    assert body["parts"]["stop"]["url"] == "http://127.0.0.1:8081"
    assert body["parts"]["broker"] == {"state": "ok", "url": "mqtt://127.0.0.1:1883", "restarts": 0}
    assert body["parts"]["database"] == {"state": "ok"}


CALLERS: list[tuple[str, dict[str, str], bool]] = [
    ("127.0.0.1", {}, True),
    ("::1", {}, True),
    ("10.0.0.5", {}, False),
    ("127.0.0.1", {"x-forwarded-for": "10.0.0.5"}, False),
    ("testclient", {}, False),
]


async def test_process_ids_are_told_on_this_machine_alone(console: Console) -> None:
    keep(console, PARTS)
    for host, headers, is_told in CALLERS:
        parts = (await console.client(host=host).get("/health", headers=headers)).json()["parts"]
        assert ("pid" in parts["stop"], "pid" in parts["console"]) == (is_told, is_told), host


async def test_health_tells_what_is_down(console: Console) -> None:
    client = console.client()
    keep(console, {**PARTS, "stop": {"state": "down", "pid": None}})
    assert (await client.get("/health")).json()["status"] == "degraded"
    console.broker_state = "down"
    answer = await client.get("/health")
    assert (answer.status_code, answer.json()["status"]) == (503, "failed")


@pytest.mark.parametrize(
    ("state", "restarts", "status"), [("starting", 0, "ok"), ("starting", 1, "degraded"), ("down", 0, "degraded")]
)
async def test_nobody_waits_for_media_and_cameras_but_their_fall_is_told(
    console: Console, state: str, restarts: int, status: str
) -> None:
    for part in ("media", "cameras"):
        keep(console, {**PARTS, part: {"state": state, "pid": 14, "restarts": restarts}})
        assert (await console.client().get("/health")).json()["status"] == status


async def test_health_tells_of_a_database_that_is_away(console: Console) -> None:
    console.is_database_up = False
    body = (await console.client().get("/health")).json()
    assert (body["status"], body["parts"]["database"]["state"]) == ("degraded", "down")


async def test_health_survives_a_keeper_file_that_is_broken(console: Console) -> None:
    (console.folder / "run").mkdir()
    for content in ("", "{", "[]", '{"parts": 5}', '{"parts": {"stop": 5}}'):
        (console.folder / "run" / "keeper.json").write_text(content)
        body = (await console.client().get("/health")).json()
        assert body["parts"]["console"]["state"] == "ok", content


async def test_diagnostics_put_counters_beside_each_other(console: Console) -> None:
    client = await console.browser(Role.VIEWER)
    body = (await client.get("/diagnostics")).json()
    assert body["ingest"] == {"messages": 7}
    assert body["health"]["parts"]["broker"]["state"] == "ok"
    assert body["clock"]["utc"].startswith("2026-05-04T12:00")


async def test_metrics_count_orders_and_read_gauges(console: Console) -> None:
    client = await console.browser(Role.OPERATOR)
    body = {"command_id": "command-1", "action": "return_home", "tick": console.field.tick()}
    await client.post("/robots/weeder-01/commands", json=body)
    page: httpx.Response = await console.client().get(f"{BASE}/metrics")
    assert page.headers["content-type"].startswith("text/plain")
    assert 'headland_orders_total{action="return_home",outcome="accepted"} 1.0' in page.text
    assert "headland_order_answer_seconds_bucket" in page.text
    assert "headland_lanes 3.0" in page.text
