"""The session cookie: how it is made, set, read and taken away."""

from __future__ import annotations

import hashlib
import secrets
from collections.abc import Iterable

COOKIE_NAME = "headland_session"
CSRF_HEADER = "x-headland-csrf"
_BYTES = 32  # 256 bit: not to be guessed, so a plain SHA-256 of it is a safe key


def new_cookie() -> str:
    """Return a fresh random cookie value."""
    return secrets.token_urlsafe(_BYTES)


def session_id_of(cookie: str) -> str:
    """Return what the database keeps of a cookie."""
    return hashlib.sha256(cookie.encode("utf-8", "replace")).hexdigest()


def set_cookie_header(value: str, max_age_s: float, *, is_secure: bool) -> str:
    """Return the ``Set-Cookie`` value of a fresh session.

    Args:
        is_secure: the request came by HTTPS. On plain HTTP in a local network the cookie cannot be ``Secure``.
    """
    secure = "; Secure" if is_secure else ""
    return f"{COOKIE_NAME}={value}; Path=/; Max-Age={int(max_age_s)}; HttpOnly; SameSite=Lax{secure}"


def clear_cookie_header() -> str:
    """Return the ``Set-Cookie`` value that signs a browser out."""
    return f"{COOKIE_NAME}=; Path=/; Max-Age=0; HttpOnly; SameSite=Lax"


def cookies_in(headers: Iterable[tuple[bytes, bytes]]) -> list[str]:
    """Return every value of our cookie in raw ASGI headers: a planted second one must not hide the first."""
    start = f"{COOKIE_NAME}=".encode()
    return [
        part.strip()[len(start) :].decode("latin-1")
        for name, value in headers
        if name == b"cookie" and start in value
        for part in value.split(b";")
        if part.strip().startswith(start)
    ]
