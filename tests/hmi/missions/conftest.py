"""A rig on a fresh database."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from hmi.clock import FakeClock
from hmi.store.database import Database
from hmi.store.farms import Farms
from tests.hmi.missions.rig import FARM, OTHER_FARM, Rig


@pytest.fixture(scope="session")
def migrated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a database file with all tables and two farms, to be copied."""
    path = tmp_path_factory.mktemp("missions") / "headland.db"
    database = Database(f"sqlite:///{path}")
    database.migrate()
    for farm in (FARM, OTHER_FARM):
        Farms(database, FakeClock()).ensure(farm, farm)
    database.close()
    return path


@pytest.fixture
def rig(tmp_path: Path, migrated: Path) -> Iterator[Rig]:
    """Return missions, map and routes of one farm."""
    shutil.copyfile(migrated, tmp_path / "headland.db")
    database = Database(f"sqlite:///{tmp_path / 'headland.db'}")
    yield Rig(database, FakeClock())
    database.close()
