"""A migrated database with one farm, on a fake clock."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from uuid import uuid4

import pytest
from sqlalchemy import create_engine, text

from hmi.clock import FakeClock
from hmi.store.database import Database
from hmi.store.farms import Farms
from tests.hmi.store.cluster import cluster, programs

FARM = "farm"
KINDS = ["sqlite", pytest.param("postgresql", marks=pytest.mark.long)]


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


@pytest.fixture(scope="session")
def server() -> Iterator[str]:
    """Yield the URL of a PostgreSQL server whose database ``migrated`` has all tables and one farm."""
    bin_folder = programs()
    if bin_folder is None:
        pytest.skip("PostgreSQL is not installed (Debian: apt-get install postgresql)")
    with cluster(bin_folder) as url:
        _statement(url, "CREATE DATABASE migrated")
        database = Database(f"{url}/migrated")
        database.migrate()
        Farms(database, FakeClock()).ensure(FARM, "My farm")
        database.close()
        yield url


@pytest.fixture(params=KINDS)
def database(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Database]:
    """Return a database with nothing but the farm in it: SQLite, and in long rounds PostgreSQL too."""
    if request.param == "sqlite":
        shutil.copyfile(request.getfixturevalue("migrated"), tmp_path / "headland.db")
        (tmp_path / "headland.db").chmod(0o600)
        database = Database(f"sqlite:///{tmp_path / 'headland.db'}")
        yield database
        database.close()
        return
    url, name = request.getfixturevalue("server"), f"t{uuid4().hex}"
    _statement(url, f"CREATE DATABASE {name} TEMPLATE migrated")
    database = Database(f"{url}/{name}")
    yield database
    database.close()
    _statement(url, f"DROP DATABASE {name} WITH (FORCE)")


def _statement(url: str, statement: str) -> None:
    engine = create_engine(f"{url}/postgres", isolation_level="AUTOCOMMIT")
    with engine.connect() as connection:
        connection.execute(text(statement))
    engine.dispose()
