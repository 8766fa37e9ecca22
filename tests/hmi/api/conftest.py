"""A console for each test."""

from __future__ import annotations

from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from hmi.clock import FakeClock
from hmi.store.database import Database
from hmi.store.farms import Farms
from tests.hmi.api.console import Console
from tests.hmi.commands.field import FARM


@pytest.fixture(scope="session")
def migrated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a database file with all tables and one farm, to be copied."""
    path = tmp_path_factory.mktemp("api") / "headland.db"
    database = Database(f"sqlite:///{path}")
    database.migrate()
    Farms(database, FakeClock()).ensure(FARM, "My farm")
    database.close()
    return path


@pytest.fixture
async def console(tmp_path: Path, migrated: Path) -> AsyncIterator[Console]:
    """Return a console with one registered weeder."""
    console = Console(tmp_path, migrated)
    await console.database.run(console.register)
    yield console
    await console.close()
