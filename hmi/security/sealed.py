"""Passwords of cameras in the database: encrypted, with a key made of the installation's secret.

Encrypted rather than hashed, for they have to be used. A copy of the database alone opens nothing; another secret
opens nothing either, and the password has to be entered again.
"""

from __future__ import annotations

import base64

from cryptography.fernet import Fernet, InvalidToken
from cryptography.hazmat.primitives.hashes import SHA256
from cryptography.hazmat.primitives.kdf.hkdf import HKDF


class Seal:
    """Encrypts and opens texts.

    Args:
        secret: the installation's.
        purpose: what is sealed; each purpose has a key of its own.
    """

    def __init__(self, secret: str, purpose: str) -> None:
        key = HKDF(SHA256(), 32, salt=None, info=f"headland {purpose}".encode()).derive(secret.encode())
        self._fernet = Fernet(base64.urlsafe_b64encode(key))

    def seal(self, text: str) -> str:
        """Return a text as it may be stored; an empty one stays empty."""
        return self._fernet.encrypt(text.encode()).decode() if text else ""

    def open(self, sealed: str) -> str | None:
        """Return a stored text, ``None`` if it was sealed with another secret."""
        if not sealed:
            return ""
        try:
            return self._fernet.decrypt(sealed.encode()).decode()
        except (InvalidToken, ValueError):
            return None
