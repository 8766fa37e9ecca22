"""Signing in and out, by password and by PIN, and what wrong tries cost."""

from __future__ import annotations

import json
from typing import Literal

import pytest
from argon2 import PasswordHasher

from hmi.clock import FakeClock
from hmi.domain.role import Role
from hmi.security.demo_users import seed_demo_users
from hmi.security.errors import (
    BadAccount,
    BadToken,
    NotEnrolled,
    TooManyTries,
    WeakPassword,
    WrongCredentials,
)
from hmi.security.passwords import Passwords, check_password, check_pin
from hmi.security.sign_in import user_id_of
from tests.hmi.security.conftest import ADDRESS, FARM, PASSWORD, SECRET, Farmyard


async def wrong(yard: Farmyard, name: str = "martha", address: str = ADDRESS, stop_token: str = "") -> str:
    """Try a wrong password and return what the person reads."""
    with pytest.raises((WrongCredentials, TooManyTries)) as refused:
        await yard.sign_in.with_password(name, "wrong", address=address, stop_token=stop_token)
    return refused.value.text


async def wrong_pin(yard: Farmyard, token: str, pin: str = "9999", address: str = ADDRESS) -> str:
    """Try a wrong PIN and return what the person reads."""
    with pytest.raises((WrongCredentials, TooManyTries)) as refused:
        await yard.sign_in.with_pin("martha", pin, address=address, stop_token=token)
    return refused.value.text


@pytest.mark.parametrize("name", ["martha", " Martha ", "MARTHA"])
async def test_the_right_password_opens_a_session(yard: Farmyard, name: str) -> None:
    signed_in = await yard.sign_in.with_password(name, PASSWORD, address=ADDRESS)
    session = yard.sessions.lookup(signed_in.cookie)
    assert session == signed_in.session
    assert (signed_in.session.user_name, signed_in.session.role) == ("Martha Keller", Role.OPERATOR)
    assert len(signed_in.cookie) >= 43  # 256 bit


async def test_a_full_name_is_a_name_to_sign_in_with(yard: Farmyard) -> None:
    assert (await yard.sign_in.with_password("Lena  Vogt", PASSWORD, address=ADDRESS)).session.user_id == "lena-vogt"


async def test_unknown_names_and_wrong_passwords_read_the_same(yard: Farmyard) -> None:
    assert (
        await wrong(yard)
        == await wrong(yard, "nobody")
        == await wrong(yard, "; DROP TABLE user")
        == ("Name or password is wrong.")
    )


class CountingHasher(PasswordHasher):
    """Counts the expensive part of verifying."""

    verified = 0

    def verify(self, hash: str | bytes, password: str | bytes) -> Literal[True]:
        """Verify, and count it."""
        self.verified += 1
        return super().verify(hash, password)


async def test_an_unknown_name_costs_one_verification_like_a_known_one(yard: Farmyard) -> None:
    hasher = CountingHasher(time_cost=1, memory_cost=8, parallelism=1)
    passwords = Passwords(SECRET, hasher)
    sign_in = yard.sign_in_with(passwords)
    token = await yard.tablet()
    for count, name in enumerate(("martha", "nobody", "", "lena-vogt"), start=1):
        with pytest.raises(WrongCredentials):
            await sign_in.with_password(name, "wrong", address=ADDRESS)
        with pytest.raises(WrongCredentials):
            await sign_in.with_pin(name, "9999", address=ADDRESS, stop_token=token)
        assert hasher.verified == 2 * count
    passwords.close()


async def test_somebody_switched_off_cannot_sign_in(yard: Farmyard) -> None:
    await yard.accounts.change("martha", by="Jonas Weber", is_active=False)
    assert await wrong(yard) == "Name or password is wrong."
    with pytest.raises(WrongCredentials):
        await yard.sign_in.with_password("martha", PASSWORD, address=ADDRESS)


