"""The routes of base maps on a fresh database and folder; files are made in this process."""

from __future__ import annotations

import asyncio
import hashlib
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest
from fastapi import FastAPI

from hmi.api import errors
from hmi.api.access import Access
from hmi.api.base_maps import OnlineMap, base_map_routes
from hmi.api.limits import BodyLimit
from hmi.base_maps.facts import MadeBaseMap
from hmi.base_maps.files import BaseMapFiles
from hmi.base_maps.worker import make_base_map
from hmi.clock import FakeClock
from hmi.commands.base_map_book import BaseMapBook, BaseMapParts
from hmi.domain.role import Role
from hmi.store.base_maps import BaseMapRecords
from hmi.store.database import Database
from tests.hmi.missions.conftest import migrated as migrated
from tests.hmi.missions.rig import FARM, Door, NoTokens, Rig


class HereMaker:
    """Makes base maps at once, or waits until a test lets it."""

    def __init__(self) -> None:
        self.go_on = asyncio.Event()
        self.go_on.set()
        self.begun = asyncio.Event()

    async def make(
        self, source: Path, target: Path, most_bytes: int, on_progress: Callable[[float], None]
    ) -> MadeBaseMap:
        """Return what was made."""
        on_progress(0.5)
        self.begun.set()
        await self.go_on.wait()
        facts = make_base_map(source, target, most_bytes, on_progress)
        data = await asyncio.to_thread(target.read_bytes)
        return MadeBaseMap(facts, hashlib.sha256(data).hexdigest(), len(data))


class BaseMapRig(Rig):
    """The farm of the mission tests with room for base maps."""

    def __init__(self, database: Database, clock: FakeClock, folder: Path) -> None:
        super().__init__(database, clock)
        self.folder = folder
        self.maker = HereMaker()
        self.events: list[dict[str, Any]] = []
        self.base_maps = self.book_with()

    def book_with(self, farm_bytes: int = 5_000_000, upload_bytes: int = 2_000_000) -> BaseMapBook:
        """Return a console with these limits."""
        return BaseMapBook(
            BaseMapParts(
                BaseMapRecords(self.database), BaseMapFiles(self.folder), self.maker, self.database, self.authorize,
                self.audit, self.clock, self.events.append, farm_bytes, upload_bytes,
            )
        )  # fmt: skip

    def browser(self, role: Role, farm_id: str = FARM, online: OnlineMap | None = None) -> httpx.AsyncClient:
        """Return a browser of somebody, at the routes of base maps."""
        app = FastAPI()
        app.state.access = Access(Door(self.person(role, farm_id)), NoTokens(), self.authorize)
        app.include_router(base_map_routes(self.base_maps, online))
        errors.install(app)
        app.add_middleware(BodyLimit)
        return httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://console.local")


@pytest.fixture
def rig(tmp_path: Path, migrated: Path) -> Iterator[BaseMapRig]:
    """Return a farm without a base map."""
    shutil.copyfile(migrated, tmp_path / "headland.db")
    database = Database(f"sqlite:///{tmp_path / 'headland.db'}")
    yield BaseMapRig(database, FakeClock(), tmp_path / "base_maps")
    database.close()
