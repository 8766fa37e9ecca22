"""The audit: a chain that shows every change, and a writer that is in nobody's way."""

from __future__ import annotations

import math
from collections.abc import Iterator
from datetime import timedelta
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from sqlalchemy import insert, text

from hmi.clock import FakeClock
from hmi.store.audit import Audit, AuditEntry
from hmi.store.audit_chain import GENESIS, digest, plain, plain_fields
from hmi.store.database import Database
from hmi.store.errors import StoreError
from hmi.store.farms import Farms
from hmi.store.tables import AuditRow
from tests.hmi.store.conftest import FARM

WAIT_S = 10.0
MANY = 600  # with every probe of a machine that is slow to take the file back


LOCKED_FILE = pytest.mark.parametrize("database", ["sqlite"], indirect=True)  # PostgreSQL has no file to lock


@pytest.fixture
def spill(tmp_path: Path) -> Path:
    """Return where entries go while the database is away."""
    return tmp_path / "audit-spill.jsonl"


@pytest.fixture
def audit(database: Database, clock: FakeClock, spill: Path) -> Iterator[Audit]:
    """Return a running audit."""
    audit = Audit(database, clock, spill, capacity=50, retry_s=0.02)
    audit.start()
    yield audit
    audit.close(WAIT_S)


def entry(ref: str = "a", **more: Any) -> AuditEntry:
    """Return an entry about a command."""
    return AuditEntry(FARM, "Martha Keller", "Tablet 3", "command", "accepted", "weeder-01", ref, **more)


def tamper(database: Database, statement: str) -> None:
    """Change the table as somebody with the file in hand could: without our triggers."""
    with database.connect_writing() as connection:
        if database.url.get_backend_name() == "postgresql":
            connection.execute(text("ALTER TABLE audit DISABLE TRIGGER USER"))
            connection.execute(text(statement))
            connection.execute(text("ALTER TABLE audit ENABLE TRIGGER USER"))
            return
        guards = connection.execute(text("SELECT name, sql FROM sqlite_master WHERE type = 'trigger'")).all()
        for name, _sql in guards:
            connection.execute(text(f"DROP TRIGGER {name}"))
        connection.execute(text(statement))
        for _name, sql in guards:
            connection.execute(text(sql))


def write(audit: Audit, count: int) -> None:
    """Record ``count`` entries and wait for them."""
    for number in range(count):
        audit.append(entry(f"ref-{number}", data={"n": number, "speed": 0.1 * number}))
    assert audit.flush(WAIT_S)


def test_entries_come_back_newest_first(audit: Audit, clock: FakeClock) -> None:
    audit.append(entry("first", text="Start", data={"speed_mps": 0.42}))
    clock.advance(1)
    audit.append(entry("second"))
    assert audit.flush(WAIT_S)
    second, first = audit.recent(FARM)
    assert (first.ref, second.ref) == ("first", "second")
    assert first.data == {"speed_mps": 0.42}
    assert second.at - first.at == timedelta(seconds=1)
    assert [record.ref for record in audit.recent(FARM, before_seq=second.seq)] == ["first"]
    assert audit.recent(FARM, robot_id="weeder-02") == []


def test_an_untouched_chain_is_whole(audit: Audit) -> None:
    write(audit, 30)
    verdict = audit.verify(FARM)
    assert (verdict.rows, verdict.first_broken_seq) == (30, None)
    assert verdict.head == audit.recent(FARM, 1)[0].hash


@pytest.mark.parametrize(
    "column_and_value",
    ["text = 'x'", "actor = 'x'", "at = '2020-01-01T00:00:00.000+00:00'", "outcome = 'x'", "robot_id = NULL",
     "data = '{\"n\": 99}'", "ref = 'x'", "device = 'x'", "kind = 'x'"],
)  # fmt: skip
def test_a_changed_row_is_named(audit: Audit, database: Database, column_and_value: str) -> None:
    write(audit, 12)
    tamper(database, f"UPDATE audit SET {column_and_value} WHERE seq = 7")
    assert audit.verify(FARM).first_broken_seq == 7


