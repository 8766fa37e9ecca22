"""Signing in and out: by name and password everywhere, by PIN on enrolled tablets."""

from __future__ import annotations

import unicodedata
from collections.abc import Callable
from dataclasses import dataclass

from hmi.clock import Clock
from hmi.domain.ids import is_id, new_id
from hmi.domain.role import Role
from hmi.security.errors import BadToken, NotEnrolled, TooManyTries, WrongCredentials
from hmi.security.lockout import ADDRESS_RULE, PASSWORD_RULE, PIN_RULE, Blocked, Lockout, address_key
from hmi.security.passwords import Passwords, is_pin
from hmi.security.session_info import SessionInfo
from hmi.security.sessions import SIGNED_OUT, Sessions
from hmi.security.stop_tokens import StopTokens
from hmi.store.audit_chain import AuditEntry
from hmi.store.database import Database
from hmi.store.devices import Device, Devices
from hmi.store.users import Credentials, Users

BROWSER = "browser-"  # device ids of browsers that are not enrolled; they last as long as the session
WRONG_PASSWORD = "Name or password is wrong."  # noqa: S105 - a text, not a secret
NOT_ENROLLED = "This tablet is not enrolled. STOP does not work here."


@dataclass(frozen=True, slots=True)
class SignedIn:
    """What a browser gets: the cookie, and the token that makes STOP work without us."""

    cookie: str
    session: SessionInfo
    stop_token: str


@dataclass(frozen=True, slots=True)
class Person:
    """A tile on the sign-in page of an enrolled tablet."""

    id: str
    name: str
    role: Role


