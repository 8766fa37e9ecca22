"""Passwords and PINs: the rules for choosing one, and argon2id in threads of its own."""

from __future__ import annotations

import asyncio
import base64
import hashlib
import hmac
import itertools
import re
import secrets
import unicodedata
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from argon2 import PasswordHasher
from argon2.exceptions import InvalidHashError, VerificationError
from argon2.low_level import ARGON2_VERSION

from hmi.security.errors import TooManyTries, WeakPassword

R = TypeVar("R")

MIN_CHARS = 10
MAX_CHARS = 128  # longer ones only cost time
THREADS = 2  # each hash takes 46 MiB and some 50 ms of one core
MAX_WAITING = 32
_MIN_DIFFERENT = 5
_COMMON = frozenset({
    "password", "passwort", "1234567890", "12345678910", "qwertyuiop", "letmein", "headland", "administrator",
    "welcome", "changeme", "farm", "tractor", "landwirt",
})  # fmt: skip
_PIN = re.compile(r"[0-9]{4}")


def default_hasher() -> PasswordHasher:
    """Return argon2id as OWASP recommends for 46 MiB, one lane: the console shares two cores with its event loop."""
    return PasswordHasher(time_cost=2, memory_cost=46 * 1024, parallelism=1)


class Passwords:
    """Hashes and verifies, off the event loop.

    Args:
        secret: the installation's secret; keys PIN hashes, so that a stolen database alone does not give away PINs.
        hasher: cheaper one for tests.
    """

    def __init__(self, secret: str, hasher: PasswordHasher | None = None) -> None:
        self._key = hashlib.sha256(b"headland-pin-1" + secret.encode()).digest()
        self._hasher = hasher or default_hasher()
        self._threads = ThreadPoolExecutor(THREADS, thread_name_prefix="argon2")
        self._waiting = 0
        self._nobody = _hash_of_nobody(self._hasher)

    async def hash_password(self, password: str) -> str:
        """Return the argon2id hash of a password."""
        return await self._run(lambda: self._hasher.hash(_normal(password)))

    async def hash_pin(self, user_id: str, pin: str) -> str:
        """Return the argon2id hash of a PIN, bound to its person."""
        return await self._run(lambda: self._hasher.hash(self._keyed(user_id, pin)))

    async def verify_password(self, stored: str | None, password: str) -> bool:
        """Say whether ``password`` is the one; as slow for ``None`` (nobody) as for somebody."""
        return await self._run(lambda: self._verify(stored, _normal(password[: MAX_CHARS + 1])))

    async def verify_pin(self, stored: str | None, user_id: str, pin: str) -> bool:
        """Say whether ``pin`` is the one; as slow for ``None`` as for somebody."""
        return await self._run(lambda: self._verify(stored, self._keyed(user_id, pin[:8])))

    def is_outdated(self, stored: str) -> bool:
        """Say whether a hash was made with weaker settings than today's."""
        try:
            return self._hasher.check_needs_rehash(stored)
        except InvalidHashError:
            return False

    def close(self) -> None:
        """End the threads."""
        self._threads.shutdown(wait=False, cancel_futures=True)

    def _verify(self, stored: str | None, given: str) -> bool:
        try:
            is_right = self._hasher.verify(stored or self._nobody, given)
        except (VerificationError, InvalidHashError):
            return False
        return is_right and stored is not None

    def _keyed(self, user_id: str, pin: str) -> str:
        return hmac.new(self._key, f"{user_id}:{pin}".encode(), hashlib.sha256).hexdigest()

    async def _run(self, work: Callable[[], R]) -> R:
        if self._waiting >= MAX_WAITING:
            raise TooManyTries("Too many people are signing in at the same time. Try again.", 2.0)
        self._waiting += 1
        try:
            return await asyncio.get_running_loop().run_in_executor(self._threads, work)
        finally:
            self._waiting -= 1


def check_password(password: str, *names: str) -> None:
    """Return if a new password keeps the rules: long enough, not one everybody tries, not the person's name.

    Raises:
        WeakPassword: with the rule that it breaks.
    """
    normal = _normal(password)
    folded = normal.casefold()
    if len(normal) < MIN_CHARS:
        raise WeakPassword(f"The password needs at least {MIN_CHARS} characters.", "password")
    if len(normal) > MAX_CHARS:
        raise WeakPassword(f"The password can have {MAX_CHARS} characters at most.", "password")
    if len(set(folded)) < _MIN_DIFFERENT or folded.strip("0123456789!.") in _COMMON or folded in _COMMON:
        raise WeakPassword("This password is one of the first that others try. Choose another.", "password")
    if any(len(name) >= 4 and name.casefold() in folded for name in names):
        raise WeakPassword("The password must not contain the name.", "password")


def check_pin(pin: str) -> None:
    """Return if a new PIN keeps the rules: four digits, not all the same, not counting up or down.

    Raises:
        WeakPassword: with the rule that it breaks.
    """
    if not is_pin(pin):
        raise WeakPassword("A PIN has four digits.", "pin")
    steps = {int(b) - int(a) for a, b in itertools.pairwise(pin)}
    if steps in ({0}, {1}, {-1}):
        raise WeakPassword("Choose a PIN that is harder to guess than 1234.", "pin")


def is_pin(text: str) -> bool:
    """Say whether ``text`` has the form of a PIN."""
    return _PIN.fullmatch(text) is not None


def _hash_of_nobody(hasher: PasswordHasher) -> str:
    """Return what unknown names are verified against: as slow as a known one, without making a hash at the start."""
    salt, digest = (
        base64.b64encode(secrets.token_bytes(length)).rstrip(b"=").decode()
        for length in (hasher.salt_len, hasher.hash_len)
    )
    cost = f"m={hasher.memory_cost},t={hasher.time_cost},p={hasher.parallelism}"
    return f"$argon2id$v={ARGON2_VERSION}${cost}${salt}${digest}"


def _normal(password: str) -> str:
    """Return one form of what different keyboards send for the same letters."""
    return unicodedata.normalize("NFKC", password)
