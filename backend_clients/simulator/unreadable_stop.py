"""A STOP that does not keep to the contract still stops: a newer console may say more than we know."""

from __future__ import annotations

import hashlib
from typing import Any

import msgspec

from backend_clients.edge.messages_down import Stop


def read_anyway(robot: str, payload: bytes) -> Stop | None:
    """Return the STOP meant by ``payload``, or ``None`` if it names another robot."""
    said = _fields(payload)
    if said.get("robot", robot) != robot:
        return None
    stop_id = said.get("stop_id")
    if not isinstance(stop_id, str) or not 8 <= len(stop_id) <= 64:
        # from the content alone, so that its repeats are one press
        stop_id = f"unreadable-{hashlib.sha256(payload).hexdigest()[:32]}"
    return Stop(robot=robot, stop_id=stop_id, by=_word(said.get("by")) or "unknown", device=_word(said.get("device")))


def _fields(payload: bytes) -> dict[str, Any]:
    try:
        said = msgspec.json.decode(payload)
    except (msgspec.DecodeError, RecursionError, UnicodeDecodeError):
        return {}
    return said if isinstance(said, dict) else {}


def _word(value: Any) -> str:
    return value[:80] if isinstance(value, str) else ""