async def test_wrong_tries_make_the_wait_grow(yard: Farmyard, clock: FakeClock) -> None:
    for _ in range(3):
        assert await wrong(yard) == "Name or password is wrong."
    waits = []
    for _ in range(5):
        text = await wrong(yard)
        assert text.startswith("Too many wrong tries for this name. Wait ")
        waits.append(int(text.split("Wait ")[1].split()[0]))
        clock.advance(waits[-1])
        assert await wrong(yard) == "Name or password is wrong."
    assert waits == [1, 2, 4, 8, 16]


async def test_even_the_right_password_waits(yard: Farmyard, clock: FakeClock) -> None:
    for _ in range(3):
        await wrong(yard)
    with pytest.raises(TooManyTries) as refused:
        await yard.sign_in.with_password("martha", PASSWORD, address=ADDRESS)
    assert refused.value.retry_after_s == pytest.approx(1.0)
    clock.advance(1.0)
    await yard.sign_in.with_password("martha", PASSWORD, address=ADDRESS)
    assert await wrong(yard) == "Name or password is wrong."


async def test_setting_the_wall_clock_shortens_no_wait(yard: Farmyard, clock: FakeClock) -> None:
    for _ in range(3):
        await wrong(yard)
    clock.jump_wall(86_400)
    assert (await wrong(yard)).startswith("Too many")


async def test_one_address_trying_many_names_is_slowed_down(yard: Farmyard) -> None:
    for number in range(20):
        await wrong(yard, f"name-{number}")
    assert (await wrong(yard, "martha")).startswith("Too many wrong tries from this address.")
    assert await wrong(yard, "martha", "192.168.1.99") == "Name or password is wrong."


async def test_strangers_cannot_lock_somebody_out_of_the_enrolled_tablet(yard: Farmyard) -> None:
    token = await yard.tablet()
    for number in range(8):
        await wrong(yard, address=f"10.0.0.{number}")
    await yard.sign_in.with_password("martha", PASSWORD, address=ADDRESS, stop_token=token)


async def test_signing_in_again_gives_a_fresh_cookie_and_ends_the_old_session(yard: Farmyard) -> None:
    first = await yard.sign_in.with_password("martha", PASSWORD, address=ADDRESS)
    second = await yard.sign_in.with_password("lena-vogt", PASSWORD, address=ADDRESS, old_cookie=first.cookie)
    assert second.cookie != first.cookie
    assert second.session.csrf != first.session.csrf
    assert yard.sessions.lookup(first.cookie) is None


async def test_a_cookie_planted_before_signing_in_opens_nothing_afterwards(yard: Farmyard) -> None:
    planted = "planted-by-somebody-else"
    signed_in = await yard.sign_in.with_password("martha", PASSWORD, address=ADDRESS, old_cookie=planted)
    assert signed_in.cookie != planted
    assert yard.sessions.lookup(planted) is None


async def test_the_stop_token_says_who_and_where(yard: Farmyard) -> None:
    token = await yard.tablet()
    signed_in = await yard.sign_in.with_pin("martha", "4826", address=ADDRESS, stop_token=token)
    read = yard.tokens.read_stop_token(signed_in.stop_token)
    assert (read.device_name, read.user_name, read.farm_id) == ("Tablet 3", "Martha Keller", FARM)
    alone = yard.tokens.read_stop_token(await yard.sign_in.sign_out(signed_in.session))
    assert (alone.device_id, alone.user_name, alone.who) == (read.device_id, "", "Tablet 3")


async def test_signing_out_in_a_browser_that_is_no_tablet_leaves_no_token(yard: Farmyard) -> None:
    signed_in = await yard.sign_in.with_password("martha", PASSWORD, address=ADDRESS)
    assert yard.tokens.read_stop_token(signed_in.stop_token).user_name == "Martha Keller"
    assert await yard.sign_in.sign_out(signed_in.session) == ""


async def test_a_pin_works_on_enrolled_tablets_only(yard: Farmyard) -> None:
    signed_in = await yard.sign_in.with_password("martha", PASSWORD, address=ADDRESS)
    for token in ("", "forged", signed_in.stop_token):
        with pytest.raises(NotEnrolled, match="This tablet is not enrolled"):
            await yard.sign_in.with_pin("martha", "4826", address=ADDRESS, stop_token=token)
        assert await yard.sign_in.people(token) == []


