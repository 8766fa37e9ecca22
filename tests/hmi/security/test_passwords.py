"""Names nobody has take as long to refuse as others."""

from __future__ import annotations

from argon2 import PasswordHasher, extract_parameters

from hmi.security.passwords import Passwords, default_hasher


async def test_nobody_is_verified_with_the_cost_of_a_real_password_and_never_is_right() -> None:
    hasher = PasswordHasher(time_cost=3, memory_cost=64, parallelism=2, hash_len=24)
    passwords = Passwords("secret", hasher)
    try:
        nobody, somebody = passwords._nobody, await passwords.hash_password("correct horse")
        assert extract_parameters(nobody) == extract_parameters(somebody)
        assert not await passwords.verify_password(None, "correct horse")
        assert await passwords.verify_password(somebody, "correct horse")
    finally:
        passwords.close()


async def test_no_two_installations_share_the_hash_of_nobody() -> None:
    first, second = Passwords("a", default_hasher()), Passwords("a", default_hasher())
    try:
        assert first._nobody != second._nobody
    finally:
        first.close()
        second.close()
