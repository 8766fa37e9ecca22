"""A farm with three people and a tablet, signed in by hashes that cost nothing."""

from __future__ import annotations

from collections.abc import AsyncIterator
from dataclasses import dataclass, field
from pathlib import Path

import pytest_asyncio
from argon2 import PasswordHasher

from hmi.clock import FakeClock
from hmi.domain.role import Role
from hmi.security.accounts import Accounts
from hmi.security.enrolment import Enrolment
from hmi.security.passwords import Passwords
from hmi.security.sessions import Sessions
from hmi.security.sign_in import SignIn
from hmi.security.stop_tokens import StopTokens
from hmi.store.audit import AuditEntry
from hmi.store.database import Database
from hmi.store.devices import Devices
from hmi.store.stop_list import StopList
from hmi.store.users import Users
from tests.hmi.store.conftest import FARM, clock, database, migrated, server

__all__ = ["FARM", "clock", "database", "migrated", "server"]
SECRET = "a secret that only this test knows"
LIFETIME_S = 12 * 3600.0
PASSWORD = "horse-battery-7"
ADDRESS = "192.168.1.20"


@dataclass
class Farmyard:
    """Everything that decides who gets in, put together as the console does."""

    database: Database
    clock: FakeClock
    folder: Path
    audited: list[AuditEntry] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.stop_list = StopList(self.database, FARM, self.folder)
        self.users = Users(self.database, self.clock)
        self.devices = Devices(self.database, self.clock, self.stop_list)
        self.sessions = Sessions(self.database, self.clock, FARM, LIFETIME_S)
        self.hasher = PasswordHasher(time_cost=1, memory_cost=8, parallelism=1)
        self.passwords = Passwords(SECRET, self.hasher)
        self.tokens = StopTokens(SECRET, self.devices.is_revoked)
        self.accounts = Accounts(
            self.database, FARM, self.users, self.sessions, self.passwords, self.stop_list, self.audited.append
        )
        self.enrolment = Enrolment(self.database, self.devices, self.sessions, self.tokens, self.audited.append)
        self.sign_in = self.sign_in_with(self.passwords)

    def sign_in_with(self, passwords: Passwords) -> SignIn:
        """Return a way in that hashes as ``passwords`` does."""
        return SignIn(
            self.database, self.clock, FARM, self.users, self.devices, self.sessions, passwords, self.tokens,
            self.audited.append,
        )  # fmt: skip

    async def tablet(self) -> str:
        """Enrol a tablet and return the STOP token it keeps when nobody is signed in on it."""
        admin = await self.sign_in.with_password("jonas", PASSWORD, address=ADDRESS)
        enrolled = await self.enrolment.enrol(admin.session, "Tablet 3")
        return await self.sign_in.sign_out(enrolled.session)


@pytest_asyncio.fixture
async def yard(database: Database, clock: FakeClock, tmp_path: Path) -> AsyncIterator[Farmyard]:
    """Return a farm with an operator (PIN 4826), a viewer and an admin."""
    yard = Farmyard(database, clock, tmp_path / "stop")
    await yard.accounts.create_user("Martha Keller", Role.OPERATOR, PASSWORD, by="system", user_id="martha", pin="4826")
    await yard.accounts.create_user("Lena Vogt", Role.VIEWER, PASSWORD, by="system")
    await yard.accounts.create_user("Jonas Weber", Role.ADMIN, PASSWORD, by="system", user_id="jonas")
    yield yard
    yard.passwords.close()