async def test_wrong_pins_count_down_and_then_lock(yard: Farmyard, clock: FakeClock) -> None:
    token = await yard.tablet()
    assert [await wrong_pin(yard, token) for _ in range(4)] == [
        "Wrong PIN. 4 tries left.", "Wrong PIN. 3 tries left.", "Wrong PIN. 2 tries left.", "Wrong PIN. 1 try left.",
    ]  # fmt: skip
    assert await wrong_pin(yard, token) == "Wrong PIN. It is locked for 15 min. Use name and password."
    assert await wrong_pin(yard, token, "4826") == "The PIN is locked for 15 min. Use name and password."
    clock.advance(15 * 60)
    await yard.sign_in.with_pin("martha", "4826", address=ADDRESS, stop_token=token)


async def test_after_the_lock_one_wrong_pin_locks_for_twice_as_long(yard: Farmyard, clock: FakeClock) -> None:
    token = await yard.tablet()
    for _ in range(5):
        await wrong_pin(yard, token)
    clock.advance(15 * 60)
    await wrong_pin(yard, token)
    assert "30 min" in await wrong_pin(yard, token, "4826")


async def test_a_password_unlocks_the_pin(yard: Farmyard) -> None:
    token = await yard.tablet()
    for _ in range(5):
        await wrong_pin(yard, token)
    await yard.sign_in.with_password("martha", PASSWORD, address=ADDRESS, stop_token=token)
    await yard.sign_in.with_pin("martha", "4826", address=ADDRESS, stop_token=token)


@pytest.mark.parametrize("pin", ["", "48", "48261", "4826 ", "４８２６", "abcd"])
async def test_what_is_no_pin_is_a_wrong_pin(yard: Farmyard, pin: str) -> None:
    assert (await wrong_pin(yard, await yard.tablet(), pin)).startswith("Wrong PIN.")


async def test_somebody_without_a_pin_cannot_use_an_empty_one(yard: Farmyard) -> None:
    token = await yard.tablet()
    for pin in ("", "0000"):
        with pytest.raises(WrongCredentials):
            await yard.sign_in.with_pin("lena-vogt", pin, address=ADDRESS, stop_token=token)


async def test_an_enrolled_tablet_shows_who_has_a_pin(yard: Farmyard) -> None:
    people = await yard.sign_in.people(await yard.tablet())
    assert [(person.id, person.name) for person in people] == [("martha", "Martha Keller")]


async def test_a_revoked_tablet_loses_sessions_pins_and_stop(yard: Farmyard) -> None:
    token = await yard.tablet()
    admin = await yard.sign_in.with_password("jonas", PASSWORD, address=ADDRESS)
    signed_in = await yard.sign_in.with_pin("martha", "4826", address=ADDRESS, stop_token=token)
    await yard.enrolment.revoke(admin.session, signed_in.session.device_id)
    assert yard.sessions.lookup(signed_in.cookie) is None
    with pytest.raises(NotEnrolled):
        await yard.sign_in.with_pin("martha", "4826", address=ADDRESS, stop_token=token)
    with pytest.raises(BadToken, match="taken out"):
        yard.tokens.read_stop_token(signed_in.stop_token)
    assert json.loads((yard.folder / "revoked.json").read_text()) == [signed_in.session.device_id]


async def test_sign_ins_are_audited_without_what_strangers_typed(yard: Farmyard) -> None:
    yard.audited.clear()
    await yard.sign_in.with_password("martha", PASSWORD, address=ADDRESS)
    await wrong(yard)
    await wrong(yard, "my-secret-password-in-the-wrong-field")
    assert [(entry.actor, entry.outcome) for entry in yard.audited] == [
        ("Martha Keller", "accepted"), ("Martha Keller", "refused"), ("unknown", "refused"),
    ]  # fmt: skip
    assert "secret" not in repr(yard.audited)


