"""People and their rights: made, changed and switched off, each change audited and in force at once."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from hmi.domain.role import Role
from hmi.security.errors import BadAccount
from hmi.security.passwords import Passwords, check_password, check_pin
from hmi.security.sessions import RIGHTS_CHANGED, Sessions
from hmi.security.sign_in import user_id_of
from hmi.store.audit_chain import AuditEntry
from hmi.store.database import Database
from hmi.store.errors import AlreadyExists
from hmi.store.stop_list import StopList
from hmi.store.users import User, Users

_MAX_NAME = 80


class Accounts:
    """The people of one farm. Whoever calls has asked for ``Permission.MANAGE_USERS`` first.

    ``by`` is always the name of the person who does it, for the audit; ``system`` at the first start.
    """

    def __init__(
        self,
        database: Database,
        farm_id: str,
        users: Users,
        sessions: Sessions,
        passwords: Passwords,
        stop_list: StopList,
        audit: Callable[[AuditEntry], None],
    ) -> None:
        self._database = database
        self._farm_id = farm_id
        self._users = users
        self._sessions = sessions
        self._passwords = passwords
        self._stop_list = stop_list
        self._audit = audit
        self.on_changed: list[Callable[[str], Awaitable[None]]] = []  # told by whom, after each change of rights

    async def all(self) -> list[User]:
        """Return everybody, by name."""
        return await self._database.run(self._users.all, self._farm_id)

    async def create_user(
        self, name: str, role: Role, password: str, *, by: str, user_id: str = "", pin: str = ""
    ) -> User:
        """Add a person, who signs in as ``user_id`` (made from the name if not given).

        Raises:
            BadAccount: no usable name, or it is taken.
            WeakPassword: the password or PIN breaks a rule.
        """
        check_password(password, name, user_id)
        if pin:
            check_pin(pin)
        return await self.create_unchecked(name, role, password, by=by, user_id=user_id, pin=pin)

    async def create_unchecked(
        self, name: str, role: Role, password: str, *, by: str, user_id: str = "", pin: str = ""
    ) -> User:
        """As ``create_user`` without the rules for passwords and PINs: for demo accounts only."""
        shown = _name(name)
        key = user_id_of(user_id or name)
        if not key:
            raise BadAccount("The name to sign in with may have letters a-z, digits, - and _ only.", "user_id")
        password_hash = await self._passwords.hash_password(password)
        pin_hash = await self._passwords.hash_pin(key, pin) if pin else None
        try:
            user = await self._database.run(self._users.add, key, self._farm_id, shown, role, password_hash, pin_hash)
        except AlreadyExists:
            raise BadAccount(f"Somebody already signs in as {key}.", "user_id", "taken") from None
        self._note(by, user, "created", {"role": role.value})
        return user

    async def set_password(self, user_id: str, password: str, *, by: str) -> None:
        """Give a person a new password; all their sessions end.

        Raises:
            WeakPassword: it breaks a rule.
            BadAccount: nobody has this id.
        """
        user = await self._one(user_id)
        check_password(password, user.id, user.name)
        password_hash = await self._passwords.hash_password(password)
        await self._database.run(self._users.set_password_hash, self._farm_id, user_id, password_hash)
        self._note(by, user, "password_changed")
        await self._sessions.end_all_of(user_id, RIGHTS_CHANGED)

    async def set_pin(self, user_id: str, pin: str, *, by: str) -> None:
        """Give a person a PIN, or take it away with an empty text. Raises as ``set_password`` does."""
        user = await self._one(user_id)
        if pin:
            check_pin(pin)
        pin_hash = await self._passwords.hash_pin(user_id, pin) if pin else None
        await self._database.run(self._users.set_pin_hash, self._farm_id, user_id, pin_hash)
        self._note(by, user, "pin_changed" if pin else "pin_removed")

    async def change(
        self, user_id: str, *, by: str, name: str | None = None, role: Role | None = None, is_active: bool | None = None
    ) -> User:
        """Change name, role, or whether somebody may sign in; their sessions end, so that it holds at once.

        Raises:
            BadAccount: nobody has this id, or no admin would be left.
            StopListNotWritten: switched off here, but their STOP token still works at the gateway.
        """
        before = await self._one(user_id)
        shown = None if name is None else _name(name)
        loses_admin = before.role is Role.ADMIN and (role not in (None, Role.ADMIN) or is_active is False)
        if before.is_active and loses_admin and not await self._has_other_admin(user_id):
            raise BadAccount("Somebody must stay admin. Make another admin first.", "role", "last_admin")
        after = await self._database.run(
            self._users.change, self._farm_id, user_id, name=shown, role=role, is_active=is_active
        )
        changes = {"name": shown, "role": role.value if role else None, "is_active": is_active}
        self._note(by, after, "changed", {key: value for key, value in changes.items() if value is not None})
        await self._sessions.end_all_of(user_id, RIGHTS_CHANGED)
        for listener in self.on_changed:
            await listener(by)
        if before.is_active != after.is_active:
            await self._database.run(self._stop_list.export)
        return after

    async def _one(self, user_id: str) -> User:
        user = await self._database.run(self._users.get, user_id)
        if user is None or user.farm_id != self._farm_id:
            raise BadAccount(f"Nobody signs in as {user_id[:64]}.", "user_id", "unknown")
        return user

    async def _has_other_admin(self, user_id: str) -> bool:
        return any(u.role is Role.ADMIN and u.is_active and u.id != user_id for u in await self.all())

    def _note(self, by: str, user: User, outcome: str, data: dict[str, object] | None = None) -> None:
        self._audit(AuditEntry(self._farm_id, by, "", "account", outcome, ref=user.id, text=user.name, data=data))


def _name(name: str) -> str:
    shown = " ".join(name.split())
    if not shown or len(shown) > _MAX_NAME or not shown.isprintable():
        raise BadAccount(f"A name has 1 to {_MAX_NAME} letters.", "name")
    return shown
