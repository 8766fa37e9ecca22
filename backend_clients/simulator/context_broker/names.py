"""Which texts may be an id, a type, a name or a value."""

from __future__ import annotations

from backend_clients.simulator.context_broker.json_text import Json
from backend_clients.simulator.context_broker.refusal import bad_request

FORBIDDEN = frozenset("<>\"'=;()")
FORBIDDEN_IN_NAMES = FORBIDDEN | frozenset("&?/#")
MAX_NAME = 256


def checked_name(what: str, given: Json) -> str:
    """Return ``given`` if it may be a name; ``what`` is what Orion calls it, e.g. ``entity id``."""
    if not isinstance(given, str):
        raise bad_request(f"Invalid JSON type for {what}")
    if not given:
        raise bad_request(f"{what} length: 0, min length supported: 1")
    if len(given) > MAX_NAME:
        raise bad_request(f"{what} length: {len(given)}, max length supported: {MAX_NAME}")
    if any(c in FORBIDDEN_IN_NAMES or not "!" <= c <= "~" for c in given):
        raise bad_request(f"Invalid characters in {what}")
    return given


def check_value(what: str, value: Json) -> None:
    """Refuse a value with a forbidden character in a text at any depth; names of members are free."""
    if isinstance(value, str) and not FORBIDDEN.isdisjoint(value):
        raise bad_request(f"Invalid characters in {what}")
    if isinstance(value, list):
        for item in value:
            check_value(what, item)
    if isinstance(value, dict):
        for item in value.values():
            check_value(what, item)
