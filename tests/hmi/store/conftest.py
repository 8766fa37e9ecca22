"""A migrated database with one farm, on a fake clock."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from hmi.clock import FakeClock
from hmi.store.database import Database
from hmi.store.farms import Farms

FARM = "farm"


@pytest.fixture
def clock() -> FakeClock:
    """Return a clock that stands still."""
    return FakeClock()


@pytest.fixture(scope="session")
def migrated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a database file with all tables and one farm, to be copied: migrating anew for each test takes long."""
    path = tmp_path_factory.mktemp("migrated") / "headland.db"
    database = Database(f"sqlite:///{path}")
    database.migrate()
    Farms(database, FakeClock()).ensure(FARM, "My farm")
    database.close()
    return path


@pytest.fixture
def database(tmp_path: Path, migrated: Path) -> Iterator[Database]:
    """Return a database with nothing but the farm in it."""
    shutil.copyfile(migrated, tmp_path / "headland.db")
    (tmp_path / "headland.db").chmod(0o600)
    database = Database(f"sqlite:///{tmp_path / 'headland.db'}")
    yield database
    database.close()
