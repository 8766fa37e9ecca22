"""Sessions: they end when they should, everywhere, and survive what they should."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from sqlalchemy import inspect

from hmi.clock import FakeClock
from hmi.domain.role import Role
from hmi.security.cookie import clear_cookie_header, cookies_in, set_cookie_header
from hmi.security.sessions import EXPIRED, MAX_PER_PERSON, RIGHTS_CHANGED, SIGNED_OUT, Sessions
from hmi.store.database import Database
from hmi.store.users import User
from tests.hmi.security.conftest import FARM, LIFETIME_S, Farmyard


@pytest.fixture
def martha(yard: Farmyard) -> User:
    """Return the operator."""
    user = yard.users.get("martha")
    assert user is not None
    return user


async def open_cookie(yard: Farmyard, user: User) -> str:
    """Open a session and return its cookie."""
    return (await yard.sessions.open(user, "browser-1", ""))[0]


@settings(max_examples=15, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(steps=st.lists(st.tuples(st.floats(0, 6 * 3600), st.floats(-86_400, 86_400)), max_size=8))
async def test_a_session_lasts_exactly_its_time_on_any_wall_clock(
    yard: Farmyard, martha: User, clock: FakeClock, steps: list[tuple[float, float]]
) -> None:
    cookie = await open_cookie(yard, martha)
    opened_s = clock.mono_s()
    for run_s, jump_s in steps:
        clock.advance(run_s)
        clock.jump_wall(jump_s)
        is_open = yard.sessions.lookup(cookie) is not None
        assert is_open == (clock.mono_s() - opened_s < LIFETIME_S)


@pytest.mark.parametrize("cookie", [None, "", "x", "ü", "a" * 10_000])
async def test_nonsense_opens_nothing(yard: Farmyard, cookie: str | None) -> None:
    assert yard.sessions.lookup(cookie) is None


def everything_in(database: Database) -> bytes:
    """Return the bytes of the file, or every row of a server's tables."""
    if database.is_sqlite:
        path = Path(str(database.url.database))
        return b"".join(file.read_bytes() for file in path.parent.glob(f"{path.name}*"))
    with database.engine.connect() as connection:
        tables = inspect(connection).get_table_names()
        rows = [connection.exec_driver_sql(f'SELECT * FROM "{table}"').all() for table in tables]
    return repr(rows).encode()


async def test_the_database_does_not_hold_the_cookie(yard: Farmyard, martha: User, database: Database) -> None:
    cookie, session = await yard.sessions.open(martha, "browser-1", "")
    held = everything_in(database)
    assert session.session_id.encode() in held
    assert cookie.encode() not in held
    assert yard.sessions.lookup(session.session_id) is None


async def test_pages_hear_that_their_session_ended(yard: Farmyard, martha: User, clock: FakeClock) -> None:
    heard: list[tuple[str, str]] = []
    take_back = yard.sessions.on_ended(lambda session, text: heard.append((session.user_name, text)))
    _, first = await yard.sessions.open(martha, "browser-1", "")
    await yard.sessions.end(first.session_id)
    await yard.sessions.end(first.session_id)
    await open_cookie(yard, martha)
    clock.advance(LIFETIME_S - 1)
    assert yard.sessions.sweep() == 0
    clock.advance(1)
    assert yard.sessions.sweep() == 1
    take_back()
    await open_cookie(yard, martha)
    await yard.sessions.end_all_of("martha")
    assert heard == [("Martha Keller", SIGNED_OUT), ("Martha Keller", EXPIRED)]


async def test_a_page_that_fails_to_close_does_not_keep_others_open(yard: Farmyard, martha: User) -> None:
    heard: list[str] = []

    def fail(*_: object) -> None:
        raise RuntimeError

    yard.sessions.on_ended(fail)
    yard.sessions.on_ended(lambda _session, text: heard.append(text))
    _, session = await yard.sessions.open(martha, "browser-1", "")
    await yard.sessions.end(session.session_id)
    assert heard == [SIGNED_OUT]


async def test_sessions_survive_a_restart_and_keep_their_end(
    yard: Farmyard, martha: User, clock: FakeClock, database: Database
) -> None:
    kept, ended = await open_cookie(yard, martha), await open_cookie(yard, martha)
    info = yard.sessions.lookup(kept)
    ended_info = yard.sessions.lookup(ended)
    assert ended_info is not None
    await yard.sessions.end(ended_info.session_id)
    clock.advance(3600)
    again = Sessions(database, clock, FARM, LIFETIME_S)
    await again.load()
    assert again.lookup(kept) == info
    assert again.lookup(ended) is None
    clock.advance(LIFETIME_S - 3600)
    assert again.lookup(kept) is None


