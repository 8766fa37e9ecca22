"""The chart and the times in states by REST."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable
from datetime import timedelta
from typing import Any

from sqlalchemy import insert

from hmi.domain.role import Role
from hmi.store.tables import Base, EventRow, MissionLogRow, MissionRow, SampleRow
from tests.hmi.api.console import Console
from tests.hmi.commands.field import FARM


async def record(console: Console, state: str, ago_s: float, lasted_s: float | None = None, **more: Any) -> None:
    """Put a change of state on record."""
    end = lasted_s is not None
    data: dict[str, Any] = {"state": state, "path": ["Mission", state.title()], "subsystem": "Crane", "is_leaf": True}
    if lasted_s is not None:
        data |= {"duration_ms": lasted_s * 1000, "result": "OK"}
    row = {
        "robot_id": "weeder-01", "id": f"{state}-{ago_s}-{end}", "farm_id": FARM, "mission_id": "m-1", "text": "",
        "at": console.field.clock.utc() - timedelta(seconds=ago_s), "kind": "state_left" if end else "state_entered",
        "name": state.title(), "data": data,
    }  # fmt: skip
    await write(console, EventRow, [{**row, **more}])


async def log(console: Console, mission_id: str, ago_s: dict[str, float]) -> None:
    """Put a mission's life on record."""
    rows = [
        {"farm_id": FARM, "mission_id": mission_id, "at": console.field.clock.utc() - timedelta(seconds=ago),
         "status": status, "by": "weeder-01", "why": "", "data": {}}
        for status, ago in ago_s.items()
    ]  # fmt: skip
    now = console.field.clock.utc()
    mission = {"id": mission_id, "farm_id": FARM, "name": "Weed", "field_name": "North", "document": {}, "sha256": "",
               "created_by": "ana", "created_at": now, "updated_at": now}  # fmt: skip
    await write(console, MissionRow, [mission])
    await write(console, MissionLogRow, rows)


async def heard(console: Console, ago_s: Iterable[float]) -> None:
    """Put on record when the robot was heard."""
    now = console.field.clock.utc()
    rows = [{"farm_id": FARM, "robot_id": "weeder-01", "at": now - timedelta(seconds=ago)} for ago in ago_s]
    await write(console, SampleRow, rows)


async def write(console: Console, table: type[Base], rows: list[dict[str, Any]]) -> None:
    """Insert rows as they are."""

    def insert_all() -> None:
        with console.database.connect_writing() as connection:
            connection.execute(insert(table), rows)

    await console.database.run(insert_all)


async def lap(console: Console) -> None:
    """Put two states, one after the other, on record."""
    await record(console, "dock", 100)
    await record(console, "dock", 80, 20)
    await record(console, "plant", 80)
    await record(console, "plant", 50, 30)


async def test_times_are_of_the_span_asked_for_with_sums(console: Console) -> None:
    await lap(console)
    client = await console.browser(Role.VIEWER)
    found = (await client.get("/robots/weeder-01/state-times", params={"minutes": 10})).json()
    assert [(one["state"], round((one["end"] - one["start"]) / 1000)) for one in found["intervals"]] == [
        ("dock", 20),
        ("plant", 30),
    ]
    assert found["share"] == [{"subsystem": "Crane", "label": "Crane", "s": 50, "share": 1}]
    assert {one["state"]: one["mean_s"] for one in found["per_state"]} == {"plant": 30, "dock": 20}
    now = console.field.clock.utc()
    span = {"from": (now - timedelta(seconds=90)).isoformat(), "to": (now - timedelta(seconds=70)).isoformat()}
    part = (await client.get("/robots/weeder-01/state-times", params=span)).json()
    assert {one["state"]: one["total_s"] for one in part["per_state"]} == {"plant": 10, "dock": 10}
    assert part["wall_s"] == 20


async def test_a_mission_is_from_its_first_to_its_last_change(console: Console) -> None:
    await lap(console)
    await record(console, "dock", 20, 10, mission_id="m-2")
    client = await console.browser(Role.VIEWER)
    found = (await client.get("/robots/weeder-01/state-times", params={"mission": "m-1"})).json()
    assert found["wall_s"] == 50
    gone = await client.get("/robots/weeder-01/state-times", params={"mission": "m-9"})
    assert (gone.status_code, gone.json()["code"]) == (404, "not_found")


async def test_a_mission_that_only_lay_on_the_robot_is_not_counted(console: Console) -> None:
    await record(console, "idle", 4000)
    await lap(console)
    await record(console, "idle", 30, 5)
    await log(console, "m-1", {"accepted": 4000, "running": 105, "done": 45})
    client = await console.browser(Role.VIEWER)
    found = (await client.get("/robots/weeder-01/state-times", params={"mission": "m-1"})).json()
    assert found["wall_s"] == 60, "from its start to its end"


async def test_a_power_cut_is_no_work(console: Console) -> None:
    await record(console, "dock", 3600)
    await record(console, "plant", 100)
    await record(console, "plant", 50, 50)
    await heard(console, [*range(3650, 3500, -5), *range(120, 0, -5)])
    client = await console.browser(Role.VIEWER)
    found = (await client.get("/robots/weeder-01/state-times", params={"minutes": 120})).json()
    assert {one["state"]: one["total_s"] for one in found["per_state"]} == {"dock": 95, "plant": 50}


async def test_the_newest_changes_come_first_with_how_long_the_state_before_took(console: Console) -> None:
    await lap(console)
    client = await console.browser(Role.VIEWER)
    (one,) = (await client.get("/robots/weeder-01/transitions")).json()["transitions"]
    assert (one["source"], one["target"], one["result"], one["duration_s"]) == ("dock", "plant", "OK", 20)


async def test_the_table_has_every_stay_and_no_formula(console: Console) -> None:
    await lap(console)
    await record(console, "dock", 10, 5, name="=cmd()")
    client = await console.browser(Role.VIEWER)
    answer = await client.get("/robots/weeder-01/state-times.csv", params={"minutes": 5})
    assert answer.headers["content-type"].startswith("text/csv")
    rows = list(csv.DictReader(io.StringIO(answer.text)))
    assert [row["label"] for row in rows] == ["Dock", "Plant", "'=cmd()"]
    assert rows[0]["path"] == "Mission > Dock"


async def test_what_makes_no_sense_is_refused_and_who_is_not_signed_in_gets_nothing(console: Console) -> None:
    client = await console.browser(Role.VIEWER)
    path = "/robots/weeder-01/state-times"
    for query in ("minutes=0", "from=2026-01-01T00:00:00Z", "from=2026-01-01T00:00:00&to=2026-01-02T00:00:00",
                  "from=2026-01-02T00:00:00Z&to=2026-01-01T00:00:00Z"):  # fmt: skip
        assert (await client.get(f"{path}?{query}")).status_code == 422, query
    assert (await client.get("/robots/weeder-99/chart")).status_code == 404
    chart = await client.get("/robots/weeder-01/chart")
    assert (chart.status_code, chart.json()["code"]) == (404, "no_chart")
    for route in (path, f"{path}.csv", "/robots/weeder-01/chart", "/robots/weeder-01/transitions"):
        assert (await console.client().get(route)).status_code == 401, route