class SignIn:
    """The way in. On the event loop; hashing and the database run in threads."""

    def __init__(
        self,
        database: Database,
        clock: Clock,
        farm_id: str,
        users: Users,
        devices: Devices,
        sessions: Sessions,
        passwords: Passwords,
        tokens: StopTokens,
        audit: Callable[[AuditEntry], None],
    ) -> None:
        self._database = database
        self._farm_id = farm_id
        self._users = users
        self._devices = devices
        self._sessions = sessions
        self._passwords = passwords
        self._tokens = tokens
        self._audit = audit
        self._by_name = Lockout(PASSWORD_RULE, clock.mono_s)
        self._by_address = Lockout(ADDRESS_RULE, clock.mono_s)
        self._by_pin = Lockout(PIN_RULE, clock.mono_s)

    async def with_password(
        self, name: str, password: str, *, address: str, stop_token: str = "", old_cookie: str | None = None
    ) -> SignedIn:
        """Sign in by name and password.

        Args:
            name: what was typed; capitals and blanks do not matter.
            address: where the request came from.
            stop_token: what the browser kept; names the tablet if it is enrolled.
            old_cookie: the cookie it sent; that session ends, a fresh one begins.

        Raises:
            WrongCredentials: unknown name or wrong password; both take the same time.
            TooManyTries: wait first; nothing was checked.
        """
        user_id = user_id_of(name)
        device = await self._enrolled(stop_token)
        # Wrong tries elsewhere must not lock somebody out of the tablet in the field, so each tablet counts apart.
        key = f"{user_id}@{device.id if device else ''}"
        self._begin(self._by_address, address_key(address), "from this address")
        self._begin(self._by_name, key, "for this name")
        known = await self._credentials(user_id)
        if not await self._passwords.verify_password(known.password_hash if known else None, password) or known is None:
            self._note(known, device, "sign_in", "refused", WRONG_PASSWORD, address)
            raise WrongCredentials(WRONG_PASSWORD)
        self._by_name.succeed(key)
        self._by_pin.succeed(user_id)
        self._by_address.take_back(address_key(address))
        await self._refresh_hash(known, password)
        return await self._admit(known, device, address, old_cookie)

    async def with_pin(
        self, user_id: str, pin: str, *, address: str, stop_token: str, old_cookie: str | None = None
    ) -> SignedIn:
        """Sign in by PIN, on an enrolled tablet only.

        Raises:
            NotEnrolled: this browser is no enrolled tablet.
            WrongCredentials: with the number of tries that are left.
            TooManyTries: the PIN is locked; a password still works.
        """
        device = await self._enrolled(stop_token)
        if device is None:
            raise NotEnrolled(NOT_ENROLLED)
        user_id = user_id_of(user_id)
        self._begin(self._by_address, address_key(address), "from this address")
        try:
            self._by_pin.begin(user_id)
        except Blocked as blocked:
            text = f"The PIN is locked for {_wait_text(blocked.wait_s)}. Use name and password."
            raise TooManyTries(text, blocked.wait_s) from None
        known = await self._credentials(user_id)
        stored = known.pin_hash if known else None
        is_right = await self._passwords.verify_pin(stored, user_id, pin if is_pin(pin) else "")
        if not is_right or known is None:
            text = self._wrong_pin(user_id)
            self._note(known, device, "sign_in", "refused", text, address)
            raise WrongCredentials(text)
        self._by_pin.succeed(user_id)
        self._by_address.take_back(address_key(address))
        return await self._admit(known, device, address, old_cookie)

    async def sign_out(self, session: SessionInfo) -> str:
        """End a session; return the token of the enrolled tablet (STOP works on its sign-in page), else ``""``."""
        await self._sessions.end(session.session_id, SIGNED_OUT)
        self._audit(
            AuditEntry(session.farm_id, session.user_name, session.device_name, "sign_out", "ok", ref=session.user_id)
        )
        if session.device_id.startswith(BROWSER):
            return ""
        device = await self._database.run(self._devices.get, session.device_id)
        return self._tokens.issue_for_device(device) if device and device.revoked_at is None else ""

    async def people(self, stop_token: str) -> list[Person]:
        """Return who has a PIN, for the tiles of an enrolled tablet; nobody elsewhere."""
        if await self._enrolled(stop_token) is None:
            return []
        users = await self._database.run(self._users.all, self._farm_id)
        return [Person(user.id, user.name, user.role) for user in users if user.is_active and user.has_pin]

    async def _enrolled(self, stop_token: str) -> Device | None:
        """Return the enrolled tablet that the token names, ``None`` if it is none of ours."""
        if not stop_token:
            return None
        try:
            token = self._tokens.read_stop_token(stop_token)
        except BadToken:
            return None
        device = await self._database.run(self._devices.get, token.device_id)
        is_ours = device is not None and device.farm_id == self._farm_id and device.revoked_at is None
        return device if is_ours else None

    async def _credentials(self, user_id: str) -> Credentials | None:
        known = await self._database.run(self._users.credentials, user_id)
        is_ours = known is not None and known.user.is_active and known.user.farm_id == self._farm_id
        return known if is_ours else None

    async def _refresh_hash(self, known: Credentials, password: str) -> None:
        if self._passwords.is_outdated(known.password_hash):
            fresh = await self._passwords.hash_password(password)
            await self._database.run(self._users.set_password_hash, self._farm_id, known.user.id, fresh)

    async def _admit(self, known: Credentials, device: Device | None, address: str, old_cookie: str | None) -> SignedIn:
        old = self._sessions.lookup(old_cookie)
        device_id, device_name = (device.id, device.name) if device else (f"{BROWSER}{new_id()}", "")
        cookie, session = await self._sessions.open(known.user, device_id, device_name)
        if old is not None:
            await self._sessions.end(old.session_id, "Somebody signed in on this browser again.")
        self._note(known, device, "sign_in", "accepted", "", address)
        return SignedIn(cookie, session, self._tokens.issue_stop_token(session))

    def _begin(self, lockout: Lockout, key: str, where: str) -> None:
        try:
            lockout.begin(key)
        except Blocked as blocked:
            text = f"Too many wrong tries {where}. Wait {_wait_text(blocked.wait_s)}."
            raise TooManyTries(text, blocked.wait_s) from None

    def _wrong_pin(self, user_id: str) -> str:
        left = self._by_pin.tries_left(user_id)
        if left == 0:
            return f"Wrong PIN. It is locked for {_wait_text(PIN_RULE.first_wait_s)}. Use name and password."
        return f"Wrong PIN. {left} {'try' if left == 1 else 'tries'} left."

    def _note(
        self, known: Credentials | None, device: Device | None, kind: str, outcome: str, text: str, address: str
    ) -> None:
        # A name that nobody has is not written down: it may be a password typed into the wrong field.
        actor, ref = (known.user.name, known.user.id) if known else ("unknown", "")
        device_name = device.name if device else ""
        self._audit(
            AuditEntry(
                self._farm_id, actor, device_name, kind, outcome, ref=ref, text=text, data={"address": address[:64]}
            )
        )


def user_id_of(name: str) -> str:
    """Return the id that a typed name means: ``Martha Keller`` signs in as ``martha-keller``; ``""`` if it is none."""
    text = "-".join(unicodedata.normalize("NFKC", name[:200]).casefold().split())
    return text if is_id(text) else ""


def _wait_text(wait_s: float) -> str:
    """Word a wait, rounded up."""
    if wait_s <= 90:
        return f"{max(1, -(-int(wait_s * 10) // 10))} s"
    return f"{-(-int(wait_s) // 60)} min"
