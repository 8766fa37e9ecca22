"""Attribute values in formats that know text only, such that they come back as what they were.

A text stands as it is where it cannot be mistaken for anything else; every other value is written as JSON
(RFC 8259), and so is a text that looks like JSON or that XML or a table would change.
"""

from __future__ import annotations

import json
from typing import Any

from hmi.map_files.xml_tree import is_clean


def encode(value: Any) -> str:
    """Return the value as text."""
    if isinstance(value, str) and _stands_as_it_is(value):
        return value
    return json.dumps(value, sort_keys=True, allow_nan=False)


def decode(text: str) -> Any:
    """Return the value of a text that ``encode`` made."""
    try:
        return json.loads(text, parse_constant=_refuse)
    except (ValueError, RecursionError):
        return text


def _stands_as_it_is(text: str) -> bool:
    is_one_line = not set(text) & {"\n", "\t"}
    return bool(text) and text == text.strip() and is_one_line and is_clean(text) and decode(text) == text


def _refuse(constant: str) -> Any:
    raise ValueError(constant)
