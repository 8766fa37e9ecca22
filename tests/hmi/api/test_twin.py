"""The twin over REST: who may replay, whose models are kept, what is said when it is away."""

from __future__ import annotations

from collections.abc import AsyncIterator
from datetime import timedelta
from typing import Any

import httpx
import pytest
from sqlalchemy import insert

from hmi.api.twin import ModelRefused, ModelsAway, TwinRoutes, twin_routes
from hmi.domain.role import Role
from hmi.store.history import History
from hmi.store.tables import SampleRow
from tests.hmi.api.console import Console
from tests.hmi.commands.field import FARM

TOLD = {"name": "own", "links": 2, "joints": ["lift"], "faces": 24, "notices": []}


class Models:
    """Keeps one model; ``is_away`` and ``refusal`` say otherwise."""

    def __init__(self) -> None:
        self.kept: bytes | None = None
        self.is_away, self.refusal = False, ""

    async def describe(self, robot_id: str) -> dict[str, Any]:
        """See ``ModelKeeper``."""
        self._check()
        return {"kept": False} if self.kept is None else {"kept": True, **TOLD}

    async def take(self, robot_id: str, chunks: AsyncIterator[bytes]) -> dict[str, Any]:
        """See ``ModelKeeper``."""
        data = b"".join([chunk async for chunk in chunks])
        self._check()
        self.kept = data
        return TOLD

    async def remove(self, robot_id: str) -> bool:
        """See ``ModelKeeper``."""
        self._check()
        was, self.kept = self.kept, None
        return was is not None

    async def status(self) -> dict[str, Any] | None:
        """See ``ModelKeeper``."""
        return None if self.is_away else {"pictures": 2, "robots": 24, "pid": 1}

    def _check(self) -> None:
        if self.is_away:
            raise ModelsAway
        if self.refusal:
            raise ModelRefused("unsafe_model", self.refusal)


@pytest.fixture
def models(console: Console) -> Models:
    """Return the keeper of models behind the console's routes."""
    made = Models()
    history = History(console.database, FARM)
    parts = TwinRoutes(
        made, history, console.registry, console.database, console.authorize, console.audit, console.field.clock
    )
    console.api.include_router(twin_routes(parts))
    return made


async def replay(console: Console, client: httpx.AsyncClient, minutes: float = 10) -> httpx.Response:
    """Ask for the last minutes."""
    now = console.field.clock.utc()
    span = {"from": (now - timedelta(minutes=minutes)).isoformat(), "to": now.isoformat()}
    return await client.get("/robots/weeder-01/replay", params=span)


async def test_a_replay_has_places_joints_and_events_in_columns(console: Console, models: Models) -> None:
    now = console.field.clock.utc()
    with console.database.connect_writing() as connection:
        for second in range(5):
            joints = None if second == 0 else {"pan": 0.25 * second}
            row = {"farm_id": FARM, "robot_id": "weeder-01", "at": now - timedelta(seconds=60 - second), "period_s": 1,
                   "lat_deg": 52.0, "lon_deg": 5.0 + second / 1e6, "theta_rad": 0.5, "joints": joints}  # fmt: skip
            connection.execute(insert(SampleRow), [row])
    found = (await replay(console, await console.browser(Role.SUPERVISOR))).json()
    assert len(found["t"]) == 5
    assert found["joints"] == {"pan": [None, 0.25, 0.5, 0.75, 1.0]}
    assert found["lon"][4] == 5.000004
    assert found["t"][1] - found["t"][0] == 1000
    assert found["height"] == [None] * 5
    client = await console.browser(Role.SUPERVISOR)
    assert (await client.get("/robots/weeder-01/replay", params={"minutes": 10})).json()["t"] == found["t"]
    assert (await client.get("/robots/weeder-01/replay")).status_code == 422


@pytest.mark.parametrize("role", [Role.VIEWER, Role.OPERATOR])
async def test_replay_needs_the_supervisor_role(console: Console, models: Models, role: Role) -> None:
    answer = await replay(console, await console.browser(role))
    assert answer.status_code == 403
    assert "Replay needs the supervisor role." in answer.json()["text"]


async def test_a_replay_of_a_day_is_refused(console: Console, models: Models) -> None:
    answer = await replay(console, await console.browser(Role.SUPERVISOR), minutes=1440)
    assert (answer.status_code, answer.json()["field"]) == (422, "from")


async def test_an_admin_uploads_looks_at_and_removes_a_model(console: Console, models: Models) -> None:
    admin = await console.browser(Role.ADMIN)
    assert (await admin.get("/robots/weeder-01/model")).json() == {"kept": False}
    answer = await admin.post("/robots/weeder-01/model", content=b"x" * 3_000_000)
    assert (answer.status_code, answer.json()["joints"]) == (200, ["lift"])
    assert models.kept is not None
    assert len(models.kept) == 3_000_000, "more than other bodies may have"
    assert (await admin.get("/robots/weeder-01/model")).json()["kept"] is True
    assert (await admin.delete("/robots/weeder-01/model")).json() == {"kept": False}
    await console.written("robot_model")


@pytest.mark.slow
@pytest.mark.parametrize("role", [Role.VIEWER, Role.SUPERVISOR])
async def test_only_admins_change_models(console: Console, models: Models, role: Role) -> None:
    client = await console.browser(role)
    assert (await client.post("/robots/weeder-01/model", content=b"x")).status_code == 403
    assert (await client.delete("/robots/weeder-01/model")).status_code == 403
    assert (await client.get("/robots/weeder-01/model")).status_code == 200


async def test_what_is_wrong_with_a_model_is_told(console: Console, models: Models) -> None:
    models.refusal = 'Link "arm": "../x.stl" lies outside the upload. It is refused.'
    answer = await (await console.browser(Role.ADMIN)).post("/robots/weeder-01/model", content=b"x")
    assert (answer.status_code, answer.json()["code"]) == (422, "unsafe_model")
    assert answer.json()["text"] == models.refusal


async def test_a_twin_that_is_away_says_so(console: Console, models: Models) -> None:
    client = await console.browser(Role.VIEWER)
    assert (await client.get("/twin/status")).json()["state"] == "ok"
    models.is_away = True
    assert (await client.get("/twin/status")).json() == {"state": "down", "pictures": 0}
    assert (await client.get("/robots/weeder-01/model")).status_code == 503


async def test_an_unknown_robot_is_not_found(console: Console, models: Models) -> None:
    client = await console.browser(Role.ADMIN)
    assert (await client.get("/robots/nobody/model")).status_code in (403, 404)
