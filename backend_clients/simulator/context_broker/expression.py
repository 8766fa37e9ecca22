"""The simple query language of ``q`` and ``mq``: read once, then asked of each entity."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime

from backend_clients.simulator.context_broker import moment
from backend_clients.simulator.context_broker.entity import Entity
from backend_clients.simulator.context_broker.json_text import Json
from backend_clients.simulator.context_broker.refusal import bad_request

ABSENT = object()
_OPERATOR = re.compile(r"==|!=|>=|<=|~=|>|<|:")
_ORDER: dict[str, Callable[[Json, Json], bool]] = {
    ">": lambda a, b: bool(a > b),
    "<": lambda a, b: bool(a < b),
    ">=": lambda a, b: bool(a >= b),
    "<=": lambda a, b: bool(a <= b),
}


@dataclass(frozen=True, slots=True)
class Statement:
    """One condition: where to look, how to compare, with what; a range is two values."""

    path: tuple[str, ...]
    operator: str  # "exists", "absent" or one of the comparisons
    values: tuple[Json, ...] = ()
    is_range: bool = False

    def holds(self, found: Json) -> bool:
        """Say whether a value found at the path meets it; ``ABSENT`` is nothing there."""
        if self.operator in ("exists", "absent"):
            return (found is not ABSENT) == (self.operator == "exists")
        if found is ABSENT:
            return False
        if self.operator in ("==", "!="):
            return self._equal(found) == (self.operator == "==")
        if self.operator == "~=":
            return isinstance(found, str) and self._pattern_found(found)
        left, right = _alike(found, self.values[0])
        return left is not None and _ORDER[self.operator](left, right)

    def _equal(self, found: Json) -> bool:
        for item in [found, *found] if isinstance(found, list) else [found]:
            if self.is_range:
                low, high = _alike(item, self.values[0]), _alike(item, self.values[1])
                if low[0] is not None and high[0] is not None and low[1] <= low[0] and high[0] <= high[1]:
                    return True
            elif any(_same(item, value) for value in self.values):
                return True
        return False

    def _pattern_found(self, text: str) -> bool:
        try:
            return re.search(str(self.values[0]), text) is not None
        except re.error:
            return False


@dataclass(frozen=True, slots=True)
class Expression:
    """All conditions of a ``q`` or an ``mq``; an entity is meant when all hold."""

    statements: tuple[Statement, ...]
    is_metadata: bool = False

    def matches(self, entity: Entity) -> bool:
        """Say whether an entity meets every condition."""
        look = _metadata_at if self.is_metadata else _value_at
        return all(statement.holds(look(entity, statement.path)) for statement in self.statements)


def read_expression(text: str, *, is_metadata: bool = False) -> Expression:
    """Return the conditions of a text, or refuse it."""
    parameter = "mq" if is_metadata else "q"
    if any(c in "()" for c in text):
        raise bad_request(f"invalid character found in URI param /{parameter}/")
    statements = tuple(_statement(part) for part in _split(text, ";"))
    if is_metadata and any(len(statement.path) < 2 for statement in statements):
        raise bad_request("Invalid mq expression: metadata name is missing")
    return Expression(statements, is_metadata)


def _statement(text: str) -> Statement:
    if not text.strip():
        raise bad_request("empty q-item")
    at = _operator_at(text)
    if at is None:
        is_absent = text.startswith("!")
        return Statement(_path(text[1:] if is_absent else text), "absent" if is_absent else "exists")
    left, operator, right = text[: at.start()], at.group(), text[at.end() :]
    if not left:
        raise bad_request("empty left-hand-side in q-item")
    if not right:
        raise bad_request("empty right-hand-side in q-item")
    operator = "==" if operator == ":" else operator
    if operator == "~=":
        return Statement(_path(left), operator, (right.strip("'") if right.startswith("'") else right,))
    return _comparison(_path(left), operator, right)


def _comparison(path: tuple[str, ...], operator: str, right: str) -> Statement:
    ends = _split(right, "..")
    if len(ends) == 2 and operator in ("==", "!="):
        return Statement(path, operator, tuple(_literal(end) for end in ends), is_range=True)
    values = tuple(_literal(item) for item in _split(right, ","))
    if operator in _ORDER and (len(values) > 1 or values[0] is None or isinstance(values[0], bool)):
        raise bad_request("values of type /true/, /false/, /null/ and lists cannot be compared in order")
    return Statement(path, operator, values)


def _operator_at(text: str) -> re.Match[str] | None:
    bare = re.sub(r"'[^']*'", lambda quoted: "_" * len(quoted.group()), text)
    return _OPERATOR.search(bare)


def _path(text: str) -> tuple[str, ...]:
    parts = tuple(part[1:-1] if part.startswith("'") and part.endswith("'") else part for part in _split(text, "."))
    if not all(parts):
        raise bad_request("empty left-hand-side in q-item")
    return parts


def _split(text: str, separator: str) -> list[str]:
    """Split at a separator that is not within single quotes."""
    parts, begin, at, quoted = [], 0, 0, False
    while at < len(text):
        quoted ^= text[at] == "'"
        if not quoted and text.startswith(separator, at):
            parts.append(text[begin:at])
            begin = at = at + len(separator)
        else:
            at += 1
    if quoted:
        raise bad_request("invalid quoting in q-item")
    return [*parts, text[begin:]]


def _literal(text: str) -> Json:
    if len(text) > 1 and text.startswith("'") and text.endswith("'"):
        return text[1:-1]
    if not text:
        raise bad_request("empty right-hand-side in q-item")
    words: dict[str, Json] = {"true": True, "false": False, "null": None}
    if text in words:
        return words[text]
    if re.fullmatch(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", text, re.ASCII):
        return float(text)
    return moment.parse(text) or text


def _same(found: Json, wanted: Json) -> bool:
    if isinstance(wanted, bool) or isinstance(found, bool) or wanted is None:
        return found is wanted
    left, right = _alike(found, wanted)
    return left is not None and bool(left == right)


def _alike(found: Json, wanted: Json) -> tuple[Json, Json]:
    """Return both in one kind that compares; ``None`` for what cannot be."""
    if isinstance(wanted, datetime):
        return (moment.parse(found), wanted) if isinstance(found, str) else (None, wanted)
    if isinstance(wanted, float):
        is_number = isinstance(found, int | float) and not isinstance(found, bool)
        return (found, wanted) if is_number else (None, wanted)
    return (found, wanted) if isinstance(found, str) and isinstance(wanted, str) else (None, wanted)


def _value_at(entity: Entity, path: tuple[str, ...]) -> Json:
    if path[0] in ("dateCreated", "dateModified"):
        return moment.text_of(entity.created if path[0] == "dateCreated" else entity.modified)
    if path[0] == "servicePath":
        return entity.key.path
    attribute = entity.attributes.get(path[0])
    return ABSENT if attribute is None else _inside(attribute.value, path[1:])


def _metadata_at(entity: Entity, path: tuple[str, ...]) -> Json:
    attribute = entity.attributes.get(path[0])
    if attribute is None:
        return ABSENT
    if path[1] in ("dateCreated", "dateModified"):
        return moment.text_of(attribute.created if path[1] == "dateCreated" else attribute.modified)
    item = attribute.metadata.get(path[1])
    return ABSENT if item is None else _inside(item.value, path[2:])


def _inside(value: Json, path: tuple[str, ...]) -> Json:
    for step in path:
        if not isinstance(value, dict) or step not in value:
            return ABSENT
        value = value[step]
    return value
