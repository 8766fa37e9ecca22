"""The accounts of the demo. They exist in demo mode only: everybody can read their passwords here."""

from __future__ import annotations

from dataclasses import dataclass

from hmi.domain.role import Role
from hmi.security.accounts import Accounts
from hmi.store.users import User


@dataclass(frozen=True, slots=True)
class DemoUser:
    """One demo account; id, role and password are the same word."""

    role: Role
    name: str
    pin: str = ""


DEMO_USERS = (
    DemoUser(Role.VIEWER, "Lena Vogt"),
    DemoUser(Role.OPERATOR, "Martha Keller", "1111"),
    DemoUser(Role.PLANNER, "Pieter de Vries"),
    DemoUser(Role.SUPERVISOR, "Anna Ostermeier", "2222"),
    DemoUser(Role.DISPATCHER, "Tomas Lind"),
    DemoUser(Role.ADMIN, "Jonas Weber"),
)


async def seed_demo_users(accounts: Accounts) -> list[User]:
    """Add the demo accounts that are missing; return the added ones."""
    known = {user.id for user in await accounts.all()}
    return [
        await accounts.create_unchecked(
            one.name, one.role, one.role.value, by="system", user_id=one.role.value, pin=one.pin
        )
        for one in DEMO_USERS
        if one.role.value not in known
    ]
