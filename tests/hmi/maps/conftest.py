"""The map builder's routes on a fresh database."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest
from fastapi import FastAPI

from hmi.api import errors
from hmi.api.access import Access
from hmi.api.maps import map_routes
from hmi.clock import FakeClock
from hmi.commands.map_book import MapBook, MapParts
from hmi.commands.map_exchange import MapExchange, Reader
from hmi.commands.map_review import MapReview
from hmi.domain.role import Role
from hmi.map_files.imported import Imported
from hmi.map_files.progress import Report
from hmi.map_files.reader import read_map
from hmi.store.database import Database
from hmi.store.maps import Maps
from tests.hmi.missions.conftest import migrated as migrated
from tests.hmi.missions.rig import FARM, Door, NoTokens, Rig

Client = Callable[..., httpx.AsyncClient]


class HereReader:
    """Reads files in this process, at once."""

    async def read(self, data: bytes, name: str, on_progress: Report | None = None) -> Imported:
        """Return what the file holds."""
        return read_map(data, name, on_progress)


class MapRig(Rig):
    """The farm of the mission tests, with its map open to change."""

    def __init__(self, database: Database, clock: FakeClock) -> None:
        super().__init__(database, clock)
        self.events: list[dict[str, Any]] = []
        self.maps = Maps(database, clock)
        self.widths: dict[str, float] = {}
        parts = MapParts(
            self.maps, database, self.authorize, self.audit, clock, self.events.append, lambda one: self.widths.get(one)
        )
        self.map_book, self.review = MapBook(parts), MapReview(parts)
        self.exchange = MapExchange(self.map_book, HereReader(), self.authorize, "My farm")

    def read_with(self, reader: Reader) -> MapExchange:
        """Let files be read by another reader."""
        self.exchange = MapExchange(self.map_book, reader, self.authorize, "My farm")
        return self.exchange

    def browser(self, role: Role, farm_id: str = FARM) -> httpx.AsyncClient:
        """Return a browser of somebody, at the map's routes."""
        app = FastAPI()
        app.state.access = Access(Door(self.person(role, farm_id)), NoTokens(), self.authorize)
        app.include_router(map_routes(self.map_book, self.review, self.exchange))
        errors.install(app)
        return httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://console.local")


@pytest.fixture
def rig(tmp_path: Path, migrated: Path) -> Iterator[MapRig]:
    """Return a farm with a map."""
    shutil.copyfile(migrated, tmp_path / "headland.db")
    database = Database(f"sqlite:///{tmp_path / 'headland.db'}")
    yield MapRig(database, FakeClock())
    database.close()
