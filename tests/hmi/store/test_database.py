"""The database: migrations, transactions and what its errors become."""

from __future__ import annotations

import asyncio
import stat
import threading
from pathlib import Path

import pytest
from alembic import command
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import inspect, text

from hmi.clock import FakeClock
from hmi.store.counters import Counters
from hmi.store.database import Database
from hmi.store.errors import AlreadyExists, DatabaseFull, DatabaseTooNew, DatabaseUnavailable
from hmi.store.farms import Farms
from hmi.store.features import Feature, Features
from hmi.store.migrations.upgrade import alembic_config, newest_version
from hmi.store.tables import Base, FarmRow
from tests.hmi.store.conftest import FARM


def test_migrations_make_the_tables_of_the_models(database: Database) -> None:
    with database.engine.begin() as connection:
        context = MigrationContext.configure(connection, opts={"compare_type": True})
        assert compare_metadata(context, Base.metadata) == []


def test_every_table_but_the_farm_belongs_to_a_farm() -> None:
    without = {table.name for table in Base.metadata.sorted_tables if "farm_id" not in table.columns}
    assert without == {"farm"}


def test_migrating_twice_changes_nothing(database: Database, clock: FakeClock) -> None:
    database.migrate()
    assert [farm.id for farm in Farms(database, clock).all()] == [FARM]


def test_migrations_can_be_taken_back_and_applied_again(tmp_path: Path) -> None:
    database = Database(f"sqlite:///{tmp_path / 'x.db'}")
    database.migrate()
    with database.connect_writing() as connection:
        command.downgrade(alembic_config(connection), "base")
        names = connection.execute(text("SELECT name FROM sqlite_master WHERE type = 'table'")).scalars().all()
    database.migrate()
    assert set(names) <= {"alembic_version", "sqlite_sequence"}
    assert database.is_reachable()
    database.close()


def test_the_features_of_a_map_stay_when_their_key_changes_and_changes_back(
    database: Database, clock: FakeClock
) -> None:
    Features(database, clock).put([Feature("north", FARM, "parcel", "North", {"type": "Point"}, {"crop": "Maize"})])
    with database.connect_writing() as connection:
        command.downgrade(alembic_config(connection), "0012")
        keys = inspect(connection).get_pk_constraint("feature")["constrained_columns"]
        indexes = [one["column_names"] for one in inspect(connection).get_indexes("feature")]
    assert (keys, indexes) == (["id"], [["farm_id"]])
    database.migrate()
    with database.connect_writing() as connection:
        keys = inspect(connection).get_pk_constraint("feature")["constrained_columns"]
    assert keys == ["farm_id", "id"]
    [kept] = Features(database, clock).all(FARM)
    assert (kept.id, kept.name, kept.properties) == ("north", "North", {"crop": "Maize"})


def test_the_newest_version_is_that_of_the_last_step(database: Database) -> None:
    with database.connect_writing() as connection:
        head = ScriptDirectory.from_config(alembic_config(connection)).get_current_head()
    assert newest_version() == head


def test_two_processes_may_migrate_at_the_same_time(tmp_path: Path) -> None:
    databases = [Database(f"sqlite:///{tmp_path / 'x.db'}") for _ in range(2)]
    threads = [threading.Thread(target=database.migrate) for database in databases]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(20)
    with databases[0].read() as session:
        assert session.execute(text("SELECT count(*) FROM alembic_version")).scalar_one() == 1
    for database in databases:
        database.close()


def test_a_database_of_a_newer_version_is_refused(database: Database) -> None:
    with database.write() as session:
        session.execute(text("UPDATE alembic_version SET version_num = '9999'"))
    with pytest.raises(DatabaseTooNew, match="another version"):
        database.migrate()


def test_a_folder_that_cannot_be_written_is_said_in_one_sentence(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(DatabaseUnavailable, match="cannot be opened"):
        Database(f"sqlite:///{tmp_path / 'file' / 'x.db'}")


def test_a_full_disk_is_told_from_a_database_that_is_away(database: Database) -> None:
    with pytest.raises(DatabaseFull):
        fill(database)


def fill(database: Database) -> None:
    """Do what fails as on a disk without room."""
    with database.write() as session:
        if database.engine.dialect.name != "sqlite":
            session.execute(text("DO $$ BEGIN RAISE EXCEPTION USING ERRCODE = '53100'; END $$"))
        session.execute(text("PRAGMA max_page_count = 1"))  # as many as there are: what is new finds no room
        session.execute(text("CREATE TABLE heap AS SELECT zeroblob(1000000) AS body"))


def test_a_file_that_is_no_database_is_said_to_be_unusable(tmp_path: Path) -> None:
    (tmp_path / "x.db").write_bytes(b"no database at all" * 100)
    database = Database(f"sqlite:///{tmp_path / 'x.db'}")
    with pytest.raises(DatabaseUnavailable):
        database.migrate()
    assert not database.is_reachable()
    database.close()


def test_a_database_in_memory_is_refused() -> None:
    with pytest.raises(ValueError, match="in memory"):
        Database("sqlite://")


def test_only_the_owner_can_read_the_file(tmp_path: Path) -> None:
    Database(f"sqlite:///{tmp_path / 'new.db'}").close()
    assert stat.S_IMODE((tmp_path / "new.db").stat().st_mode) == 0o600


def test_a_write_that_fails_leaves_nothing(database: Database, clock: FakeClock) -> None:
    with pytest.raises(AlreadyExists), database.write() as session:
        session.add_all(FarmRow(id=key, name="Other", created_at=clock.utc()) for key in ("other", FARM))
    assert [farm.id for farm in Farms(database, clock).all()] == [FARM]


def test_a_key_that_is_taken_is_told_apart_from_a_disk_that_fails(database: Database, clock: FakeClock) -> None:
    with pytest.raises(AlreadyExists), database.write() as session:
        session.add(FarmRow(id=FARM, name="Again", created_at=clock.utc()))


def test_readers_go_on_while_somebody_writes(database: Database, clock: FakeClock) -> None:
    with database.write() as session:
        session.add(FarmRow(id="other", name="Other", created_at=clock.utc()))
        session.flush()
        assert [farm.id for farm in Farms(database, clock).all()] == [FARM]


async def test_work_runs_in_a_thread_of_the_database(database: Database) -> None:
    name = await database.run(lambda: threading.current_thread().name)
    assert name.startswith("database")


async def test_epochs_only_grow_however_many_ask_at_once(database: Database) -> None:
    counters = Counters(database, FARM)
    given = await asyncio.gather(*(database.run(counters.next_epoch, "lease") for _ in range(20)))
    assert sorted(given) == list(range(1, 21))


def test_epochs_go_on_after_a_restart(database: Database) -> None:
    assert Counters(database, FARM).next_epoch("lease") == 1
    again = Database(database.url.render_as_string(hide_password=False))
    assert Counters(again, FARM).next_epoch("lease") == 2
    assert Counters(again, FARM).next_epoch("other") == 1
    again.close()