async def test_old_hashes_are_renewed_at_sign_in(yard: Farmyard) -> None:
    before = yard.users.credentials("martha")
    strong = Passwords(SECRET)
    await yard.sign_in_with(strong).with_password("martha", PASSWORD, address=ADDRESS)
    after = yard.users.credentials("martha")
    assert before is not None
    assert after is not None
    assert strong.is_outdated(before.password_hash)
    assert not strong.is_outdated(after.password_hash)
    strong.close()


async def test_a_pin_hash_is_worth_nothing_without_the_secret(yard: Farmyard) -> None:
    stored = await yard.passwords.hash_pin("martha", "4826")
    other = Passwords("another installation's secret", yard.hasher)
    assert await yard.passwords.verify_pin(stored, "martha", "4826")
    assert not await yard.passwords.verify_pin(stored, "lena-vogt", "4826")
    assert not await other.verify_pin(stored, "martha", "4826")
    other.close()


@pytest.mark.parametrize(
    ("password", "why"),
    [
        ("short", "at least 10"),
        ("x" * 129, "128"),
        ("aaaaaaaaaaaa", "first that others try"),
        ("password1234", "first that others try"),
        ("martha-2026-x", "must not contain the name"),
    ],
)
def test_weak_passwords_are_refused_with_the_reason(password: str, why: str) -> None:
    with pytest.raises(WeakPassword, match=why):
        check_password(password, "martha", "Martha Keller")
    check_password(PASSWORD, "martha", "Martha Keller")


@pytest.mark.parametrize("pin", ["1234", "0000", "9876", "123", "12345", "12a4", ""])
def test_weak_pins_are_refused(pin: str) -> None:
    with pytest.raises(WeakPassword):
        check_pin(pin)
    check_pin("4826")


@pytest.mark.parametrize(
    ("typed", "meant"),
    [("Martha Keller", "martha-keller"), ("  ADMIN ", "admin"), ("", ""), ("ä", ""), ("a" * 65, ""), ("x/y", "")],
)
def test_a_typed_name_means_an_id(typed: str, meant: str) -> None:
    assert user_id_of(typed) == meant


async def test_a_new_password_or_role_ends_the_sessions(yard: Farmyard) -> None:
    for change in (
        lambda: yard.accounts.set_password("martha", "another-horse-8", by="Jonas Weber"),
        lambda: yard.accounts.change("martha", by="Jonas Weber", role=Role.VIEWER),
    ):
        cookie, _ = await yard.sessions.open((await yard.accounts.all())[2], "browser-1", "")
        await change()
        assert yard.sessions.lookup(cookie) is None


async def test_the_last_admin_stays(yard: Farmyard) -> None:
    for change in ({"role": Role.VIEWER}, {"is_active": False}):
        with pytest.raises(BadAccount, match="Somebody must stay admin"):
            await yard.accounts.change("jonas", by="Jonas Weber", **change)  # type: ignore[arg-type]
    await yard.accounts.change("martha", by="Jonas Weber", role=Role.ADMIN)
    await yard.accounts.change("jonas", by="Martha Keller", role=Role.VIEWER)


async def test_a_name_is_taken_once(yard: Farmyard) -> None:
    with pytest.raises(BadAccount, match="already signs in as martha"):
        await yard.accounts.create_user("Martha", Role.VIEWER, PASSWORD, by="Jonas Weber")
    with pytest.raises(BadAccount):
        await yard.accounts.create_user("  ", Role.VIEWER, PASSWORD, by="Jonas Weber", user_id="x")


async def test_demo_accounts_sign_in_with_their_name_and_are_made_once(yard: Farmyard) -> None:
    assert len(await seed_demo_users(yard.accounts)) == 6
    assert await seed_demo_users(yard.accounts) == []
    for role in Role:
        signed_in = await yard.sign_in.with_password(role.value, role.value, address=ADDRESS)
        assert signed_in.session.role is role
    token = await yard.tablet()
    assert (await yard.sign_in.with_pin("supervisor", "2222", address=ADDRESS, stop_token=token)).session.user_name == (
        "Anna Ostermeier"
    )
