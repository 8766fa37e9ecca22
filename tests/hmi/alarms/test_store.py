"""The live list: escalation, shelves, revisions, and the same truth after a restart."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import timedelta
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hmi.clock import FakeClock
from hmi.domain.alarm.alarm import AlarmKey
from hmi.domain.alarm.catalogue import catalogue
from hmi.domain.alarm.conditions import Change, Turn
from hmi.domain.alarm.finding import Finding
from hmi.domain.alarm.life import AlarmRefused
from hmi.domain.alarm.live_alarm import LiveAlarm, What
from hmi.domain.alarm.priority import Priority
from hmi.store.alarm_journal import AlarmJournal, Search
from hmi.store.alarm_records import AlarmRecords
from hmi.store.alarms import AlarmStore, Person, escalation_of
from hmi.store.database import Database
from hmi.store.farms import Farms

ANNA = Person("Anna Ostermeier", "Desk")
CODES = ("link-lost", "stop-not-confirmed", "battery-low", "clock-wrong")


class Book:
    """A store with its records on a database."""

    def __init__(self, database: Database, clock: FakeClock) -> None:
        self.clock = clock
        self.store = AlarmStore(clock, catalogue())
        self.records = AlarmRecords(database, "farm", _names, linger_s=0.0)
        self.journal = AlarmJournal(database, "farm")
        self.store.listeners.append(self.records.take)
        self.records.start()

    def turn(self, turn: Turn, code: str, source: str = "weeder-07", **more: object) -> None:
        """Let a condition come, go or change its words."""
        self.store.apply([Change(turn, AlarmKey(code, source), Finding(code, "so", **more))])  # type: ignore[arg-type]

    def restarted(self, database: Database) -> Book:
        """Return the book as a new console reads it."""
        assert self.records.close()
        new = Book(database, self.clock)
        for alarm, unanswered_at, escalated_at in new.records.load():
            new.store.restore(alarm, unanswered_at, escalated_at)
        return new


def _names(live: LiveAlarm) -> tuple[str, str]:
    return live.alarm.key.source.title(), live.type.title


@pytest.fixture(scope="module")
def database(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Database]:
    """Return a database with a farm."""
    folder: Path = tmp_path_factory.mktemp("alarms")
    database = Database(f"sqlite:///{folder / 'headland.db'}")
    database.migrate()
    Farms(database, FakeClock()).ensure("farm", "Hof Brandt")
    yield database
    database.close()


@pytest.fixture
def book(database: Database) -> Iterator[Book]:
    """Return an empty book."""
    with database.connect_writing() as connection:
        connection.exec_driver_sql("DELETE FROM alarm")
        connection.exec_driver_sql("DELETE FROM alarm_journal")
    book = Book(database, FakeClock())
    yield book
    book.records.close()


def test_what_nobody_answers_escalates_by_priority_and_only_once(book: Book) -> None:
    for code in CODES:
        book.turn(Turn.COMES, code)
    seen = []
    for _ in range(1900):
        book.clock.advance(1)
        book.store.pass_time()
    book.records.flush()
    seen = [(line.code, line.at) for line in book.journal.page(Search(), 100) if line.what == What.ESCALATED.value]
    waited = {code: round((at - book.clock.utc()).total_seconds()) + 1900 for code, at in seen}
    assert waited == {"stop-not-confirmed": 60, "link-lost": 300, "battery-low": 1800}


def test_what_was_seen_in_time_does_not_escalate_and_a_new_occurrence_waits_anew(book: Book) -> None:
    book.turn(Turn.COMES, "stop-not-confirmed")
    book.clock.advance(50)
    book.store.acknowledge("stop-not-confirmed.weeder-07", ANNA)
    book.clock.advance(50)
    book.store.pass_time()
    assert book.store.get("stop-not-confirmed.weeder-07").escalated_at is None
    book.turn(Turn.GOES, "stop-not-confirmed")
    book.turn(Turn.COMES, "stop-not-confirmed")
    book.clock.advance(59)
    book.store.pass_time()
    assert book.store.get("stop-not-confirmed.weeder-07").escalated_at is None
    book.clock.advance(1)
    book.store.pass_time()
    assert book.store.get("stop-not-confirmed.weeder-07").escalated_at is not None


def _escalated(book: Book, seconds: int, *, on_s: int, off_s: int) -> list[int]:
    """Let one alarm come and go; return after how many seconds it escalated each time."""
    found: list[int] = []
    book.store.listeners.append(lambda step: found.append(second) if step.what is What.ESCALATED else None)
    for second in range(seconds):
        if second % (on_s + off_s) in (0, on_s):
            book.turn(Turn.GOES if second % (on_s + off_s) else Turn.COMES, "link-lost")
        book.store.pass_time()
        book.clock.advance(1)
    return found


def test_an_alarm_that_comes_and_goes_unseen_escalates_in_time_and_once(book: Book) -> None:
    assert _escalated(book, 3600, on_s=200, off_s=40) == [300]


def test_how_long_an_alarm_waited_is_counted_from_its_first_occurrence_that_nobody_saw(book: Book) -> None:
    _escalated(book, 500, on_s=200, off_s=40)
    book.store.acknowledge("link-lost.weeder-07", ANNA)
    assert book.records.flush()
    assert book.journal.figures(book.clock.utc()).answers_s == [500]


def test_what_comes_back_from_the_shelf_waits_anew_also_over_a_restart(book: Book, database: Database) -> None:
    alarm_id = "link-lost.weeder-07"
    book.turn(Turn.COMES, "link-lost")
    book.clock.advance(20)
    book.store.acknowledge(alarm_id, ANNA)
    book.store.shelve(alarm_id, ANNA, "is known", book.clock.utc() + timedelta(minutes=15))
    book.clock.advance(900)
    book.store.pass_time()
    book.clock.advance(200)
    again = book.restarted(database)
    try:
        again.clock.advance(99)
        again.store.pass_time()
        assert again.store.get(alarm_id).escalated_at is None
        again.clock.advance(1)
        again.store.pass_time()
        assert again.store.get(alarm_id).escalated_at == again.clock.utc()
        again.clock.advance(30)
        again.store.acknowledge(alarm_id, ANNA)
        assert again.records.flush()
        assert again.journal.figures(again.clock.utc()).answers_s == [20, 330]
    finally:
        again.records.close()


def test_what_becomes_critical_escalates_again_by_the_limit_of_priority_1(book: Book) -> None:
    book.turn(Turn.COMES, "robot-fault", priority=Priority.MEDIUM)
    for _ in range(1800):
        book.clock.advance(1)
        book.store.pass_time()
    assert book.store.get("robot-fault.weeder-07").escalated_at is not None
    book.turn(Turn.REWORDED, "robot-fault", priority=Priority.CRITICAL)
    assert book.store.get("robot-fault.weeder-07").escalated_at is None
    book.store.pass_time()
    assert book.store.get("robot-fault.weeder-07").escalated_at is not None


def test_the_limits_can_be_set_and_never_is_a_choice() -> None:
    assert escalation_of({"1": 30, "3": None}) == {Priority.CRITICAL: 30.0, Priority.HIGH: 300.0}


def test_a_shelf_ends_by_itself_and_asks_again(book: Book) -> None:
    book.turn(Turn.COMES, "battery-low")
    book.store.acknowledge("battery-low.weeder-07", ANNA)
    until = book.clock.utc() + timedelta(minutes=15)
    book.store.shelve("battery-low.weeder-07", ANNA, "is on its way home", until)
    assert book.store.counts()[Priority.MEDIUM] == (0, 0)
    book.clock.advance(900)
    book.store.pass_time()
    live = book.store.get("battery-low.weeder-07")
    assert (live.alarm.state.value, live.alarm.seen_by) == ("unacknowledged", "")


def test_what_is_shelved_and_went_away_is_gone_when_the_shelf_ends(book: Book) -> None:
    book.turn(Turn.COMES, "battery-low")
    book.store.acknowledge("battery-low.weeder-07", ANNA)
    book.store.shelve("battery-low.weeder-07", ANNA, "wet", book.clock.utc() + timedelta(minutes=15))
    book.turn(Turn.GOES, "battery-low")
    assert book.store.get("battery-low.weeder-07").alarm.state.value == "shelved"
    book.clock.advance(900)
    book.store.pass_time()
    assert book.store.find("battery-low.weeder-07") is None


def test_since_tells_exactly_what_changed(book: Book) -> None:
    book.turn(Turn.COMES, "link-lost")
    seen = book.store.revision
    assert book.store.since(seen) == {}
    book.turn(Turn.COMES, "battery-low", "weeder-08")
    assert set(book.store.since(seen)) == {"battery-low.weeder-08"}
    book.store.acknowledge("battery-low.weeder-08", ANNA)
    book.turn(Turn.GOES, "battery-low", "weeder-08")
    assert book.store.since(seen) == {"battery-low.weeder-08": None}
    assert set(book.store.since(0)) == {"link-lost.weeder-07", "battery-low.weeder-08"}


def test_what_joins_a_group_changes_what_the_others_say_of_it(book: Book) -> None:
    book.turn(Turn.COMES, "link-lost", since_s=book.clock.mono_s())
    seen = book.store.revision
    book.clock.advance(1)
    book.turn(Turn.COMES, "stop-not-confirmed")
    changed = book.store.since(seen)
    assert {i: (one.place, one.group) for i, one in changed.items() if one} == {
        "link-lost.weeder-07": (1, 2),
        "stop-not-confirmed.weeder-07": (2, 2),
    }


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.lists(
        st.tuples(
            st.sampled_from(CODES), st.sampled_from(["come", "go", "see", "clear", "shelve", "out", "in", "time"])
        ),
        max_size=25,
    )
)
def test_a_restart_anywhere_forgets_nothing(database: Database, book: Book, story: list[tuple[str, str]]) -> None:
    for code, what in story:
        _do(book, code, what)
    expected = {one.id: _said(one) for one in book.store.all()}
    again = book.restarted(database)
    try:
        assert {one.id: _said(one) for one in again.store.all()} == expected
        assert again.store.counts() == book.store.counts()
    finally:
        again.records.close()
        with database.connect_writing() as connection:
            connection.exec_driver_sql("DELETE FROM alarm")
        book.__init__(database, FakeClock())  # type: ignore[misc]


def _said(live: LiveAlarm) -> tuple[object, ...]:
    alarm = live.alarm
    return (alarm.phase, alarm.text, alarm.raised_at, alarm.returned_at, alarm.seen_by, alarm.seen_at, alarm.shelf,
            alarm.out_of_service, alarm.occurrences, live.unanswered_at, live.escalated_at, live.first,
            live.place)  # fmt: skip


def _do(book: Book, code: str, what: str) -> None:
    alarm_id, now = f"{code}.weeder-07", book.clock.utc()
    book.clock.advance(7)
    if what in ("come", "go"):
        book.turn(Turn.COMES if what == "come" else Turn.GOES, code)
    elif what == "time":
        book.clock.advance(400)
        book.store.pass_time()
    elif book.store.find(alarm_id) is not None:
        act = {
            "see": lambda: book.store.acknowledge(alarm_id, ANNA),
            "clear": lambda: book.store.clear(alarm_id, ANNA),
            "shelve": lambda: book.store.shelve(alarm_id, ANNA, "wet soil", now + timedelta(hours=1)),
            "out": lambda: book.store.take_out(alarm_id, ANNA, "at the maker"),
            "in": lambda: book.store.put_back(alarm_id, ANNA),
        }[what]
        try:
            act()
        except AlarmRefused as refused:
            assert refused.text.endswith(".")  # noqa: PT017 - whatever is refused says why


def test_the_journal_is_searched_by_words_priority_robot_and_time_and_paged(book: Book) -> None:
    for number in range(30):
        book.turn(Turn.COMES, "link-lost", f"weeder-{number:02d}")
        book.clock.advance(60)
    book.turn(Turn.COMES, "stop-not-confirmed")
    book.store.acknowledge("link-lost.weeder-03", ANNA)
    assert book.records.flush()
    page = book.journal.page(Search(text="data LINK weeder-0"), 5)
    assert [line.source for line in page][:2] == ["weeder-03", "weeder-09"]
    following = book.journal.page(Search(text="data link weeder-0"), 5, page[-1].id)
    assert {line.id for line in page}.isdisjoint(line.id for line in following)
    assert [line.code for line in book.journal.page(Search(priority=1), 10)] == ["stop-not-confirmed"]
    assert [line.by for line in book.journal.page(Search(text="anna"), 10)] == ["Anna Ostermeier"]
    assert book.journal.page(Search(text="100%"), 10) == []
    assert len(book.journal.page(Search(start=book.clock.utc() - timedelta(minutes=4)), 100)) == 6
    assert sum(len(part) for part in book.journal.export(Search())) == 32


def test_figures_count_what_was_raised_and_how_long_it_waited(book: Book) -> None:
    for number in range(12):
        book.turn(Turn.COMES, "link-lost", f"weeder-{number:02d}")
        book.clock.advance(10)
    book.store.acknowledge("link-lost.weeder-00", ANNA)
    book.turn(Turn.COMES, "stop-not-confirmed")
    book.records.flush()
    found = book.journal.figures(book.clock.utc())
    assert (found.last_10min, found.raised, found.mix) == (13, 13, {1: 1, 2: 12})
    assert found.answers_s == [120]
    assert found.top == [("link-lost", 12), ("stop-not-confirmed", 1)]
    assert (found.flood_s, found.span_s) == (30.0, 600.0)  # the tenth came 30 s ago; the journal began just now
    book.clock.advance(3600)
    later = book.journal.figures(book.clock.utc())
    assert later.last_10min == 0
    assert 500 < later.flood_s < 700
    assert later.span_s == 3720.0  # since its first line
    book.clock.advance(30 * 86_400)
    assert book.journal.figures(book.clock.utc()).span_s == 7 * 86_400


def test_a_database_that_fails_does_not_hold_up_an_alarm_and_is_mended_afterwards(
    book: Book, database: Database
) -> None:
    with database.connect_writing():  # somebody holds the write lock
        for code in CODES:
            book.turn(Turn.COMES, code)
        assert len(book.store.all()) == len(CODES)
    assert book.records.flush(10)
    assert len(book.records.load()) == len(CODES)


def test_an_alarm_that_becomes_critical_is_so_in_the_journal_and_after_a_restart(
    book: Book, database: Database
) -> None:
    book.turn(Turn.COMES, "robot-fault", priority=Priority.LOW)
    book.store.acknowledge("robot-fault.weeder-07", ANNA)
    book.clock.advance(600)
    book.turn(Turn.REWORDED, "robot-fault", priority=Priority.CRITICAL)
    again = book.restarted(database)
    try:
        live = again.store.get("robot-fault.weeder-07")
        assert (live.priority, live.alarm.state.value) == (Priority.CRITICAL, "unacknowledged")
        newest = again.journal.page(Search(), 1)[0]
        assert (newest.what, newest.priority, newest.at) == ("raised", 1, book.clock.utc())
        assert newest.text == "Was priority 4, acknowledged. so"
    finally:
        again.records.close()


def test_who_took_an_alarm_out_of_service_is_known_after_a_restart(book: Book, database: Database) -> None:
    for source, is_admin in (("weeder-07", False), ("weeder-08", True)):
        book.turn(Turn.COMES, "robot-fault", source, priority=Priority.LOW)
        book.store.take_out(f"robot-fault.{source}", ANNA, "at the maker", holds_critical=is_admin)
    again = book.restarted(database)
    try:
        for source in ("weeder-07", "weeder-08"):
            again.turn(Turn.REWORDED, "robot-fault", source, priority=Priority.CRITICAL)
        states = {one.id: one.alarm.state.value for one in again.store.all()}
        assert states == {"robot-fault.weeder-07": "unacknowledged", "robot-fault.weeder-08": "out_of_service"}
    finally:
        again.records.close()
