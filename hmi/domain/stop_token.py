"""The token that lets a browser press STOP, checked by its signature alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from itsdangerous import BadData, URLSafeSerializer

SALT = "headland-stop-1"
MAX_CHARS = 2048  # honest ones are under 300
_FIELDS = {"d": "device_id", "dn": "device_name", "u": "user_id", "un": "user_name", "f": "farm_id"}


class BadStopToken(Exception):
    """The token was not signed by this installation, or says something unreadable."""


@dataclass(frozen=True, slots=True)
class StopToken:
    """Who presses: an enrolled tablet, and the person signed in on it (empty on the sign-in page)."""

    device_id: str
    device_name: str
    user_id: str
    user_name: str
    farm_id: str

    @property
    def who(self) -> str:
        """The name a robot and a person read: the user, or the tablet where nobody is signed in."""
        return self.user_name or self.device_name

    def sign(self, secret: str) -> str:
        """Return the token as the browser keeps it."""
        text = URLSafeSerializer(secret, salt=SALT).dumps({k: getattr(self, name) for k, name in _FIELDS.items()})
        return text if isinstance(text, str) else text.decode("ascii")

    @classmethod
    def read(cls, text: str, secret: str) -> StopToken:
        """Return what a token says; raises ``BadStopToken``. Needs no database, so STOP works without one."""
        if len(text) > MAX_CHARS:
            raise BadStopToken("too long")
        try:
            fields: Any = URLSafeSerializer(secret, salt=SALT).loads(text)
        except BadData as error:
            raise BadStopToken(str(error)) from error
        if not isinstance(fields, dict) or not all(isinstance(fields.get(k), str) for k in _FIELDS):
            raise BadStopToken("fields are missing")
        return cls(**{name: str(fields[k])[:80] for k, name in _FIELDS.items()})