@pytest.mark.parametrize(
    ("statement", "broken"),
    [
        ("DELETE FROM audit WHERE seq = 7", 8),
        ("DELETE FROM audit WHERE seq < 5", 5),
        ("UPDATE audit SET seq = CASE seq WHEN 3 THEN 100 WHEN 4 THEN 3 ELSE seq END WHERE seq IN (3, 4)", 3),
        ("INSERT INTO audit SELECT 200, farm_id, at, actor, device, kind, robot_id, ref, outcome, text, data, "
         "previous_hash, hash FROM audit WHERE seq = 12", 200),
    ],
)  # fmt: skip
def test_rows_taken_out_moved_or_put_in_are_named(
    audit: Audit, database: Database, statement: str, broken: int
) -> None:
    write(audit, 12)
    tamper(database, statement)
    assert audit.verify(FARM).first_broken_seq == broken


def test_a_cut_off_end_is_shown_by_a_head_noted_earlier(audit: Audit, database: Database) -> None:
    write(audit, 12)
    head = audit.verify(FARM).head
    write(audit, 3)
    assert audit.verify(FARM, head).first_broken_seq is None
    tamper(database, "DELETE FROM audit WHERE seq > 10")
    assert audit.verify(FARM).first_broken_seq is None
    assert audit.verify(FARM, head).text == "The end of the record was cut off."


@pytest.mark.parametrize("statement", ["UPDATE audit SET text = 'x'", "DELETE FROM audit"])
def test_the_database_itself_refuses_to_change_entries(audit: Audit, database: Database, statement: str) -> None:
    write(audit, 2)
    with pytest.raises(StoreError, match="append-only"), database.write() as session:
        session.execute(text(statement))
    assert audit.verify(FARM).rows == 2


def test_every_farm_has_a_chain_of_its_own(audit: Audit, database: Database, clock: FakeClock) -> None:
    Farms(database, clock).ensure("north", "North")
    for number in range(6):
        audit.append(AuditEntry("north" if number % 2 else FARM, "a", "", "command", "ok", ref=str(number)))
    assert audit.flush(WAIT_S)
    assert audit.verify(FARM).rows == audit.verify("north").rows == 3
    assert [record.ref for record in audit.recent("north")] == ["5", "3", "1"]


def test_two_consoles_write_one_chain(audit: Audit, database: Database, clock: FakeClock, tmp_path: Path) -> None:
    other = Audit(database, clock, tmp_path / "other.jsonl")
    other.start()
    for number in range(40):
        (audit if number % 2 else other).append(entry(str(number)))
    assert audit.flush(WAIT_S)
    assert other.close(WAIT_S)
    assert audit.verify(FARM).rows == 40
    assert audit.verify(FARM).first_broken_seq is None


class Locked:
    """Holds the database's write lock, so that nobody else can write."""

    def __init__(self, database: Database) -> None:
        self._connection = database.engine.raw_connection()

    def __enter__(self) -> None:
        self._connection.cursor().execute("BEGIN IMMEDIATE")

    def __exit__(self, *_error: object) -> None:
        self._connection.rollback()
        self._connection.close()


