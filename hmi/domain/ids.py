"""The rule every id follows, and how ids are made."""

from __future__ import annotations

import re
import uuid

ID_PATTERN = r"^[a-z0-9][a-z0-9_-]{0,63}$"
_ID = re.compile(ID_PATTERN)


def is_id(text: str) -> bool:
    """Say whether ``text`` may name a robot, user, mission, device or farm."""
    return _ID.fullmatch(text) is not None


def new_id() -> str:
    """Return a fresh random id, 32 hex digits."""
    return uuid.uuid4().hex
