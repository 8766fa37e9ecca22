"""What a robot's own HTTP address and token may look like; pure."""

from __future__ import annotations

from urllib.parse import urlsplit

PRINTABLE = range(0x20, 0x7F)


def usable_address(text: str) -> str:
    """Return ``text`` as it is kept.

    Raises:
        ValueError: it is no address that can be called; the message says what to write.
    """
    parts = urlsplit(text)
    if parts.scheme not in ("http", "https") or not parts.hostname or parts.username or parts.query or parts.fragment:
        raise ValueError("use http://host:port/path, without user, query or fragment")
    try:
        parts.hostname.encode("idna")
    except UnicodeError as error:
        raise ValueError("this host name cannot be called: use http://host:port/path") from error
    try:
        is_port = parts.port != 0
    except ValueError:
        is_port = False
    if not is_port:
        raise ValueError("use a port from 1 to 65535")
    return text.rstrip("/")


def usable_token(text: str) -> str:
    """Return ``text`` if it can travel in a header of HTTP.

    Raises:
        ValueError: it has letters or signs that cannot.
    """
    if any(ord(letter) not in PRINTABLE for letter in text):
        raise ValueError("a token has letters, digits and signs of plain English text only: it travels in a header")
    return text