@pytest.fixture
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a locked database fail at once instead of after five seconds."""
    monkeypatch.setattr("hmi.store.database.BUSY_TIMEOUT_MS", 1)


@pytest.fixture
def quick(impatient: None, database: Database, clock: FakeClock, spill: Path) -> Iterator[Audit]:
    """Return an audit that meets a locked database quickly."""
    own = Database(database.url.render_as_string(hide_password=False))
    audit = Audit(own, clock, spill, capacity=20, retry_s=0.02)
    audit.start()
    yield audit
    audit.close(WAIT_S)
    own.close()


def until_taken_back(audit: Audit) -> None:
    """Wait until nothing is left in the file: a fresh entry is written after it."""
    for _ in range(MANY - 100):
        audit.append(entry("probe"))
        assert audit.flush(WAIT_S)
        if not audit.health().is_spilling:
            return
    pytest.fail("the file was never taken back")


@LOCKED_FILE
def test_entries_wait_in_a_file_while_the_database_is_locked(quick: Audit, database: Database, spill: Path) -> None:
    with Locked(database):
        write(quick, 5)
        assert quick.health().is_spilling
        assert not quick.health().is_ok
        assert len(spill.read_text().splitlines()) == 5
    until_taken_back(quick)
    refs = [record.ref for record in reversed(quick.recent(FARM, MANY)) if record.ref != "probe"]
    assert refs == [f"ref-{number}" for number in range(5)]
    assert quick.verify(FARM).first_broken_seq is None
    assert quick.health().is_ok


@LOCKED_FILE
def test_what_an_earlier_run_left_in_the_file_is_taken_back(
    quick: Audit, database: Database, clock: FakeClock, spill: Path
) -> None:
    with Locked(database):
        write(quick, 3)
        quick.close(WAIT_S)
    with spill.open("a") as file:
        file.write('{"torn')
    again = Audit(database, clock, spill)
    again.start()
    until_taken_back(again)
    assert again.verify(FARM).rows >= 3
    assert again.health().lost == 1
    again.close(WAIT_S)


@LOCKED_FILE
def test_with_disk_and_database_gone_entries_are_counted_and_the_gap_is_recorded(
    quick: Audit, database: Database, spill: Path
) -> None:
    spill.mkdir()  # a folder in the way: the file cannot be written
    with Locked(database):
        for number in range(35):
            quick.append(entry(str(number)))
        assert not quick.flush(0.2)
        assert quick.health().lost == 15
        assert not quick.health().writer.is_ok
    spill.rmdir()
    assert quick.flush(WAIT_S)
    until_taken_back(quick)
    gaps = [record for record in quick.recent(FARM, MANY) if record.outcome == "lost"]
    assert sum(gap.data["count"] for gap in gaps) == 15


def test_an_entry_of_no_farm_is_counted_and_holds_nobody_up(audit: Audit) -> None:
    audit.append(AuditEntry("nowhere", "a", "", "command", "ok"))
    write(audit, 1)
    assert audit.health().lost == 1
    assert "ref-0" in [record.ref for record in audit.recent(FARM)]


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=8,
)


@pytest.mark.slow
@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(actor=st.text(max_size=200), note=st.text(max_size=300), data=st.dictionaries(st.text(max_size=5), JSON))
def test_whatever_is_recorded_reads_back_to_the_same_hash(
    database: Database, clock: FakeClock, actor: str, note: str, data: dict[str, Any]
) -> None:
    fields = plain_fields(AuditEntry(FARM, actor, "", "command", "ok", text=note, data=data), clock.utc())
    row = {**fields, "previous_hash": GENESIS, "hash": digest(GENESIS, fields)}
    with database.connect_writing() as connection:
        seq = connection.execute(insert(AuditRow).returning(AuditRow.seq), [row]).scalar_one()
    with database.read() as session:
        stored = session.get_one(AuditRow, seq)
        assert digest(GENESIS, {name: getattr(stored, name) for name in fields}) == stored.hash


@settings(max_examples=30, deadline=None)
@given(st.lists(st.text(max_size=5), min_size=2, max_size=10), st.data())
def test_any_change_of_any_entry_changes_every_later_hash(texts: list[str], data: st.DataObject) -> None:
    def chain(words: list[str]) -> list[str]:
        previous, hashes = GENESIS, []
        for word in words:
            fields = plain_fields(entry(text=word), FakeClock().utc())
            previous = digest(previous, fields)
            hashes.append(previous)
        return hashes

    index = data.draw(st.integers(0, len(texts) - 1))
    changed = [*texts[:index], texts[index] + "!", *texts[index + 1 :]]
    before, after = chain(texts), chain(changed)
    assert before[:index] == after[:index]
    assert all(a != b for a, b in zip(before[index:], after[index:], strict=True))


def test_values_that_databases_refuse_are_made_plain() -> None:
    assert plain({"a": math.nan, "b": "x\x00y", 3: (1, 2), "d": 2**70}) == {
        "a": "nan", "b": "xy", "3": [1, 2], "d": hex(2**70),
    }  # fmt: skip