async def test_a_wall_clock_set_back_over_a_restart_lengthens_nothing_beyond_a_full_session(
    yard: Farmyard, martha: User, clock: FakeClock, database: Database
) -> None:
    cookie = await open_cookie(yard, martha)
    clock.jump_wall(-30 * 86_400)
    again = Sessions(database, clock, FARM, LIFETIME_S)
    await again.load()
    clock.advance(LIFETIME_S)
    assert again.lookup(cookie) is None


async def test_what_another_process_ends_or_changes_ends_here(
    yard: Farmyard, martha: User, clock: FakeClock, database: Database
) -> None:
    heard: list[str] = []
    yard.sessions.on_ended(lambda _session, text: heard.append(text))
    elsewhere = Sessions(database, clock, FARM, LIFETIME_S)
    cookie = await open_cookie(yard, martha)
    await elsewhere.end_all_of("martha")
    await yard.sessions.reconcile()
    assert yard.sessions.lookup(cookie) is None
    cookie = await open_cookie(yard, martha)
    yard.users.change(FARM, "martha", role=Role.ADMIN)
    await yard.sessions.reconcile()
    assert yard.sessions.lookup(cookie) is None
    assert heard == [RIGHTS_CHANGED, RIGHTS_CHANGED]


async def test_a_session_opened_on_another_console_is_known_here(
    yard: Farmyard, martha: User, clock: FakeClock, database: Database
) -> None:
    elsewhere = Sessions(database, clock, FARM, LIFETIME_S)
    cookie, session = await elsewhere.open(martha, "browser-1", "")
    await yard.sessions.reconcile()
    assert yard.sessions.lookup(cookie) == session


async def test_one_person_cannot_fill_the_memory_with_sessions(yard: Farmyard, martha: User, clock: FakeClock) -> None:
    cookies = []
    for _ in range(MAX_PER_PERSON + 3):
        clock.advance(1)
        cookies.append(await open_cookie(yard, martha))
    assert [yard.sessions.lookup(cookie) is None for cookie in cookies] == [True] * 3 + [False] * MAX_PER_PERSON


async def test_a_sign_out_holds_while_the_database_is_away_and_is_written_later(
    yard: Farmyard, martha: User, clock: FakeClock, database: Database, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("hmi.store.database.BUSY_TIMEOUT_MS", 1)
    own = Database(database.url.render_as_string(hide_password=False))
    sessions = Sessions(own, clock, FARM, LIFETIME_S)
    cookie, session = await sessions.open(martha, "browser-1", "")
    lock = database.engine.raw_connection()
    lock.cursor().execute("BEGIN IMMEDIATE" if database.is_sqlite else "LOCK TABLE session IN ACCESS EXCLUSIVE MODE")
    await sessions.end(session.session_id)
    assert sessions.lookup(cookie) is None
    lock.rollback()
    lock.close()
    await sessions.reconcile()
    assert sessions.lookup(cookie) is None
    again = Sessions(own, clock, FARM, LIFETIME_S)
    await again.load()
    assert again.lookup(cookie) is None
    own.close()


async def test_old_rows_are_forgotten(yard: Farmyard, martha: User, clock: FakeClock, database: Database) -> None:
    await open_cookie(yard, martha)
    clock.advance(40 * 86_400)
    await yard.sessions.forget_old()
    with database.engine.connect() as connection:
        assert connection.exec_driver_sql("SELECT count(*) FROM session").scalar_one() == 0


def test_the_cookie_is_out_of_reach_for_scripts_and_other_sites() -> None:
    header = set_cookie_header("value", 3600, is_secure=True)
    assert header == "headland_session=value; Path=/; Max-Age=3600; HttpOnly; SameSite=Lax; Secure"
    assert "Secure" not in set_cookie_header("value", 3600, is_secure=False)
    assert "Max-Age=0" in clear_cookie_header()


async def test_a_second_planted_cookie_does_not_hide_the_real_one(yard: Farmyard, martha: User) -> None:
    cookie, session = await yard.sessions.open(martha, "browser-1", "")
    headers = [(b"cookie", f"a=b; headland_session=planted; headland_session={cookie}".encode())]
    assert cookies_in(headers) == ["planted", cookie]
    assert yard.sessions.of_headers(headers) == session
    assert yard.sessions.of_headers([(b"cookie", b"xheadland_session=" + cookie.encode())]) is None
