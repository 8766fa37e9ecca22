"""Queries: typed conditions become the broker's query string, escaped."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from datetime import datetime
from typing import TypeAlias

from backend_clients.ngsi.errors import BadInput
from backend_clients.ngsi.escaping import FORBIDDEN, escape, escape_key
from backend_clients.ngsi.identifier import check_id
from backend_clients.ngsi.location import GeoQuery
from backend_clients.ngsi.moment import moment_text

Literal: TypeAlias = str | float | bool | datetime | None
Path: TypeAlias = str | tuple[str, ...]  # an attribute, or an attribute and members of its value
DISTANCE = "geo:distance"


@dataclass(frozen=True, slots=True)
class Condition:
    """One condition, in the broker's words; made by the functions below."""

    text: str


def equals(path: Path, *values: Literal) -> Condition:
    """The value is one of ``values``."""
    if not values:
        raise BadInput("equals needs a value")
    return Condition(f"{_path(path)}=={','.join(_literal(value) for value in values)}")


def differs(path: Path, *values: Literal) -> Condition:
    """There is a value and it is none of ``values``."""
    if not values:
        raise BadInput("differs needs a value")
    return Condition(f"{_path(path)}!={','.join(_literal(value) for value in values)}")


def between(path: Path, low: float | datetime, high: float | datetime) -> Condition:
    """The value lies between both, or on one of them."""
    return Condition(f"{_path(path)}=={_literal(low)}..{_literal(high)}")


def greater(path: Path, limit: float | datetime) -> Condition:
    """The value is greater, or later."""
    return Condition(f"{_path(path)}>{_literal(limit)}")


def at_least(path: Path, limit: float | datetime) -> Condition:
    """The value is greater or equal, or not earlier."""
    return Condition(f"{_path(path)}>={_literal(limit)}")


def less(path: Path, limit: float | datetime) -> Condition:
    """The value is less, or earlier."""
    return Condition(f"{_path(path)}<{_literal(limit)}")


def at_most(path: Path, limit: float | datetime) -> Condition:
    """The value is less or equal, or not later."""
    return Condition(f"{_path(path)}<={_literal(limit)}")


def contains(path: Path, part: str) -> Condition:
    """The text has ``part`` somewhere in it."""
    if not part:
        raise BadInput("contains needs a text")
    return Condition(f"{_path(path)}~={re.escape(escape(part))}")


def matches(path: Path, pattern: str) -> Condition:
    """The text, as it is stored (escaped), has the regular expression in it."""
    return Condition(f"{_path(path)}~={check_pattern(pattern)}")


def exists(path: Path) -> Condition:
    """There is such an attribute, or member of its value."""
    return Condition(_path(path))


def absent(path: Path) -> Condition:
    """There is no such attribute, or member of its value."""
    return Condition(f"!{_path(path)}")


@dataclass(frozen=True, slots=True)
class Query:
    """Which entities, what of them, in which order. All parts must hold; empty parts hold always.

    Args:
        types: any of these types.
        ids: any of these ids.
        id_pattern: a regular expression found in the id; not together with ``ids``.
        where: conditions on attributes.
        where_metadata: conditions on metadata; a path is attribute and metadata name.
        place: a geo query.
        attrs: attributes to return, all if empty; ``dateModified`` and its kin only if named.
        metadata: metadata to return, all if empty.
        order_by: attributes, ``!`` before one turns it round.
    """

    types: tuple[str, ...] = ()
    ids: tuple[str, ...] = ()
    id_pattern: str = ""
    where: tuple[Condition, ...] = ()
    where_metadata: tuple[Condition, ...] = ()
    place: GeoQuery | None = None
    attrs: tuple[str, ...] = ()
    metadata: tuple[str, ...] = ()
    order_by: tuple[str, ...] = ()

    def parameters(self) -> dict[str, str]:
        """Return the query string's parameters, not yet percent-encoded; raises ``BadInput``."""
        if self.ids and self.id_pattern:
            raise BadInput("ids and id_pattern cannot be combined")
        if DISTANCE in self.order_by and len(self.order_by) > 1:
            raise BadInput(f"{DISTANCE} orders alone or not at all")
        parts = {
            "type": _names(self.types),
            "id": _names(self.ids),
            "idPattern": self.id_pattern,
            "q": ";".join(condition.text for condition in self.where),
            "mq": ";".join(condition.text for condition in self.where_metadata),
            "attrs": _names(self.attrs),
            "metadata": _names(self.metadata),
            "orderBy": _names(self.order_by),
        }
        place = self.place.parameters() if self.place else {}
        return {name: text for name, text in parts.items() if text} | place

    def steady(self) -> Query:
        """Return the query with an order that has no ties: without it, pages overlap or leave out.

        What is near comes nearest first; a broker knows no tie-breaker there.
        """
        if self.place is not None and self.place.georel.startswith("near") and not self.order_by:
            return replace(self, order_by=(DISTANCE,))
        if DISTANCE in self.order_by:
            return self
        ordered = {key.removeprefix("!") for key in self.order_by}
        return replace(self, order_by=(*self.order_by, *(key for key in ("id", "type") if key not in ordered)))


def _names(names: tuple[str, ...]) -> str:
    for name in names:
        if "," in check_id(name.removeprefix("!")):
            raise BadInput(f"a comma cannot be asked for in a list: {name!r}")
    return ",".join(names)


def _path(path: Path) -> str:
    first, *rest = (path,) if isinstance(path, str) else path
    return ".".join([_step(check_id(first)), *(_step(escape_key(step)) for step in rest)])


def _step(step: str) -> str:
    if not step or any(c in step for c in "'"):
        raise BadInput(f"cannot be asked for: {step!r}")
    return step if re.fullmatch(r"[A-Za-z0-9_]+", step) else f"'{step}'"


def _literal(value: Literal) -> str:
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, datetime):
        return moment_text(value)
    if isinstance(value, str):
        return f"'{escape(value)}'"
    if not math.isfinite(value):
        raise BadInput(f"not a number for a query: {value}")
    return repr(value)


def check_pattern(pattern: str) -> str:
    """Return a regular expression that a broker takes in a query; raises ``BadInput``."""
    if any(c in pattern for c in FORBIDDEN):
        raise BadInput(f"a pattern cannot have any of {FORBIDDEN}")
    try:
        re.compile(pattern)
    except re.error as error:
        raise BadInput(f"not a pattern: {error}") from error
    return pattern
