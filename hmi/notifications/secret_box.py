"""Keeps passwords of channels: encrypted in the database, with the key in a file beside it.

Encrypted rather than hashed, for they have to be used; the key in its own file, so that a copy of the database,
a dump or a PostgreSQL server alone opens nothing. Whoever can read the whole data folder can read them.
"""

from __future__ import annotations

import logging
import os
from pathlib import Path

from cryptography.fernet import Fernet, InvalidToken

log = logging.getLogger(__name__)


class SecretBox:
    """Encrypts and opens; the key is made when it is first needed. Blocking.

    Args:
        path: the key file, readable by its owner only.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._fernet: Fernet | None = None

    def seal(self, secret: str) -> str:
        """Return a secret as it may be stored; raises ``OSError`` if no key can be made."""
        return self._box().encrypt(secret.encode()).decode() if secret else ""

    def open(self, sealed: str) -> str:
        """Return a stored secret; empty, and logged, if it was sealed with another key."""
        if not sealed:
            return ""
        try:
            return self._box().decrypt(sealed.encode()).decode()
        except (InvalidToken, ValueError, OSError):
            log.warning("a stored password cannot be opened with %s: it has to be entered again", self._path)
            return ""

    def _box(self) -> Fernet:
        if self._fernet is None:
            self._fernet = Fernet(self._key())
        return self._fernet

    def _key(self) -> bytes:
        try:
            return self._path.read_bytes()
        except FileNotFoundError:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            key = Fernet.generate_key()
            file = os.open(self._path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
            try:
                os.write(file, key)
                os.fsync(file)
            finally:
                os.close(file)
            return key
