"""A farm with queues on a fresh database."""

from __future__ import annotations

import shutil
from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from hmi.clock import FakeClock
from hmi.store.database import Database
from hmi.store.farms import Farms
from tests.hmi.commands.field import FARM
from tests.hmi.queue.rig import QueueFarm


@pytest.fixture(scope="session")
def migrated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a database file with all tables and one farm, to be copied."""
    path = tmp_path_factory.mktemp("queue") / "headland.db"
    database = Database(f"sqlite:///{path}")
    database.migrate()
    Farms(database, FakeClock()).ensure(FARM, FARM)
    database.close()
    return path


@pytest.fixture
async def farm(tmp_path: Path, migrated: Path) -> AsyncIterator[QueueFarm]:
    """Return a farm with one robot that may run unattended, and three missions."""
    shutil.copyfile(migrated, tmp_path / "headland.db")
    made = await QueueFarm.open(tmp_path)
    yield made
    await made.close()
