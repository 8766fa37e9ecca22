"""Texts that a broker refuses, made into texts it keeps, and back, without loss.

Orion refuses ``< > " ' = ; ( )`` in values. They become ``%3C`` and so on. A ``%`` stays as it is, unless it would
be read as such a code: then it becomes ``%25``. So "50 %" stays readable, and what was never escaped mostly reads as
it is.
"""

from __future__ import annotations

import re

from pydantic import JsonValue

from backend_clients.ngsi.errors import BadInput

FORBIDDEN = "<>\"'=;()"
_CODES = {c: f"%{ord(c):02X}" for c in FORBIDDEN + "%"}
_KEY_CODES = _CODES | {"$": "%24"}  # at the beginning of a member it would be an update operator
_BACK = {code: c for c, code in _KEY_CODES.items()}
_AMBIGUOUS = "|".join(code[1:] for code in _KEY_CODES.values())
_ESCAPE = re.compile(rf"[<>\"'=;()]|%(?={_AMBIGUOUS})")
_UNESCAPE = re.compile(rf"%(?:{_AMBIGUOUS})")
MAX_DEPTH = 50


def escape(text: str) -> str:
    """Return a text without forbidden characters; ``unescape`` gives back the original."""
    return _ESCAPE.sub(lambda found: _CODES[found.group()], text)


def unescape(text: str) -> str:
    """Return the text that ``escape`` was given."""
    return _UNESCAPE.sub(lambda found: _BACK[found.group()], text)


def escape_value(value: JsonValue, depth: int = 0) -> JsonValue:
    """Return a JSON value with every text in it escaped, names of members too."""
    if depth > MAX_DEPTH:
        raise BadInput(f"a value is nested deeper than {MAX_DEPTH} levels")
    if isinstance(value, str):
        return escape(value)
    if isinstance(value, list):
        return [escape_value(item, depth + 1) for item in value]
    if isinstance(value, dict):
        return {escape_key(key): escape_value(item, depth + 1) for key, item in value.items()}
    return value


def unescape_value(value: JsonValue) -> JsonValue:
    """Return the value that ``escape_value`` was given."""
    if isinstance(value, str):
        return unescape(value)
    if isinstance(value, list):
        return [unescape_value(item) for item in value]
    if isinstance(value, dict):
        return {unescape(key): unescape_value(item) for key, item in value.items()}
    return value


def escape_key(key: str) -> str:
    """Return the name of a member without forbidden characters, and not looking like an update operator."""
    escaped = escape(key)
    return _KEY_CODES["$"] + escaped[1:] if escaped.startswith("$") else escaped
